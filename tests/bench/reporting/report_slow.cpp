// A sensor with defects of every kind, from the run to the report: what was planted is named, and nothing else.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cctype>
#include <cmath>
#include <functional>
#include <nlohmann/json.hpp>
#include <set>
#include <utility>

#include "analysis/identify/stored/model_document.h"
#include "analysis/statistics/figures/evaluation.h"
#include "analysis/statistics/studies/contact.h"
#include "bench/reporting/evaluation.h"
#include "bench/run/recipe_check.h"
#include "tests/analysis/report/report_example.h"
#include "tests/bench/run/quick_store.h"
#include "tests/support/process.h"
#include "tests/support/run_recipe.h"
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
  const bench::JudgementRecord judgement = bench::judge_and_store(store, runs, out.fit, evaluations, "limits.toml");
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

TEST_CASE("report: of a defective sensor it lists exactly the planted defects, and excludes those taxels") {
  QuickStore store;
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

// Models compared, compensation, studies and objects: every figure of the report against the one recomputed from the
// store that it was made from.

namespace {

const char* const kLoops =
    "schema = 1\nname = \"loops\"\nunit = \"psi\"\nturning_points = [0, 60, 20, 60, 0, 60, 40, 60, 0]\nstep = 4\n"
    "repeats = 2\ndwell_s = 1.0\n[conditioning]\ncycles = 2\npeak = 60\n";

void check_as_found(const json& report, const analysis::Evaluation& found) {
  const json& data = report["sections"]["as_found"];
  CHECK(data["mean_error_psi"].get<double>() == Approx(found.mean_error_psi).epsilon(1e-9));
  REQUIRE(data["levels"].size() == found.levels.size());
  for (std::size_t i = 0; i < found.levels.size(); ++i)
    CHECK(data["levels"][i]["comp_distance_fs"].get<double>() == Approx(found.levels[i].comp_distance).epsilon(1e-9));
}

// Forces from the frames' counts alone, by the scale that the run keeps.
void check_contact(const json& report, const db::RunStore& store, std::int64_t run, const analysis::SensorModel& fit) {
  const auto& contacts = report["sections"]["objects"];
  const auto ring = std::ranges::find_if(contacts, [](const json& contact) { return contact["object"] == "ring"; });
  REQUIRE(ring != contacts.end());
  const double scale =
      analysis::load_press_runs(analysis::read_run(store, store.run(run))).front().frames.front().volts.front() / [&] {
        const db::FrameRecord first = store.frames(run).front();
        return 0.5 * (first.counts[0] + first.counts[256]);
      }();
  const analysis::ModelTaxel& mean = fit.mean_taxel();
  double error = 0.0, n = 0.0;
  for (const db::FrameRecord& frame : store.frames(run)) {
    double total = 0.0;
    for (std::size_t taxel = 0; taxel < 256; ++taxel) {
      const double volts = scale * 0.5 * (frame.counts[taxel] + frame.counts[256 + taxel]);
      total += (volts - mean.y0()) / (mean.yu() - mean.y0()) * 60.0 * 6.4516 * analysis::kNewtonPerPsiMm2;
    }
    error += std::abs(total + frame.wrench->wrench[2]);  // pressing is negative in z
    n += 1.0;
  }
  CHECK((*ring)["raw_mean_error_n"].get<double>() == Approx(error / n).epsilon(1e-6));
  CHECK((*ring)["compensated_mean_error_n"].get<double>() < 0.25 * error / n);
  CHECK((*ring)["levels"].size() == 9);
  for (const json& level : (*ring)["levels"]) {
    double force = 0.0, along = 0.0, in_contact = 0.0, peak = 0.0;
    for (const json& pressure : level["compensated_psi"]) peak = std::max(peak, pressure.get<double>());
    for (std::size_t taxel = 0; taxel < 256; ++taxel) {
      const double pressure = level["compensated_psi"][taxel];
      force += pressure * 6.4516 * analysis::kNewtonPerPsiMm2;
      if (pressure < std::max(0.5, 0.1 * peak)) continue;
      along += pressure * (static_cast<double>(taxel % 16) - 7.5) * 2.54;
      in_contact += pressure;
    }
    CHECK(level["compensated"]["force_n"].get<double>() == Approx(force).epsilon(1e-4));
    CHECK(level["compensated"]["x_mm"].get<double>() == Approx(along / in_contact).margin(0.01));
    // The rig's ring stands on the array's middle, and registration says so; light touches scatter.
    if (level["target_n"].get<double>() >= 10.0) CHECK(level["compensated_place_error_mm"].get<double>() < 1.0);
  }
}

}  // namespace

TEST_CASE("report: models, compensation, studies and objects equal those computed from the store") {
  const TemporaryFolder folder;
  init_bench(folder);
  write_file(folder.path("loops.toml"), kLoops);
  run_recipe(folder, "loops.toml", {"--seed", "1"});
  run_recipe(folder, "loops.toml",
             {"--seed", "2", "--set", "simulation.mount_seed=1", "--set", "simulation.effects.remount_variation=0.03"});
  run_recipe(folder, "register");
  run_recipe(folder, "ring", {"--set", "recipe.repeats=1"});
  run_recipe(folder, "point-grid", {"--set", "simulation.effects.row_crosstalk=0.1"});
  run_recipe(folder, "rate-ramp");
  for (const char* run : {"1", "2"}) REQUIRE(call(folder, {"fit", run, "--model", "elam"}).code == 0);

  const json report = report_data(
      folder, {"report", "2", "--previous", "1", "--held-out", "1", "--studies", "3", "4", "5", "6", "1:mount"});
  const db::RunStore store = db::RunStore::open_read_only(folder.path("runs.db"));
  const analysis::Dataset dataset = analysis::load_dataset(store, 2);
  const analysis::SensorModel fit = analysis::load_fit(store, 2), previous = analysis::load_fit(store, 1);
  check_as_found(report, analysis::evaluate(dataset, previous));
  check_contact(report, store, 4, fit);

  const json& studies = report["sections"]["studies"];
  CHECK(studies["uniformity"].contains("not_assessed"));
  // 3 % of pressure change by mount; two mounts are one degree of freedom.
  CHECK(studies["remount"]["degrees"] == 1);
  CHECK(studies["remount"]["s_share"].get<double>() == Approx(0.03).epsilon(0.5));
  const analysis::SweepEstimates a = analysis::sweep_estimates(dataset, fit);
  const analysis::SweepEstimates b = analysis::sweep_estimates(analysis::load_dataset(store, 1), fit);
  double squares = 0.0;
  for (int taxel = 0; taxel < 256; ++taxel) squares += std::pow(a.mean(10, taxel) - b.mean(10, taxel), 2) / 2.0 / 256.0;
  CHECK(studies["remount"]["pressure_psi"][9].get<double>() == 40.0);
  CHECK(studies["remount"]["between_psi"][9].get<double>() == Approx(std::sqrt(squares)).epsilon(0.1));
  // A tenth of the mean of fifteen others: two of them pressed.
  CHECK(studies["crosstalk"]["row"]["mean_share"].get<double>() > 0.005);
  CHECK(std::abs(studies["crosstalk"]["column"]["mean_share"].get<double>()) < 0.003);
  REQUIRE(studies["rate_hold"].size() == 1);
  double errors = 0.0;
  for (const json& bin : studies["rate_hold"][0]["by_rate_psi_per_s"])
    errors += bin["samples"].get<double>() * bin["mean_psi"].get<double>();
  CHECK(errors > 0.0);
}

TEST_CASE("as found: earlier models give the same result as a file and as a stored fit") {
  const TemporaryFolder folder;
  init_bench(folder);
  write_file(folder.path("loops.toml"), kLoops);
  run_recipe(folder, "loops.toml", {"--set", "recipe.repeats=1"});
  REQUIRE(call(folder, {"fit", "1"}).code == 0);
  REQUIRE(call(folder, {"model", "export", "1", "-o", "m.json"}).code == 0);
  const json from_store = report_data(folder, {"report", "1", "--previous", "1"});
  const json from_file = report_data(folder, {"report", "1", "--previous", "m.json"});
  const json &a = from_store["sections"]["as_found"], &b = from_file["sections"]["as_found"];
  CHECK(a == b);
  // Found with its own models, the run is as it was left.
  CHECK(a["mean_error_psi"] == from_store["results"]["evaluation"]["mean_error_psi"]);
  for (const char* study : {"1:upside-down", "1:mount"})
    CHECK(call(folder, {"report", "1", "--studies", study}).code == 2);
}
