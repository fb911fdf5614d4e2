// The data of a report's results and identification by hand: levels, models, judgement, history, laboratory, hashes.
#include <catch2/catch.hpp>
#include <functional>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>
#include <set>
#include <string>

#include "analysis/report/data/judged_runs.h"
#include "analysis/report/data/section_data.h"
#include "analysis/report/parts.h"
#include "tests/analysis/support/judged_figures.h"
#include "tests/analysis/support/sensor_models.h"

using namespace tactbench;
using namespace tactbench::analysis;

namespace {

constexpr double kNoResult = std::numeric_limits<double>::quiet_NaN();

ModelTaxel small_taxel(double of) {
  const std::vector<double> x = {0.0, 30.0, 60.0}, up = {0.0, 0.5 * of, 2.0 * of}, down = {0.0, 1.5 * of, 2.0 * of};
  ModelTaxel taxel = by_hand::elam_taxel(PatternCurve(x, up, 0.0, 2.0 * of), PatternCurve(x, down, 0.0, 2.0 * of),
                                         {0.5, 0.25, -0.125, 0.75, 0.0625});
  taxel.fit.at_bound = 5;
  taxel.fit.j = 0.1;
  taxel.fit.mean_error = 0.2;
  taxel.fit.max_error = 0.3;
  taxel.noise = 0.001;
  return taxel;
}

SensorModel small_model() {
  SensorModel fit;
  fit.model = "elam";
  fit.rows = 1;
  fit.columns = 2;
  fit.pressure_psi = {0.0, 30.0, 60.0};
  fit.taxels = {small_taxel(1.0), by_hand::left_out(TaxelStatus::kDead)};
  by_hand::finish(fit, small_taxel(0.5));
  return fit;
}

nlohmann::json results_of_input(const ReportInput& input) { return nlohmann::json::parse(results_json(input)); }

}  // namespace

TEST_CASE(
    "data of results by hand: each figure of a level, frames, traces, errors, the largest one where it is known") {
  ReportInput input;
  input.fit = small_model();  // one fitted taxel
  LevelFigures level;
  level.pressure_psi = 30.0;
  level.up_psi = 30.1;
  level.down_psi = 29.9;
  level.raw_std_up = 0.01;
  level.raw_std_down = 0.02;
  level.raw_distance = 0.03;
  level.raw_mean_distance = 0.04;
  level.comp_std_up = 0.05;
  level.comp_std_down = 0.015;
  level.comp_distance = 0.07;
  level.comp_mean_distance = 0.08;
  level.worst_taxel_distance = 0.09;
  level.made_worse = true;
  level.comp_distance_observable = 0.11;
  level.worst_taxel_distance_observable = 0.12;
  level.raw_up_v = {1.0, 0.5};
  level.raw_down_v = {1.5, 0.25};
  level.comp_up_psi = {31.0, kNoResult};
  level.comp_down_psi = {29.0, kNoResult};
  Evaluation& e = input.evaluation;
  e.levels = {level, level};
  e.levels[1].flat_taxels = 1;  // all that are fitted
  e.traces = {{"up", {0.0, 60.0}, {0.0, 2.0}, {0.1, 2.1}, {1.0, 59.0}}};
  e.taxel_mean_error_psi = {0.5, kNoResult};
  const auto data = results_of_input(input);
  CHECK(data["evaluation"]["levels"][0] == nlohmann::json::parse(R"({"pressure_psi":30.0,"up_psi":30.1,"down_psi":29.9,
    "raw_std_up_fs":0.01,"raw_std_down_fs":0.02,"raw_distance_fs":0.03,"raw_mean_distance_fs":0.04,
    "comp_std_up_fs":0.05,"comp_std_down_fs":0.015,"comp_distance_fs":0.07,"comp_mean_distance_fs":0.08,
    "comp_distance_observable_fs":0.11,"worst_taxel_distance_fs":0.09,"worst_taxel_distance_observable_fs":0.12,
    "made_worse":true,"std_up_made_worse":true,"std_down_made_worse":false,"flat_taxels":0})"));
  CHECK(data["evaluation"]["levels"][1]["comp_distance_observable_fs"].is_null());
  CHECK(data["evaluation"]["levels"][1]["worst_taxel_distance_observable_fs"].is_null());
  CHECK(data["evaluation"]["levels_made_worse_psi"].size() == 2);
  CHECK(data["frames"].size() == 2);
  CHECK(data["frames"][0] == nlohmann::json::parse(R"({"pressure_psi":30.0,"raw_up_v":[1,0.5],"raw_down_v":[1.5,0.25],
                                                      "comp_up_psi":[31,null],"comp_down_psi":[29,null]})"));
  CHECK(data["traces"] == nlohmann::json::parse(R"([{"sequence":"up","pressure_psi":[0,60],"measured_v":[0,2],
                                                    "model_v":[0.1,2.1],"compensated_psi":[1,59]}])"));
  CHECK(data["taxel_mean_error_psi"] == nlohmann::json::parse("[0.5,null]"));
  CHECK_FALSE(data["evaluation"].contains("largest_error"));
  e.max_error_taxel = 0;
  e.max_error_psi = 3.5;
  e.max_error_at_psi = 56.0;
  input.held_out = {{"a later day", {}, e}};
  input.held_out[0].evaluation.max_error_taxel = -1;
  const auto more = results_of_input(input);
  CHECK(more["evaluation"]["largest_error"] ==
        nlohmann::json::parse(R"({"error_psi":3.5,"taxel":0,"pressure_psi":56.0})"));
  CHECK((more["held_out"].size() == 1 && more["held_out"][0]["title"] == "a later day"));
  CHECK(more["held_out"][0]["evaluation"]["levels"].size() == 2);
}

