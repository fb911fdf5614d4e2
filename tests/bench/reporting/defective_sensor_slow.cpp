// A sensor with defects of every kind, from the run to the report: what was planted is named, and nothing else.
#include <algorithm>
#include <cctype>
#include <cmath>
#include <functional>
#include <nlohmann/json.hpp>
#include <set>
#include <utility>

#include "bench/reporting/evaluation.h"
#include "bench/run/recipe_check.h"
#include "tests/analysis/report/report_page.h"
#include "tests/support/process.h"
#include "tests/support/small_run.h"

using namespace tactbench;
using namespace tactbench::tests;
using bench::TaxelDefect;
using nlohmann::json;

namespace {

constexpr int kDeadTaxel = 2 * 16 + 5, kStuckTaxel = 7 * 16 + 9, kNoisyTaxel = 8 * 16 + 12,
              kSaturatedTaxel = 13 * 16 + 1;

void plant_taxels(std::vector<TaxelDefect>& defects) {
  using Kind = TaxelDefect::Kind;
  for (const auto& [kind, taxel] : {std::pair{Kind::kDead, kDeadTaxel},
                                    {Kind::kStuck, kStuckTaxel},
                                    {Kind::kNoisy, kNoisyTaxel},
                                    {Kind::kSaturated, kSaturatedTaxel}})
    defects.push_back({kind, taxel / 16, taxel % 16});
}

void swap_rows(std::vector<TaxelDefect>& defects, int row, int other) {
  for (int column = 0; column < 16; ++column)
    defects.push_back({TaxelDefect::Kind::kSwapped, row, column, other, column});
}

std::int64_t run_with(db::RunStore& store, std::uint64_t seed,
                      const std::function<void(std::vector<TaxelDefect>&)>& plant) {
  bench::RunRequest request = small_request({}, {seed, 7});
  request.recipes =
      bench::read_recipes({"loops"}, {{"turning_points", "[0, 60, 0, 40, 0, 60, 20, 60, 0]"}, {"dwell_s", "1"}});
  request.check_seating = true;
  plant(request.bench.simulation->plant.specimen.defects);
  const bench::RunResult result = run_small(request, store);
  INFO((result.error ? result.error->what() : ""));
  REQUIRE(!result.error);
  return result.run;
}

struct JudgedReport {
  analysis::SensorModel fit;
  analysis::ReportInput input;
  analysis::Report report;
  json data;
};

// As fit and report do it.
JudgedReport judged_report(db::RunStore& store, std::int64_t run, const std::string& previous = {},
                           const std::vector<std::int64_t>& held_out = {}) {
  JudgedReport out;
  analysis::Runs runs(store);
  out.fit = bench::fit_run(store, runs.dataset(run));
  const std::vector<bench::NamedEvaluation> evaluations = bench::evaluate_runs(runs, out.fit, held_out);
  const bench::Judged judgement = bench::judge_and_store(store, runs, out.fit, evaluations, "limits.toml");
  bench::ReportExtras extras;
  extras.previous = previous;
  out.input = bench::report_input(runs, run, out.fit, evaluations, judgement, {}, &extras);
  out.report = analysis::render_report(out.input);
  out.data = json::parse(out.report.json);
  return out;
}

using Findings = std::set<std::pair<int, std::string>>;

Findings findings_of(const json& health) {
  Findings out;
  for (const json& finding : health["findings"]) out.emplace(finding["taxel"], finding["state"]);
  CHECK(out.size() == health["findings"].size());
  return out;
}

Findings planted() {
  return {{kDeadTaxel, "dead"}, {kStuckTaxel, "stuck"}, {kNoisyTaxel, "noisy"}, {kSaturatedTaxel, "saturated"}};
}

void check_page(const std::string& page) {
  analysis::require_well_formed(page);
  analysis::require_inert(page);
  for (const char* cell : {">nan<", ">-nan<", ">inf<", ">-inf<", ">null<"}) CHECK_FALSE(analysis::contains(page, cell));
}

// The figures of the array are those of the taxels that are well, recomputed from the frames.
void check_left_out(const JudgedReport& judged, const analysis::Dataset& dataset) {
  const std::set<int> left_out = {kDeadTaxel, kStuckTaxel, kSaturatedTaxel};
  const json &raw = judged.data["sections"]["raw"], &results = judged.data["results"];
  CHECK(raw["taxels"].size() == 253);
  for (int taxel = 0; taxel < 256; ++taxel) {
    const auto at = static_cast<std::size_t>(taxel);
    CHECK(raw["gain"][at].is_null() == left_out.contains(taxel));
    CHECK(results["taxel_mean_error_psi"][at].is_null() == left_out.contains(taxel));
    CHECK((judged.fit.taxels[at].status == analysis::TaxelStatus::kFitted) == !left_out.contains(taxel));
  }
  const analysis::SequenceData& sequence = dataset.sequences.front();
  const json& trace = raw["traces"][0]["output_v"];
  REQUIRE(trace.size() == sequence.repeats.front().steps.size());
  for (std::size_t step = 0; step < trace.size(); ++step) {
    double well = 0.0, all = 0.0;
    for (const analysis::Repeat& repeat : sequence.repeats) {
      for (std::size_t taxel = 0; taxel < 256; ++taxel) {
        const double share = repeat.volts[step * 256 + taxel] / static_cast<double>(sequence.repeats.size());
        all += share / 256.0;
        if (!left_out.contains(static_cast<int>(taxel))) well += share / 253.0;
      }
    }
    CHECK(trace[step].get<double>() == Approx(well).margin(1e-6));
    if (step == 0) CHECK(all > well + 0.015);  // three volts of stuck and saturated taxels
  }
}

}  // namespace

