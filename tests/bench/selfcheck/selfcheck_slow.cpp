// The validation record: every check passes on a sound installation, and what is broken is named.
#include <catch2/catch.hpp>
#include <filesystem>
#include <iterator>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "db/run_store.h"
#include "tests/support/paths.h"
#include "tests/support/process.h"

using namespace tactbench::tests;
using nlohmann::ordered_json;

namespace {

Finished selfcheck_in(const TemporaryFolder& folder, std::vector<std::string> more) {
  more.insert(more.begin(), "selfcheck");
  return run_program(program_path(), more, folder.path());
}

}  // namespace

TEST_CASE("selfcheck: all pass here, and the record carries its own hash") {
  const TemporaryFolder folder;
  const Finished finished = selfcheck_in(folder, {"--json", "-o", "record.json"});
  INFO(finished.out << finished.err);
  REQUIRE(finished.code == 0);
  ordered_json record = ordered_json::parse(finished.out);
  CHECK(record == ordered_json::parse(read_file(folder.path("record.json"))));
  CHECK(record["schema"] == "tactbench.selfcheck");
  CHECK(record["failed"] == 0);
  CHECK(record["libraries"].size() >= 10);
  std::map<std::string, int> areas;
  std::string said;  // what is the same on each machine
  std::vector<std::string> of_models_and_runs;
  for (const auto& check : record["checks"]) {
    CHECK(check["pass"] == true);
    const std::string area = check["area"];
    ++areas[area];
    if (area == "identification" || area == "inverse" || area == "run") of_models_and_runs.push_back(check["checked"]);
    said += area + ": " + check["expected"].get<std::string>() + "; " + check["found"].get<std::string>() + "\n";
  }
  // The lengths of the walks were computed in Python from the same seeds.
  for (const char* line :
       {"clock: 0 backwards, ticks below 100000 ns; 0 backwards, ", "clock: at most 3 ms apart; ",
        "store: each is acknowledged, in less than 500 ms; ",
        "store: 60 of 60 frames equal, content hash holds, structure sound; 60 of 60 frames equal, content hash holds, "
        "structure sound\n",
        "store: the frame is named, 6 of 6; 6 of 6 named; the last: ", " frame 56 (",
        "identification: 5 parameters within 0.0001 of their ranges or values, outputs on 20 other histories within "
        "1e-06 "
        "of full scale; parameters within ",
        "identification: 2 parameters within 0.0001 of their ranges or values, outputs on 20 other histories within "
        "1e-06 "
        "of full scale; parameters within ",
        "identification: 5 parameters within 0.001 of their ranges or values, outputs on 20 other histories within "
        "1e-06 "
        "of full scale; parameters within ",
        "identification: outputs on 20 other histories within 1e-07 of full scale; outputs within ",
        "dispatch: 0 frames differ; 0 of 1732 frames differ\n", " of 29256 samples\n",
        "run: completed, 106 frames, safe state verified; completed, 106 frames, safe state verified\n",
        "run: content as stored, fit equal; content as stored, fit equal; ",
        "run: the same content hash; the same: "}) {
    INFO(line << " in " << said);
    CHECK(said.find(line) != std::string::npos);
  }
  CHECK(of_models_and_runs ==
        std::vector<std::string>{
            "elam from noiseless data of a known elam", "gpi from noiseless data of a known gpi",
            "mpi from noiseless data of a known mpi", "poly from noiseless data of a known poly",
            "elam: direct of inverse on 200 random histories", "gpi: direct of inverse on 200 random histories",
            "mpi: direct of inverse on 200 random histories", "poly: direct of inverse on 200 random histories",
            "0-60-20-60-0-30-0 psi twice on the simulated rig: Modbus TCP and HID reports",
            "its 256 taxels fitted and stored, then verified from the raw frames",
            "the same run again, in another store"});
  CHECK(areas["identification"] == 4);
  CHECK(areas["inverse"] == 4);
  CHECK(areas["store"] == 4);
  CHECK(areas["run"] == 3);
  for (const char* area : {"clock", "dispatch", "compensator"}) CHECK(areas[area] >= 1);
  const std::string hash = record["sha256"];
  record.erase("sha256");
  CHECK(hash == tactbench::db::sha256_hex(record.dump()));
  CHECK(std::distance(std::filesystem::directory_iterator(folder.path()), {}) == 1);  // the record, and nothing else
}

TEST_CASE("selfcheck: a failed check is named in the text and gives exit code 1") {
  const TemporaryFolder folder;
  std::filesystem::create_directories(folder.path("share/bench"));
  std::filesystem::copy(source_path("bench/config"), folder.path("share/bench/config"));
  write_file(folder.path("share/bench/config/simulated.toml"), "schema = 1\n");
  const Finished finished = run_program(
      "/usr/bin/env",
      {"TACTBENCH_SHARE=" + folder.path("share"), program_path(), "selfcheck", "-o", folder.path("record.txt")},
      folder.path());
  CHECK(finished.code == 1);
  CHECK_THAT(finished.out, Catch::Contains("FAIL  run: ") && Catch::Contains("could not be checked: ") &&
                               Catch::Contains("pass  identification: elam") && Catch::Contains("3 failed"));
  CHECK(read_file(folder.path("record.txt")) == finished.out);
  const Finished nowhere = selfcheck_in(folder, {"--db", folder.path("no/such/runs.db")});
  CHECK(nowhere.code == 2);
  CHECK_THAT(nowhere.err, Catch::Contains("TB-FILE-WRITE"));
}
