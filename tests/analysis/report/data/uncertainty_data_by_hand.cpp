// The data behind uncertainty and conformity by hand: budgets, levels, conditions of use, limits, creep, temperature.
#include <catch2/catch.hpp>
#include <limits>
#include <nlohmann/json.hpp>
#include <string>

#include "analysis/report/data/data.h"
#include "analysis/report/data/section_data.h"
#include "analysis/report/parts.h"
#include "tests/analysis/support/judged_figures.h"

using namespace tactbench;
using namespace tactbench::analysis;

namespace {

constexpr double kNoFigure = std::numeric_limits<double>::quiet_NaN();

Budget stored_budget(int taxel, double error) {
  Budget budget;
  budget.taxel = taxel;
  budget.error_psi = error;
  budget.readings = 6;
  Contribution noise, model;
  noise.source = UncertaintySource::kNoise;
  noise.width = 0.004;
  noise.divisor = 2.0;
  noise.sensitivity = 20.0;
  noise.u_psi = 0.04;
  noise.dof = 250.0;
  noise.common = 0.25;
  model.source = UncertaintySource::kModel;
  model.u_psi = 0.03;
  budget.contributions = {noise, model};
  budget.combined_psi = 0.05;
  budget.dof = 33.5;
  budget.factor = 2.25;
  budget.expanded_psi = 0.125;
  budget.linear = false;
  return budget;
}

LevelUncertainty stored_level(bool up) {
  LevelUncertainty level;
  level.pressure_psi = 30.0;
  level.up = up;
  level.expanded_psi = {0.123456, kNoFigure};
  level.error_psi = {0.0123456, kNoFigure};
  level.factor = {2.123456, kNoFigure};
  level.array = {0.01, 0.02, up ? 0.5 : kNoFigure};
  level.median = stored_budget(0, 0.5);
  level.worst = stored_budget(1, 0.25);
  level.not_linear = 3;
  return level;
}

nlohmann::json reading_of(const ReportInput& input) {
  return nlohmann::json::parse(uncertainty_json(input))["reading"];
}

}  // namespace

TEST_CASE("data of a budget by hand: one value a source, and whole rows at the chosen level alone") {
  ReportInput input;
  CHECK(nlohmann::json::parse(uncertainty_json(input))["reading"].is_null());
  input.uncertainty.emplace();
  input.uncertainty->levels = {stored_level(true), stored_level(false)};
  input.uncertainty->chosen = 1;
  const auto data = reading_of(input);
  CHECK(data["chosen"] == 1);
  CHECK(data["coverage_probability"].get<double>() == Approx(0.9545).epsilon(1e-6));
  REQUIRE(data["sources"].size() == kUncertaintySources);
  CHECK((data["sources"][0] == "reference, certificate" && data["sources"][19] == "history (inner branches)"));
  const auto& first = data["levels"][0];
  CHECK((first["pressure_psi"] == 30.0 && first["branch"] == "up" && first["readings"] == 6));
  CHECK((first["not_linear"] == 3 && data["levels"][1]["branch"] == "down"));
  CHECK(first["taxel_expanded_psi"] == nlohmann::json::parse("[0.123,null]"));
  CHECK(first["taxel_error_psi"] == nlohmann::json::parse("[0.01235,null]"));
  CHECK(first["taxel_factor"] == nlohmann::json::parse("[2.123,null]"));
  CHECK((first["array"]["mean_expanded_psi"] == 0.02 && first["array"]["centre_expanded_pitches"] == 0.5));
  CHECK(data["levels"][1]["array"]["centre_expanded_pitches"].is_null());
  const auto& median = first["median"];
  CHECK((median["taxel"] == 0 && median["error_psi"] == 0.5 && median["combined_psi"] == 0.05));
  CHECK((median["lower_psi"] == 0.375 && median["upper_psi"] == 0.625 && median["expanded_psi"] == 0.125));
  CHECK((median["dof"] == 33.5 && median["factor"] == 2.25 && median["linear"] == false));
  REQUIRE(median["u_psi"].size() == kUncertaintySources);
  for (std::size_t i = 0; i < kUncertaintySources; ++i) {
    INFO(i);
    if (i == static_cast<std::size_t>(UncertaintySource::kNoise))
      CHECK(median["u_psi"][i] == 0.04);
    else if (i == static_cast<std::size_t>(UncertaintySource::kModel))
      CHECK(median["u_psi"][i] == 0.03);
    else
      CHECK(median["u_psi"][i].is_null());
  }
  CHECK_FALSE(median.contains("contributions"));
  for (const char* which : {"median", "worst"}) {
    const auto& rows = data["levels"][1][which]["contributions"];
    REQUIRE(rows.size() == 2);
    CHECK(rows[0] == nlohmann::json::parse(R"({"source":"noise","type":"A","width":0.004,"unit":"V",
      "distribution":"normal","divisor":2.0,"sensitivity":20.0,"u_psi":0.04,"common_share":0.25,"dof":250.0})"));
    CHECK(rows[1]["dof"] == "infinite");
  }
}

