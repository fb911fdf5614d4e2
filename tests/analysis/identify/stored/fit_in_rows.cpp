// A fit in rows: which fits go there, what stands in each column, and rows that do not make a fit.
#include <catch2/catch.hpp>
#include <cmath>
#include <nlohmann/json.hpp>

#include "analysis/error.h"
#include "analysis/identify/stored/fit_rows.h"
#include "analysis/identify/stored/model_document.h"
#include "tests/analysis/support/straight_array.h"

using namespace tactbench;
using namespace straight_array;

namespace {

// Two taxels that are fitted and a dead one, of run 5, with figures of their own.
SensorModel fit_of_run() {
  SensorModel fit = straight_fit();
  fit.model = "elam";
  fit.run = 5;
  fit.scanner_serial = "C";
  fit.input_unit = "psi";
  fit.output_unit = "V";
  for (std::size_t i : {0U, 1U}) {
    ModelTaxel& taxel = fit.taxels[i];
    const double k = static_cast<double>(i + 1);
    taxel.noise = 0.001 * k;
    taxel.fit.j = 0.5 * k;
    taxel.fit.mean_error = 0.25 * k;
    taxel.fit.max_error = 3.0 - k;
    taxel.fit.at_bound = static_cast<unsigned>(i + 1);
    taxel.residual_psi = 0.125 * k;
  }
  fit.taxels[1].fit.undetermined = {"beta_a"};
  return fit;
}

std::string refused_rows(const FitRows& rows) {
  try {
    (void)model_from_rows(rows);
  } catch (const AnalysisError& error) {
    CHECK(error.id() == "TB-MODEL-STORED");
    return error.what();
  }
  return {};
}

template <class Change>
std::string refused_with(const Change& change) {
  FitRows rows = rows_of(fit_of_run());
  change(rows);
  return refused_rows(rows);
}

}  // namespace

TEST_CASE("a fit in rows: its summary, its patterns and each column of its taxels") {
  const FitRows rows = rows_of(fit_of_run());
  CHECK((rows.fit.run == 5 && rows.fit.model == "elam"));
  const auto summary = nlohmann::json::parse(rows.fit.summary_json);
  CHECK(summary["j_v2"] == 1.5);
  CHECK(summary["mean_error_v"] == 0.375);  // of two
  CHECK(summary["max_error_v"] == 2.0);
  CHECK((summary["taxels"]["fitted"] == 2 && summary["taxels"]["dead"] == 1));
  const auto patterns = nlohmann::json::parse(rows.fit.patterns_json);
  CHECK((patterns["rows"] == 1 && patterns["columns"] == 3 && patterns["falling"] == false));
  CHECK(patterns["full_scale_v"] == 4.5);
  CHECK(patterns["residual_psi"] == nlohmann::json({0.125, 0.25, 0.0, 0.0}));
  CHECK(patterns["undetermined"] == nlohmann::json({{"1", {"beta_a"}}}));
  CHECK(nlohmann::json::parse(rows.fit.options_json)["exact_outer"] == false);
  REQUIRE(rows.taxels.size() == 4);
  CHECK((rows.taxels[0].taxel == kMeanTaxel && rows.taxels[1].taxel == 0 && rows.taxels[3].taxel == 2));
  const db::FitTaxelRecord& second = rows.taxels[2];
  CHECK((second.status == "fitted" && second.noise_v == 0.002 && second.j_v2 == 1.0 && second.mean_error_v == 0.5));
  CHECK((second.max_error_v == 1.0 && second.full_scale_v == 6.0 && second.at_bound == 2));
  CHECK(second.parameters.size() == 5);
  CHECK(second.ascending_v == std::vector<double>{0.0, 6.0});
  CHECK((rows.taxels[3].status == "dead" && rows.taxels[3].parameters.empty() && rows.taxels[3].ascending_v.empty()));
}