TEST_CASE("data of models by hand: parameters, figures and patterns of each fitted taxel, names, and without models") {
  ReportInput input;
  auto model = results_of_input(input)["model"];
  CHECK((model["name"] == "elam" && model["full_scale_v"] == 0.0 && model["taxels"].empty()));
  CHECK(model["parameter_names"] == nlohmann::json::parse(R"(["alpha_d","beta_d","alpha_a1","alpha_a0","beta_a"])"));
  CHECK((model["mean_taxel"]["taxel"] == -1 && !model["mean_taxel"].contains("parameters")));
  input.fit = small_model();
  model = results_of_input(input)["model"];
  CHECK((model["rows"] == 1 && model["columns"] == 2 && model["taxels"].size() == 2));
  CHECK(model["parameter_names"].size() == model["taxels"][0]["parameters"].size());
  CHECK(model["taxels"][0] == nlohmann::json::parse(R"({"taxel":0,"status":"fitted","noise_v":0.001,
    "parameters":[0.5,0.25,-0.125,0.75,0.0625],"at_bound":5,"j_v2":0.1,"mean_error_v":0.2,"max_error_v":0.3,
    "full_scale_v":2.0,"ascending_v":[0,0.5,2],"descending_v":[0,1.5,2]})"));
  CHECK(model["taxels"][1] == nlohmann::json::parse(R"({"taxel":1,"status":"dead","noise_v":0.0})"));
  CHECK((model["mean_taxel"]["taxel"] == -1 && model["mean_taxel"]["full_scale_v"] == 1.0));
  CHECK_FALSE(model.contains("dynamics"));
  input.fit.dynamics.emplace();
  CHECK(results_of_input(input)["model"].contains("dynamics"));
}