TEST_CASE("data of the reference by hand: what is missing, and limits that are stated, contained or not assessed") {
  ReportInput input;
  input.uncertainty.emplace();
  Uncertainty& u = *input.uncertainty;
  u.missing[static_cast<std::size_t>(UncertaintySource::kCreep)] = "no hold";
  ReferenceUncertainty& reference = u.reference;
  reference.calibration.certificate = "C-1";
  reference.calibration.calibrated_on = "2024-01-01";
  reference.calibration.due = "2025-01-01";
  reference.independent = true;
  reference.overdue = true;
  reference.reading_psi = {0.0, 60.0};
  reference.expanded_psi = {0.25, 0.5};
  reference.coverage_factor = 2.0;
  reference.resolution_psi = 0.01;
  reference.drift_psi = 0.02;
  reference.drift_stated_psi = 0.03;
  reference.drift_basis = "a year";
  reference.limits[0].half_width_psi = 0.04;
  reference.limits[1].part.from = "in the certificate";
  reference.limits[2].part.missing = "no zero";
  const auto data = reading_of(input);
  CHECK(data["not_assessed"] == nlohmann::json::parse(R"({"creep under load":"no hold"})"));
  CHECK(data["reference"] == nlohmann::json::parse(R"({"certificate":"C-1","calibrated":"2024-01-01",
    "due":"2025-01-01","overdue":true,"not_covered":"","independent":true,"certificate_covers":"not stated",
    "beyond_the_certificate_psi":{"reference, voltage input":0.04,"reference, hysteresis":"in the certificate",
      "reference, zero":"not assessed: no zero","reference, temperature":""},
    "largest_u_psi":0.25,"resolution_psi":0.01,"drift_psi":0.02,"drift_stated_psi":0.03,"drift_basis":"a year"})"));
  CHECK_FALSE(data.contains("creep"));
  CHECK_FALSE(data.contains("temperature"));
  CHECK(data["conditions"].empty());
}

TEST_CASE("data of kinds by hand: U and known error of each level and taxel of a valid one, the reason otherwise") {
  ReportInput input;
  input.uncertainty.emplace();
  ConditionUncertainty valid, other;
  valid.condition = UseCondition::kReversals;
  valid.name = "reversals";
  valid.basis = "two histories";
  valid.runs = {3, 4};
  valid.histories = 2;
  valid.readings = 90;
  valid.median_psi = 0.5;
  valid.factor = 2.25;
  valid.pressure_psi = {20.0, 40.0};
  valid.up = {true, false};
  valid.expanded_psi = {0.1, 0.3, 0.2, 0.4, 0.8, kNoFigure};  // three taxels a level
  valid.error_psi = {0.0, 0.1, 0.0, 0.0, -0.1, kNoFigure};
  other.condition = UseCondition::kLater;
  other.not_valid = "no later run";
  input.uncertainty->conditions = {valid, other};
  const auto data = reading_of(input);
  CHECK(data["worst_kind"] == "reversals");
  CHECK(data["conditions"][0] == nlohmann::json::parse(R"({"name":"reversals","valid":true,"rests_on":"two histories",
    "runs":[3,4],"histories":2,"readings":90,"factor":2.25,"median_expanded_psi":0.5,"pressure_psi":[20.0,40.0],
    "branch":["up","down"],"taxel_expanded_psi":[0.1,0.3,0.2,0.4,0.8,null],
    "taxel_error_psi":[0.0,0.1,0.0,0.0,-0.1,null]})"));
  CHECK((data["conditions"][1]["valid"] == false && data["conditions"][1]["not_valid_because"] == "no later run"));
  CHECK_FALSE(data["conditions"][1].contains("taxel_expanded_psi"));
}