TEST_CASE("a fit in rows comes back as it was, without residuals and open parameters where none are kept") {
  SensorModel fit = fit_of_run();
  fit.pressure_psi = {0.0, 60.0};  // the patterns' knots
  fit.options.settle = true;
  fit.validity.mount = "M-1";
  fit.validity.interface_material = "foam";
  const SensorModel back = model_from_rows(rows_of(fit));
  CHECK((back.model == "elam" && back.run == 5 && back.source == "run 5" && back.rows == 1 && back.columns == 3));
  CHECK((back.origin == "simulated" && back.sensor_serial == "S" && back.scanner_serial == "C"));
  CHECK((back.input_unit == "psi" && back.output_unit == "V" && back.options.settle && !back.falling));
  CHECK((back.validity.mount == "M-1" && back.validity.interface_material == "foam"));
  CHECK((back.validity.input->low == 0.0 && back.validity.input->high == 60.0));
  REQUIRE(back.taxels.size() == 4);
  for (std::size_t i : {0U, 1U}) {
    const ModelTaxel &was = fit.taxels[i], &is = back.taxels[i];
    CHECK((is.taxel == was.taxel && is.status == TaxelStatus::kFitted && is.noise == was.noise));
    CHECK((is.fit.j == was.fit.j && is.fit.mean_error == was.fit.mean_error && is.fit.max_error == was.fit.max_error));
    CHECK((is.fit.at_bound == was.fit.at_bound && is.residual_psi == was.residual_psi));
    CHECK((is.fit.undetermined == was.fit.undetermined && is.fit.full_scale == was.fit.full_scale));
    CHECK((is.loop_low == 0.0 && is.yu() == was.yu()));
  }
  CHECK((back.taxels[2].status == TaxelStatus::kDead && back.taxels[2].fit.model == nullptr));
  CHECK(back.mean_taxel().yu() == 4.5);
  for (ModelTaxel& taxel : fit.taxels) {
    taxel.residual_psi = 0.0;
    taxel.fit.undetermined.clear();
  }
  const FitRows bare = rows_of(fit);
  CHECK_FALSE(nlohmann::json::parse(bare.fit.patterns_json).contains("residual_psi"));
  CHECK_FALSE(nlohmann::json::parse(bare.fit.patterns_json).contains("undetermined"));
  CHECK(model_from_rows(bare).taxels[1].residual_psi == 0.0);
}

TEST_CASE("a fit goes in rows when it is ELAM in the paper's mode of a whole run, else as a document") {
  const auto kept_as = [](auto change) {
    SensorModel fit = fit_of_run();
    fit.pressure_psi = {0.0, 60.0};
    change(fit);
    const FitRows rows = rows_of(fit);
    return rows.taxels.empty() ? rows.fit.model : "rows";
  };
  CHECK(kept_as([](SensorModel&) {}) == "rows");
  CHECK(kept_as([](SensorModel& fit) { fit.options.exact_outer = true; }) == "rows");
  CHECK(kept_as([](SensorModel& fit) { fit.run = 0; }) == "elam, in part");
  CHECK(kept_as([](SensorModel& fit) { fit.origin = "imported"; }) == "elam, in part");
  CHECK(kept_as([](SensorModel& fit) { fit.all_sequences = false; }) == "elam, in part");
  CHECK(kept_as([](SensorModel& fit) { fit.parent_sha256 = "abc"; }) == "elam, in part");
  CHECK(kept_as([](SensorModel& fit) { fit.rows = 2; }) == "elam, in part");
  CHECK(kept_as([](SensorModel& fit) { fit.options.free_run = true; }) == "elam, free run");
  CHECK(kept_as([](SensorModel& fit) { fit.options.genetic = true; }) == "elam, genetic");
  CHECK(kept_as([](SensorModel& fit) { fit.options.memory = true; }) == "elam, memory");
  CHECK(kept_as([](SensorModel& fit) { fit.options.linearise = true; }) == "elam, linearised");
  CHECK(kept_as([](SensorModel& fit) { fit.options.splits = 2; }) == "elam, 2 splits");
  SensorModel part = fit_of_run();
  part.pressure_psi = {0.0, 60.0};
  part.all_sequences = false;
  const auto summary = nlohmann::json::parse(rows_of(part).fit.summary_json);
  CHECK(
      (summary["j"] == 1.5 && summary["mean_error"] == 0.375 && summary["max_error"] == 2.0 && summary["fitted"] == 2));
}

TEST_CASE("rows that are not those of an array are refused, each for what it is") {
  const auto patterns_with = [](const char* member, const nlohmann::json& value) {
    return refused_with([&](FitRows& rows) {
      auto patterns = nlohmann::json::parse(rows.fit.patterns_json);
      patterns["pressure_psi"] = nlohmann::json::array({0.0, 60.0});
      patterns[member] = value;
      rows.fit.patterns_json = patterns.dump();
    });
  };
  const std::string start = "the stored fit of run 5 cannot be read: ";
  CHECK(patterns_with("rows", 1).empty());
  CHECK(patterns_with("rows", 0) == start + "it has no taxels");
  CHECK(patterns_with("columns", -3) == start + "it has no taxels");
  CHECK(patterns_with("pressure_psi", nlohmann::json{1.0}) == start + "its grid has no two pressures");
  CHECK(patterns_with("rows", 2) == start + "a taxel is missing: 4 rows for 2 x 3 and their mean");
  CHECK(patterns_with("residual_psi", nlohmann::json{1, 2, 3}) == start + "its residuals are not those of its taxels");
  CHECK(patterns_with("residual_psi", nlohmann::json{1, 2, 3, -1}) ==
        start + "its residuals are not those of its taxels");
  CHECK(patterns_with("residual_psi", nlohmann::json{0, 0, 0, 0}).empty());
  CHECK_THAT(patterns_with("residual_psi", "x"), Catch::StartsWith(start));
  CHECK_THAT(refused_with([](FitRows& rows) { rows.fit.options_json = "{}"; }), Catch::StartsWith(start));
  // The grid has four pressures, the patterns two knots.
  CHECK(refused_rows(rows_of(fit_of_run())) == start + "taxel -1 has 5 parameters and 2 + 2 knots on a grid of 4");
}