TEST_CASE("a report of a defective sensor names the planted defects and no others, and leaves them out") {
  const TemporaryFolder folder;
  db::RunStore store = db::RunStore::open(folder.path("runs.db"), db::Durability::kNormal);
  const std::int64_t good = run_with(store, 1, [](auto&) {});
  const std::int64_t bad = run_with(store, 2, [](std::vector<TaxelDefect>& defects) {
    swap_rows(defects, 3, 11);
    plant_taxels(defects);
  });
  (void)bench::fit_run(store, analysis::load_dataset(store, good));
  const std::int64_t held_out = run_with(store, 3, [](std::vector<TaxelDefect>& defects) {
    swap_rows(defects, 3, 11);
    plant_taxels(defects);
  });
  const JudgedReport judged = judged_report(store, bad, std::to_string(good), {held_out});
  const json& health = judged.data["sections"]["health"];
  CHECK(findings_of(health) == planted());
  for (const json& finding : health["findings"]) {
    CHECK(finding["excluded"].get<bool>() == (finding["state"] != "noisy"));
    CHECK_FALSE(finding["reason"].get<std::string>().empty());
  }
  CHECK(health["swaps_assessed"] == true);
  REQUIRE(health["swaps"].size() == 1);
  CHECK(health["swaps"][0]["lines"] == "rows");
  CHECK(health["swaps"][0]["first"] == 3);
  CHECK(health["swaps"][0]["second"] == 11);
  CHECK(health["swaps"][0]["correlation_exchanged"].get<double>() > 0.95);
  check_left_out(judged, analysis::load_dataset(store, bad));

  // As found: the models of the good run, over the same taxels; those of the exchanged rows fit no more.
  CHECK(judged.data["sections"]["as_found"]["fitted_taxels"] == 253);
  REQUIRE(judged.input.more.previous.has_value());
  const analysis::Evaluation& found = judged.input.more.previous->evaluation;
  for (const std::size_t taxel : {kDeadTaxel, kStuckTaxel, kSaturatedTaxel})
    CHECK(std::isnan(found.taxel_mean_error_psi[taxel]));
  CHECK(found.mean_error_psi > 3.0 * judged.input.evaluation.mean_error_psi);

  check_page(judged.report.html);
  const auto overall = std::ranges::find(judged.input.judgement.figures, analysis::Criterion::kUnfitTaxels,
                                         &analysis::JudgedFigure::criterion);
  REQUIRE(overall != judged.input.judgement.figures.end());
  CHECK(overall->verdict == analysis::Verdict::kFail);
  CHECK(overall->value == 3.0);

  // The run before it has none of all that, and nothing to compare its lines with.
  const JudgedReport well = judged_report(store, good);
  CHECK(well.data["sections"]["health"]["findings"].empty());
  CHECK(well.data["sections"]["health"]["swaps_assessed"] == false);
  check_page(well.report.html);
}