TEST_CASE("data of judged figures by hand: on which run, U with k and its degrees of freedom") {
  ReportInput input;
  input.run.run = 12;
  JudgedFigure own = by_hand::judged_figure(12, Criterion::kMismatch, 0.5, 1.0, Verdict::kPass,
                                            Scope::level(40, Direction::kUp)),
               other = own;
  own.u = {0.25, 0.125, 9.5, 2.25, "12 sweeps", ""};
  other.u = {kNoFigure, 0.125, std::numeric_limits<double>::infinity(), 2.25, "", "no certificate"};
  other.run = 77;
  input.judgement.figures = {own, other};
  const auto data = nlohmann::json::parse(uncertainty_json(input))["judged_figures"];
  REQUIRE(data.size() == 2);
  auto first = data[0];
  CHECK(first["on"] != data[1]["on"]);
  first.erase("on");
  CHECK(first == nlohmann::json::parse(R"({"criterion":"mismatch","scope":{"kind":"level","psi":40.0,"direction":"up"},
    "unit":"FS","expanded":0.25,"combined":0.125,"dof":9.5,"factor":2.25,"basis":"12 sweeps","not_known":""})"));
  CHECK(data[1]["expanded"].is_null());
  CHECK((data[1]["dof"] == "infinite" && data[1]["not_known"] == "no certificate"));
}

TEST_CASE("data of creep and temperature by hand: held levels with five digits, changes of each run") {
  CreepEffect creep;
  creep.not_assessed.clear();
  creep.read_after_s = 2.5;
  creep.to_s = 600.0;
  creep.extrapolated_back = true;
  HeldLevel held{"hold", 40.0, true, 3.0, 602.0, {0.01234567, kNoFigure}, 0.0125};
  creep.levels = {held, held};
  creep.levels[1].up = false;
  const auto data = nlohmann::json::parse(json_text(creep_effect_json(creep)));
  CHECK((data["read_after_s"] == 2.5 && data["covered_to_s"] == 600.0 && data["carried_back"] == true));
  CHECK(data["basis"] == creep.in_words());
  REQUIRE(data["levels"].size() == 2);
  CHECK(data["levels"][0] == nlohmann::json::parse(R"({"sequence":"hold","pressure_psi":40.0,"branch":"up",
    "from_s":3.0,"to_s":602.0,"median_share":0.0125,"taxel_share":[0.012346,null]})"));
  CHECK(data["levels"][1]["branch"] == "down");

  TemperatureEffect effect;
  effect.not_assessed.clear();
  effect.temperature_c = {22.0, 27.5};
  effect.change = {{0.0, 0.0}, {0.001, 0.002}};
  effect.per_kelvin = {0.003, 0.004};
  effect.u = {0.005, 0.006};
  effect.deviation = {0.007, 0.008};
  effect.dof = 8.0;
  effect.low_c = 22.0;
  effect.high_c = 23.0;
  effect.resolution_c = 0.5;
  const auto warm = nlohmann::json::parse(json_text(temperature_effect_json(effect)));
  CHECK(warm["per_kelvin"] == nlohmann::json::parse(R"({"share":0.004,"zero_v":0.003})"));
  CHECK(warm["u"] == nlohmann::json::parse(R"({"share":0.006,"zero_v":0.005})"));
  CHECK(warm["taxel_deviation"] == nlohmann::json::parse(R"({"share":0.008,"zero_v":0.007})"));
  CHECK((warm["dof"] == 8.0 && warm["half_width_c"] == 0.75 && warm["resolution_c"] == 0.5));
  REQUIRE(warm["runs"].size() == 2);
  CHECK(warm["runs"][1] == nlohmann::json::parse(R"({"temperature_c":27.5,"change":{"share":0.002,"zero_v":0.001}})"));
  CHECK(warm["basis"] == effect.in_words());

  ReportInput input;
  input.uncertainty.emplace();
  input.uncertainty->creep = creep;
  input.uncertainty->temperature = effect;
  CHECK(reading_of(input)["creep"]["levels"].size() == 2);
  CHECK(reading_of(input)["temperature"]["dof"] == 8.0);
}