TEST_CASE("rows of taxels that make no model are refused, each for what it is") {
  const auto taxel_with = [](auto change) {
    return refused_with([&](FitRows& rows) {
      auto patterns = nlohmann::json::parse(rows.fit.patterns_json);
      patterns["pressure_psi"] = nlohmann::json::array({0.0, 60.0});
      rows.fit.patterns_json = patterns.dump();
      change(rows.taxels);
    });
  };
  using Taxels = std::vector<db::FitTaxelRecord>;
  const std::string start = "the stored fit of run 5 cannot be read: ";
  CHECK(taxel_with([](Taxels&) {}).empty());
  CHECK(taxel_with([](Taxels& rows) { rows[3].taxel = 3; }) == start + "it holds a taxel 3");
  CHECK(taxel_with([](Taxels& rows) { rows[3].taxel = -2; }) == start + "it holds a taxel -2");
  CHECK(taxel_with([](Taxels& rows) { rows[3].taxel = 0; }) == start + "a taxel is missing");
  CHECK(taxel_with([](Taxels& rows) { rows[0].taxel = 2; }) == start + "a taxel is missing");
  CHECK(taxel_with([](Taxels& rows) { rows[1].status = "well"; }) == start + "taxel 0 has the status \"well\"");
  CHECK(taxel_with([](Taxels& rows) { rows[1].noise_v = -0.5; }) == start + "taxel 0 has a noise of -0.5 V");
  CHECK(taxel_with([](Taxels& rows) { rows[1].noise_v = NAN; }) ==
        start + "taxel 0 has a parameter or a noise that is no number");
  CHECK(taxel_with([](Taxels& rows) { rows[1].parameters[4] = INFINITY; }) ==
        start + "taxel 0 has a parameter or a noise that is no number");
  CHECK(taxel_with([](Taxels& rows) { rows[1].parameters.pop_back(); }) ==
        start + "taxel 0 has 4 parameters and 2 + 2 knots on a grid of 2");
  CHECK(taxel_with([](Taxels& rows) { rows[1].ascending_v.pop_back(); }) ==
        start + "taxel 0 has 5 parameters and 1 + 2 knots on a grid of 2");
  CHECK(taxel_with([](Taxels& rows) { rows[1].descending_v.push_back(9); }) ==
        start + "taxel 0 has 5 parameters and 2 + 3 knots on a grid of 2");
  CHECK(taxel_with([](Taxels& rows) { rows[1].descending_v[0] = 0.5; }) ==
        start + "the two patterns of taxel 0 do not meet at their ends");
  CHECK(taxel_with([](Taxels& rows) { rows[1].descending_v[1] = 2.5; }) ==
        start + "the two patterns of taxel 0 do not meet at their ends");
  CHECK_THAT(taxel_with([](Taxels& rows) { rows[1].ascending_v[1] = rows[1].descending_v[1] = -1; }),
             Catch::StartsWith(start + "taxel 0: pattern curve"));
  CHECK(taxel_with([](Taxels& rows) { rows[1].parameters.clear(); }) ==
        start + "taxel 0 has 0 parameters and 2 + 2 knots on a grid of 2");
  CHECK(taxel_with([](Taxels& rows) { rows[3].noise_v = 0.5; }).empty());
}

TEST_CASE("a fit of an only taxel, which has no mean beside it, comes back from its rows") {
  SensorModel fit = fit_of_run();
  fit.pressure_psi = {0.0, 60.0};
  fit.taxels.resize(1);
  fit.columns = 1;
  const SensorModel back = model_from_rows(rows_of(fit));
  REQUIRE(back.array().size() == 1);
  CHECK((back.array()[0].residual_psi == 0.125 && back.mean_taxel().residual_psi == 0.125));
  CHECK((back.array()[0].yu() == fit.taxels[0].yu() && back.full_scale_v() == fit.full_scale_v()));
}
