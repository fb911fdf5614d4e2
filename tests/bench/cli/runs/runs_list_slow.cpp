// runs list: --verdict takes each word that a run is shown with.
#include <catch2/catch.hpp>
#include <map>
#include <nlohmann/json.hpp>

#include "analysis/judgement/verdict.h"
#include "tests/bench/cli/check_refusal.h"
#include "tests/db/store_example.h"

using namespace tactbench;
using namespace tactbench::tests;

namespace {

using RunNumbers = std::vector<std::int64_t>;

void add_judged_run(db::RunStore& store, const std::string& origin, const std::string& verdict) {
  db::RunRecord record = example_run();
  record.origin = origin;
  const std::int64_t run = store_example(store, record);
  db::VerdictRecord row{run, 0, "unfit_taxels", "array", 1.0, 1.5, "taxels", "simple", verdict, "limits", "sha"};
  if (!verdict.empty()) store.replace_verdicts(run, 0, {row});
}

}  // namespace

TEST_CASE("runs list: --verdict accepts each word of a verdict and finds its runs") {
  const TemporaryFolder folder;
  {
    db::RunStore store = db::RunStore::open(folder.path("runs.db"), db::Durability::kNormal);
    for (const char* origin : {"simulated", "hardware"}) {
      for (const std::string& word : analysis::verdict_words()) add_judged_run(store, origin, word);
      add_judged_run(store, origin, "");
    }
  }
  const auto listed = [&](const std::string& word) {
    const auto document = nlohmann::json::parse(well(call(folder, {"runs", "list", "--json", "--verdict", word})).out);
    RunNumbers runs;
    for (const auto& run : document["runs"]) runs.push_back(run["run"].get<std::int64_t>());
    return runs;
  };
  std::map<std::int64_t, std::string> shown;
  const auto all = nlohmann::json::parse(call(folder, {"runs", "list", "--json"}).out);
  for (const auto& run : all.at("runs")) shown[run.at("run")] = run.at("verdict");
  REQUIRE(shown.size() == 12);
  CHECK(shown.at(2) == "simulated conditional pass");
  CHECK(shown.at(6) == "-");
  CHECK(shown.at(8) == "conditional pass");
  for (const auto& [number, word] : shown) {
    RunNumbers same;  // without "simulated" those of every origin
    for (const auto& [other, its_word] : shown)
      if (its_word == word || its_word == "simulated " + word) same.push_back(other);
    CHECK(listed(word) == same);
  }
  CHECK(listed("none") == RunNumbers{6, 12});
  CHECK(listed("conditional-fail") == RunNumbers{3, 9});
  CHECK(listed("simulated-inconclusive") == RunNumbers{4});
  for (const char* wrong : {"good", "report only", "conditional", "condtional pass"}) {
    INFO(wrong);
    check_refusal(call(folder, {"runs", "list", "--verdict", wrong}), 2, "TB-USAGE", "--verdict");
  }
}
