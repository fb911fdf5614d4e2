// model list of a store whose models are known.
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
  Finished list(const std::vector<std::string>& more) const {
    return say(bench::add_model, joined_words({"model", "list"}, more));
  }
};

}  // namespace

TEST_CASE("model list as JSON: each model with its run, its sensor and the program that made it") {
  const StoreOfModels of;
  const nlohmann::json told = nlohmann::json::parse(of.list({"--json"}).out);
  CHECK(told.at("schema") == "tactbench.model.list");
  REQUIRE(told.at("models").size() == 4);
  CHECK(told.at("models").at(1) == nlohmann::json::parse(R"({"model": "1:2", "run": 1, "fit": 2, "kind": "dynamic",
    "sensor": "S-1", "origin": "simulated", "fitted_taxels": 5, "created": "2026-01-01T00:00:00Z",
    "program": "0.9.1"})"));
  CHECK(told.at("models").at(3).at("fitted_taxels") == 0);
  CHECK(nlohmann::json::parse(of.list({"--json", "3"}).out).at("models").size() == 2);
  CHECK(nlohmann::json::parse(of.list({"--json", "2"}).out).at("models").empty());
  check_refusal(of.list({"9"}), 2, "TB-STORE-NOT-FOUND");
  CHECK(of.list({}).code == 0);
  check_refusal(of.say(bench::add_model, {"model", "show", "2"}), 6, "TB-ANALYSIS-NO-FIT");
}
