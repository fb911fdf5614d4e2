// Every verb that writes a file leaves stores alone, and files that are not its own.
#include <catch2/catch.hpp>
#include <filesystem>

#include "tests/bench/cli/play_table.h"
#include "tests/bench/cli/small_bench.h"

using namespace tactbench::tests;

namespace {

using Words = std::vector<std::string>;

// Up and down, and a smaller loop inside.
std::string loop_table() {
  std::string text = "sequence,input,output\n";
  for (const PlaySample& sample : play_samples({0, 10, 0, 10, 4, 10, 0}, 20))
    text += "a," + std::to_string(sample.input) + "," + std::to_string(sample.output) + "\n";
  return text;
}

// A store with a run and its fit, a table and a model.
void prepare_files(const TemporaryFolder& folder) {
  begin_bench(folder);
  write_file(folder.path("t.csv"), loop_table());
  measure_small(folder);
  REQUIRE(call(folder, {"fit", "1"}).code == 0);
  REQUIRE(call(folder, {"fit", "t.csv", "--model", "mpi", "-o", "m.json"}).code == 0);
  write_file(folder.path("suite.toml"), "schema = 1\nname = \"s\"\n[[scenario]]\nname = \"a\"\nabout = \"b\"\n");
}

const std::vector<Words>& writing_verbs() {
  static const std::vector<Words> verbs = {
      {"runs", "export", "1", "-o"},
      {"runs", "export", "1", "--format", "json", "-o"},
      {"report", "1", "-o"},
      {"report", "sign", "1", "--by", "C. Chief", "-o"},
      {"report", "1", "--format", "json", "-o"},
      {"trend", "--html"},
      {"fit", "t.csv", "--model", "mpi", "-o"},
      {"model", "export", "1", "-o"},
      {"model", "adjust", "m.json", "t.csv", "--zero", "-o"},
      {"predict", "m.json", "t.csv", "-o"},
      {"compensate", "m.json", "t.csv", "-o"},
      {"selfcheck", "-o"},
      {"simulate", "--for", "0.1", "--write-bench"},
      {"demo", "-q", "-o"},
      {"nightly", "./suite.toml", "--junit"},
      {"nightly", "./suite.toml", "--metrics"},
      {"nightly", "./suite.toml", "--html"},
      {"live", "--bench", "bench.toml", "--model", "1", "--frames", "1", "--csv"},
      {"devices", "calibrate-reference", "--bench", "bench.toml", "--gauge", "G", "--uncertainty", "0.1", "-o"},
  };
  return verbs;
}

}  // namespace

TEST_CASE("no verb overwrites a store, whatever its options") {
  const TemporaryFolder folder;
  prepare_files(folder);
  const std::string before = read_file(folder.path("runs.db"));
  std::filesystem::create_symlink("runs.db", folder.path("link"));
  for (const Words& verb : writing_verbs())
    for (const char* target : {"runs.db", "link"}) {
      INFO(verb[0] << " " << verb[1]);
      check_refusal(call(folder, joined_words(verb, {target, "--replace"})), 2, "TB-FILE-STORE");
      CHECK(read_file(folder.path("runs.db")) == before);
    }
  CHECK(std::filesystem::is_symlink(folder.path("link")));
  // init names its files itself.
  std::filesystem::create_directory(folder.path("sub"));
  std::filesystem::create_symlink("../runs.db", folder.path("sub/limits.toml"));
  check_refusal(call(folder, {"init", "sub", "--force"}), 2, "TB-FILE-STORE");
  CHECK(read_file(folder.path("runs.db")) == before);
}

TEST_CASE("a verb overwrites its own earlier output, and another file only on request") {
  const TemporaryFolder folder;
  prepare_files(folder);
  const std::string target = folder.path("target");
  for (const Words& verb : writing_verbs()) {
    if (verb[0] == "devices" || verb[0] == "demo" || verb[0] == "nightly" || verb[1] == "adjust") continue;
    INFO(verb[0] << " " << verb[1]);
    if (verb == Words{"report", "sign", "1", "--by", "C. Chief", "-o"}) continue;  // once only
    const auto written = [&](bool replace) {
      return call(folder, joined_words(verb, replace ? Words{"target", "--replace"} : Words{"target"}));
    };
    write_file(target, "dear diary\n");
    const Finished refused = written(false);
    CHECK(refused.code == 2);
    CHECK_THAT(refused.err, Catch::Contains("[TB-FILE-EXISTS]") && Catch::Contains("--replace"));
    CHECK(read_file(target) == "dear diary\n");
    well(written(true));
    const std::string kept = read_file(target);
    CHECK(kept != "dear diary\n");
    CHECK(written(false).code == 0);  // its own kind
    std::filesystem::remove(target);
  }
}
