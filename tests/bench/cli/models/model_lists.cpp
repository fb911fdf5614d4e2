// The models of a run that `runs show` lists, of a store whose models are known.
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/bench/cli/store_here.h"

using namespace tactbench;
using namespace tactbench::tests;

namespace {

// Runs 1 and 3 have models, run 2 none.
struct StoreOfModels : OpenStoreHere {
  StoreOfModels() {
    for (int run = 0; run < 3; ++run) (void)store_example(store);
    add(1, "elam", 3);
    add(1, "dynamic", 5);
    add(3, "a long name of a model", 0);
    add(3, "gpi", 0);
  }
  void add(std::int64_t run, const std::string& model, int fitted) {
    (void)store.add_fit({0, run, model, true, fitted, "{}", "", "0.9.1", kUtc});
  }
};

}  // namespace

TEST_CASE("runs show: each model of the run with its number, kind and taxels") {
  const StoreOfModels of;
  const auto models = [&](const char* run) {
    return nlohmann::json::parse(of.say(bench::add_runs, {"runs", "show", run, "--json"}).out).at("models");
  };
  REQUIRE(models("1").size() == 2);
  const nlohmann::json second = models("1").at(1);
  CHECK((second.at("model") == "1:2" && second.at("kind") == "dynamic" && second.at("fitted_taxels") == 5));
  CHECK(models("2").empty());
  CHECK(models("3").size() == 2);
  check_refusal(of.say(bench::add_model, {"model", "show", "2"}), 6, "TB-ANALYSIS-NO-FIT");
}
