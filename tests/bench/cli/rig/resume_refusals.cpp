// What resume refuses of a stored run before any device is opened.
#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "bench/config/config.h"
#include "tests/bench/cli/store_here.h"

using namespace tactbench;
using namespace tactbench::tests;

namespace {

// A store whose one run has these settings and is of the simulated bench.
struct StoreToResume : OpenStoreHere {
  explicit StoreToResume(const std::string& overrides) {
    db::RunRecord run = example_run();
    run.overrides_json = overrides;
    run.bench_id = "another-rig";
    run.bench_toml = read_file(bench::find_config("simulated.toml"));
    (void)begin_example(store, run);
  }
  Finished resume(const std::vector<std::string>& more = {}) const {
    std::vector<std::string> words = {"resume", "1"};
    words.insert(words.end(), more.begin(), more.end());
    return say(bench::add_control, words);
  }
};

}  // namespace

TEST_CASE("resume: broken settings, and a bench that is another") {
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
  check_refusal(store.say(bench::add_control, {"resume", "9"}), 2, "TB-STORE-NOT-FOUND");
}