TEST_CASE("data of the judgement by hand: runs, trajectories, what is not assessed, stored verdicts") {
  ReportInput input;
  input.run.run = 12;
  auto judgement = results_of_input(input)["judgement"];
  CHECK((judgement["overall"] == "" && judgement["statement"] == "" && judgement["runs"].empty()));
  const JudgedFigure own = by_hand::judged_figure(12, Criterion::kMismatch, 0.01, 0.05, Verdict::kPass);
  JudgedFigure other = own, worse = own;
  other.run = 13;
  worse.verdict = Verdict::kConditionalFail;
  input.judgement = by_hand::judgement_of({own, other});
  input.judgement.stored_worse = {worse};
  input.judgement.runs[1].trajectory.reversals = 32;
  input.judgement.not_assessed = {Source::kCreep};
  input.judgement.remarks = {{Remark::Kind::kVoidLeftOut, {14, "me", "2024", "a leak"}, 14}};
  judgement = results_of_input(input)["judgement"];
  CHECK((judgement["overall"] == "pass" && judgement["statement"] != "pass"));  // a condition follows
  REQUIRE(judgement["runs"].size() == 2);
  CHECK((judgement["runs"][1]["on"] == title_of_judged(input, 13) && judgement["runs"][1]["verdict"] == "pass"));
  CHECK((judgement["stored_worse"].size() == 1 && judgement["stored_worse"][0]["verdict"] == "conditional fail"));
  CHECK(judgement["runs"][1]["trajectory"]["reversals"] == 32);
  CHECK((judgement["not_assessed"].size() == 1 && judgement["not_assessed"][0]["source"] == "creep"));
  CHECK(judgement["remarks"].size() == 1);
  CHECK(results_of_input(input)["verdicts"].size() == 2);
  input.judgement.not_judged = {Remark::Kind::kNoIndependentData};
  conclude(input.judgement);
  CHECK(results_of_input(input)["judgement"]["overall"] == "inconclusive");
}

TEST_CASE("data of identification by hand: history, laboratory, further runs and signatures, each of them told") {
  ReportInput input;
  RunHistory& history = input.history;
  history.events = {{1.5, "pause", "asked"}};
  history.voids = {{"up", 1, 2, 3, "broke"}};
  history.surroundings = {{"temperature_c", 22.0, 23.5, 4}};
  history.checks = {{1, 0, "seating", "pass", R"({"a":1})", {}}, {1, 1, "tare", "fail", "no JSON", {}}};
  history.flags = {{"dwell", 2}};
  history.frames = 31;
  history.flagged = 2;
  history.void_frames = 7;
  input.laboratory.laboratory = "L";
  input.laboratory.instruments = {{"P-1", "C-1", "by", "2024-01-01", "2025-01-01", "note"}};
  input.run.devices = {{"regulator", "R", "1", "", "hardware", R"({"certificate":"FILL-IN","span":2})"}};
  input.run.tags = {"a=b"};
  input.run.notes = "said";
  input.further = {input.run, input.run};
  input.held_out = {{"a later day", input.run, {}}};
  input.approvals = {{12, "12-0", "hash", "C. Chief", "2024-06-01T00:00:00Z", "12-1", "typed"}};
  const auto data = nlohmann::json::parse(identification_json(input));
  CHECK(data["history"] == nlohmann::json::parse(R"({"frames":31,"flagged":2,"flags":{"dwell":2},"void_frames":7,
    "voids":[{"sequence":"up","repeat":1,"branch":2,"attempt":3,"reason":"broke"}],
    "events":[{"time_s":1.5,"kind":"pause","text":"asked"}],
    "surroundings":[{"quantity":"temperature_c","low":22.0,"high":23.5,"readings":4}],
    "checks":[{"kind":"seating","verdict":"pass","detail":{"a":1}},{"kind":"tare","verdict":"fail","detail":null}]})"));
  CHECK(data["laboratory"]["laboratory"] == "L");
  CHECK(data["laboratory"]["instruments"] == nlohmann::json::parse(R"([{"serial":"P-1","certificate":"C-1",
    "calibrated_by":"by","calibrated_on":"2024-01-01","due":"2025-01-01","note":"note"}])"));
  CHECK(data["approvals"] == nlohmann::json::parse(R"([{"number":"12-0","approved_by":"C. Chief",
    "approved_utc":"2024-06-01T00:00:00Z","replaces":"12-1","reason":"typed"}])"));
  CHECK((data["further"].size() == 2 && data["held_out"].size() == 1 && data["held_out"][0]["title"] == "a later day"));
  CHECK_FALSE((data["run"].contains("tags") || data["run"].contains("notes")));
  CHECK(data["run"]["devices"][0]["calibration"]["span"] == 2);
  CHECK((data["models_sha256"] == "" && data["sensor"].is_null()));
}

