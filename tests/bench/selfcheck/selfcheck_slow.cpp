// The validation record: every check passes on a sound installation, and what is broken is named.
#include <catch2/catch.hpp>
#include <filesystem>
#include <iterator>
#include <map>
#include <nlohmann/json.hpp>
#include <string>

#include "tests/support/paths.h"
#include "tests/support/process.h"

using namespace tactbench::tests;

TEST_CASE("selfcheck: all checks pass here, the file equals the printed document, and no other file is left") {
  const TemporaryFolder folder;
  const Finished finished = run_program(program_path(), {"selfcheck", "--json", "-o", "record.json"}, folder.path());
  INFO(finished.out << finished.err);
  REQUIRE(finished.code == 0);
  const nlohmann::json record = nlohmann::json::parse(finished.out);
  CHECK(record == nlohmann::json::parse(read_file(folder.path("record.json"))));
  CHECK(record["schema"] == "tactbench.selfcheck");
  CHECK(record["failed"] == 0);
  CHECK(record["libraries"].size() >= 10);
  std::map<std::string, int> areas;
  for (const nlohmann::json& check : record["checks"]) {
    CHECK(check["pass"] == true);
    ++areas[check["area"].get<std::string>()];
  }
  CHECK(areas == std::map<std::string, int>{{"model", 12}, {"run", 3}});
  CHECK(std::distance(std::filesystem::directory_iterator(folder.path()), {}) == 1);  // the record, and nothing else
}

TEST_CASE("selfcheck: with an invalid bench file the run checks fail, with exit code 1") {
  const TemporaryFolder folder;
  std::filesystem::create_directories(folder.path("share/bench"));
  std::filesystem::copy(source_path("bench/config"), folder.path("share/bench/config"));
  write_file(folder.path("share/bench/config/simulated.toml"), "schema = 1\n");
  const Finished finished =
      run_program("/usr/bin/env", {"TACTBENCH_SHARE=" + folder.path("share"), program_path(), "selfcheck", "--json"},
                  folder.path());
  CHECK(finished.code == 1);
  const nlohmann::json record = nlohmann::json::parse(finished.out);
  CHECK(record["failed"] == 3);
  for (const nlohmann::json& check : record["checks"]) CHECK(check["pass"] == (check["area"] != "run"));
}

TEST_CASE("selfcheck: a file of another kind is not overwritten") {
  const TemporaryFolder folder;
  write_file(folder.path("mine.txt"), "mine\n");
  const Finished finished = run_program(program_path(), {"selfcheck", "-o", "mine.txt"}, folder.path());
  CHECK(finished.code == 2);
  CHECK_THAT(finished.err, Catch::Contains("TB-FILE-EXISTS"));
  CHECK(read_file(folder.path("mine.txt")) == "mine\n");
}
