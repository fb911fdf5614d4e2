// What resume refuses of a stored run before any device is opened.
#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "bench/config/config.h"
#include "tests/bench/cli/verb_here.h"
#include "tests/db/store_example.h"

using namespace tactbench;
using namespace tactbench::tests;

namespace {

// A store whose one run has these settings and is of the simulated bench.
struct StoreToResume {
  explicit StoreToResume(const std::string& overrides) {
    db::RunRecord run = example_run();
    run.overrides_json = overrides;
    run.bench_id = "another-rig";
    run.bench_toml = read_file(bench::find_config("simulated.toml"));
    (void)begin_example(store, run);
  }
  Finished resume(const std::vector<std::string>& more = {}) const {
    std::vector<std::string> words = {"resume", "1", "--db", folder.path("runs.db")};
    words.insert(words.end(), more.begin(), more.end());
    return verb_here(bench::add_control, words);
  }
  TemporaryFolder folder;
  db::RunStore store = db::RunStore::open(folder.path("runs.db"), db::Durability::kNormal);
};

}  // namespace

TEST_CASE("resume: settings that cannot be read, and a bench that is another") {
  for (const char* broken : {"{", "7", R"([{"key":"a"}])", R"([{"key":1,"value":"1"}])"}) {
    INFO(broken);
    const StoreToResume store(broken);
    check_refusal(store.resume(), 5, "TB-RESUME-SETTINGS");
  }
  const StoreToResume store("[]");
  CHECK_THAT(store.resume().err, Catch::Contains("[TB-RESUME-BENCH]"));
  check_refusal(store.resume({"--bench", "simulated.toml"}), 2, "TB-RESUME-BENCH", "simulated.toml");
  const StoreToResume settings(R"([{"key":"limits.comand_psi","value":"1"}])");
  CHECK_THAT(settings.resume().err, Catch::Contains("[TB-FILE-KEY]") && Catch::Contains("limits.comand_psi"));
  CHECK_THAT(verb_here(bench::add_control, {"resume", "9", "--db", store.folder.path("runs.db")}).err,
             Catch::Contains("[TB-STORE-NOT-FOUND]"));
}