TEST_CASE("the hash of models by hand: every parameter, pattern, status and dynamic number counts, a rerun does not") {
  const SensorModel fit = small_model();
  const std::string hash = model_sha256(fit);
  CHECK(hash.size() == 64);
  CHECK(model_sha256(small_model()) == hash);
  std::set<std::string> hashes = {hash};
  const auto changed = [&](const std::function<void(SensorModel&)>& change) {
    SensorModel other = fit;
    change(other);
    hashes.insert(model_sha256(other));
  };
  for (double ElamParameters::*parameter :
       {&ElamParameters::alpha_d, &ElamParameters::beta_d, &ElamParameters::alpha_a1, &ElamParameters::alpha_a0,
        &ElamParameters::beta_a})
    for (const std::size_t taxel : {0U, 2U})
      changed([&](SensorModel& other) {
        ElamModel elam = *elam_of(other.taxels[taxel]);
        elam.parameters.*parameter += 1e-9;
        other.taxels[taxel].fit.model = std::make_shared<ElamHysteresis>(std::move(elam));
      });
  CHECK(hashes.size() == 11);
  changed([](SensorModel& other) { other.taxels[1].status = TaxelStatus::kStuck; });
  changed([](SensorModel& other) { other.pressure_psi[1] += 1e-9; });
  const std::vector<double> x = {0.0, 30.0, 60.0}, y = {0.0, 0.75, 2.0};
  changed([&](SensorModel& other) { other.taxels[0].ascending = PatternCurve(x, y, 0.0, 2.0); });
  changed([&](SensorModel& other) { other.taxels[0].descending = PatternCurve(x, y, 0.0, 2.0); });
  changed([](SensorModel& other) { std::swap(other.taxels[0], other.taxels[1]); });
  CHECK(hashes.size() == 16);
  // Of models without dynamics a taxel's dynamic numbers are none; with them each counts.
  changed([](SensorModel& other) { other.taxels[0].creep_scale = 2.0; });
  CHECK(hashes.size() == 16);
  const auto dynamic = [&](const std::function<void(SensorModel&)>& change) {
    changed([&](SensorModel& other) {
      other.dynamics.emplace();
      other.dynamics->residual_shape = {1.0, 2.0};
      change(other);
    });
  };
  dynamic([](SensorModel&) {});
  dynamic([](SensorModel& other) { other.taxels[0].creep_scale = 2.0; });
  dynamic([](SensorModel& other) { other.taxels[0].lag_share = 0.5; });
  dynamic([](SensorModel& other) { other.taxels[0].residual_psi = 0.5; });
  dynamic([](SensorModel& other) { other.dynamics->shared.creep_s[1] = 7.0; });
  dynamic([](SensorModel& other) { other.dynamics->shared.creep_share[1] = 0.5; });
  dynamic([](SensorModel& other) { other.dynamics->shared.creep_half = 7.0; });
  dynamic([](SensorModel& other) { other.dynamics->shared.lag_s = 7.0; });
  dynamic([](SensorModel& other) { other.dynamics->shared.lag_share = 0.5; });
  dynamic([](SensorModel& other) { other.dynamics->residual_shape[1] = 7.0; });
  CHECK(hashes.size() == 26);
}
