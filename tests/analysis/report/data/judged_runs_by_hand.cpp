// The runs judged and their instruments by hand: which run is the own one, traceability, the reason of a verdict.
#include "analysis/report/data/judged_runs.h"

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>
#include <string>

#include "analysis/report/data/traceability.h"
#include "tests/analysis/support/judged_figures.h"

using namespace tactbench;
using namespace tactbench::analysis;

namespace {

JudgedFigure verdict_on(std::int64_t run, Criterion criterion, Verdict verdict, std::int64_t model_run = 0) {
  return by_hand::judged_figure(run, criterion, 0.01, 0.015, verdict, {}, model_run);
}

// Run 12 of the report and held-out runs 13 to 13 + others - 1.
ReportInput judged_by_runs(int others) {
  ReportInput input;
  input.unit = PressureUnit::kPsi;
  input.run.run = 12;
  input.run.origin = "hardware";
  input.run.started_utc = "2024-05-06T07:08:09Z";
  for (int i = 0; i < others; ++i) {
    HeldOut held_out{"run " + std::string(1, static_cast<char>('A' + i)), input.run, {}};
    held_out.run.run = held_out.evaluation.run = 13 + i;
    input.held_out.push_back(held_out);
  }
  return input;
}

db::DeviceRecord instrument(const char* role, const char* model, const char* serial, const char* calibration) {
  return {role, model, serial, "", "hardware", calibration};
}

}  // namespace

TEST_CASE("judged runs by hand: the title of each, and whether the own run is the models' own") {
  ReportInput input = judged_by_runs(1);
  const std::string own = title_of_judged(input, 12);
  CHECK(title_of_judged(input, 13) == "run A");
  const auto judged = [&](std::int64_t own_models, std::int64_t other_models) {
    input.judgement = by_hand::judgement_of({verdict_on(12, Criterion::kMismatch, Verdict::kPass, own_models),
                                             verdict_on(13, Criterion::kMismatch, Verdict::kPass, other_models),
                                             verdict_on(99, Criterion::kMismatch, Verdict::kFail)});
    return title_of_judged(input, 12);
  };
  CHECK(judged(0, 9) == own);  // of another run's row
  CHECK(judged(12, 9) == own);
  CHECK(judged(9, 9) != own);
  const std::vector<JudgedColumn> runs = judged_runs(input);
  REQUIRE(runs.size() == 3);
  CHECK((runs[0].run == &input.run && runs[0].number == 12 && runs[0].judged->verdict == Verdict::kPass));
  CHECK((runs[1].run == &input.held_out[0].run && runs[1].title == "run A"));
  CHECK((runs[2].run == nullptr && runs[2].judged->verdict == Verdict::kFail));
  // A held-out run with the report's own number is the report's own.
  input.held_out[0].evaluation.run = 12;
  CHECK(judged_runs(input)[0].run == &input.run);
}

TEST_CASE("traceability by hand: a pressure is traceable by an instrument with a certificate, in date or not dated") {
  ReportInput input = judged_by_runs(0);
  input.evaluation.levels.resize(1);
  const auto traceable = [&](const char* calibration) {
    input.run.devices = {instrument("regulator", "VPPM", "R-1", "{}"),
                         instrument("pressure reference", "PT", "P-1", calibration)};
    const std::vector<Traceability> all = traceability_of(input, PressureUnit::kPsi);
    REQUIRE(all.size() == 1);
    return all[0].traceable;
  };
  CHECK(traceable(R"({"certificate":"C-1","due":"2024-05-06"})"));
  CHECK_FALSE(traceable(R"({"certificate":"C-1","due":"2024-05-05"})"));
  CHECK(traceable(R"({"certificate":"C-1"})"));
  CHECK_FALSE(traceable("{}"));
  // Neither is it by the regulator entered twice, or alone.
  REQUIRE(traceable(R"({"certificate":"C-1"})"));
  input.run.devices[0] = instrument("regulator", "PT", "P-1", "{}");
  CHECK_FALSE(traceability_of(input, PressureUnit::kPsi)[0].traceable);
  input.run.devices.pop_back();
  CHECK_FALSE(traceability_of(input, PressureUnit::kPsi)[0].traceable);
}

TEST_CASE("traceability by hand: a run that presses states force and place, and pressure where it was evaluated too") {
  ReportInput input = judged_by_runs(0);
  const auto quantities = [&] {
    std::string words;
    for (const auto& one : nlohmann::json::parse(traceability_json(input)))
      words += one["quantity"].get<std::string>() + " ";
    return words;
  };
  CHECK(quantities() == "pressure ");
  input.history.presses = true;
  CHECK(quantities() == "force place ");
  input.evaluation.levels.resize(1);
  CHECK(quantities() == "pressure force place ");
  input.run.devices = {instrument("stage x", "", "", R"({"certificate":"S-1"})"),
                       instrument("force sensor", "ATI", "FT-1", R"({"certificate":""})")};
  const auto traceable = [&](std::size_t at) {
    return nlohmann::json::parse(traceability_json(input))[at]["traceable"] == true;
  };
  CHECK((!traceable(1) && traceable(2)));
  input.laboratory.instruments = {{"FT-1", "F-7", "ATI", "2024-01-31", "2025-01-31", ""}};
  CHECK(traceable(1));
}

TEST_CASE("an inconclusive verdict has a reason where a run that was judged had an overdue reference") {
  ReportInput input = judged_by_runs(2);
  CHECK(instruments_warning(input).value.empty());
  const db::DeviceRecord late =
      instrument("pressure reference", "PT", "P-1", R"({"certificate":"C-1","due":"2024-05-05"})");
  input.run.devices = {late, instrument("stage", "ST", "S-1", R"({"due":"2024-05-06"})")};
  input.held_out[1].run.devices = {late};
  CHECK(instruments_warning(input).value.find("2024-05-05") != std::string::npos);
  CHECK(reason_of_verdict(input).empty());
  const auto reason = [&](std::int64_t second, Verdict first = Verdict::kInconclusive) {
    input.judgement = by_hand::judgement_of({verdict_on(13, Criterion::kMpe, first)});
    if (second != 0) {
      input.judgement.figures.push_back(verdict_on(second, Criterion::kMpe, Verdict::kPass));
      conclude(input.judgement);
    }
    return reason_of_verdict(input);
  };
  CHECK(reason(0).empty());  // run A was in date
  for (const std::int64_t late_run : {14, 12}) CHECK(reason(late_run).find("2024-05-05") != std::string::npos);
  CHECK(reason(12, Verdict::kFail).empty());
}
