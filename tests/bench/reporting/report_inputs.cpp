// What a report's input holds of runs and judgements, and what is charted of a sensor. On runs of one taxel that are
// stored by hand.
#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "analysis/identify/stored/model_document.h"
#include "analysis/report/report_facts.h"
#include "bench/common/build_info.h"
#include "bench/reporting/evaluation.h"
#include "tests/bench/reporting/judged_store.h"

using namespace tactbench;
using namespace tactbench::tests;

namespace {

bench::JudgementRecord judged_by(analysis::Runs& runs, const analysis::SensorModel& models,
                                 const std::vector<bench::NamedEvaluation>& evaluations,
                                 const std::vector<analysis::InstrumentNote>& notes = {}) {
  bench::JudgementRecord judged{{}, film_limits(100.0), {}};
  judged.evidence = bench::gather_evidence(runs, models, evaluations, judged.limits, false, notes);
  judged.judgement = judge(judged.evidence, judged.limits);
  return judged;
}

}  // namespace

TEST_CASE("report input: has the run, its evaluation, held-out runs with titles, and valid verdicts") {
  JudgedStore made(4);
  analysis::Runs runs(made.store);
  const analysis::SensorModel models = film_line_model();
  const auto evaluations = bench::evaluate_runs(runs, models, {3, 2}, {"warmer"});
  const analysis::ReportInput input =
      bench::report_input(runs, 1, models, evaluations, judged_by(runs, models, evaluations), {4});
  CHECK(input.run.run == 1);
  CHECK(input.evaluation.run == 1);
  CHECK(input.evaluation.mean_error_psi == evaluations[0].evaluation.mean_error_psi);
  REQUIRE(input.held_out.size() == 2);
  CHECK(input.held_out[0].title == "warmer");
  CHECK(input.held_out[0].run.run == 3);
  CHECK(input.held_out[0].evaluation.run == 3);
  CHECK(input.held_out[1].run.run == 2);
  CHECK(input.judgement.figures.size() == 8);
  CHECK(input.judgement.runs.size() == 2);
  CHECK(input.judgement.not_assessed.size() == 5);
  REQUIRE(input.further.size() == 1);
  CHECK(input.further[0].run == 4);
  CHECK(input.program_version == bench::build_info().version);
  CHECK(input.method.size() == 1);
  CHECK(input.frame_count == 26);
  CHECK_FALSE(input.uncertainty);
  const analysis::ReportInput bare = bench::report_input(runs, 2, {}, {}, {});
  CHECK(bare.run.run == 2);
  CHECK(bare.held_out.empty());
  CHECK(bare.evaluation.levels.empty());
}

TEST_CASE("report input: the laboratory is included, and its due dates withhold verdicts") {
  JudgedStore made(2);
  analysis::Runs runs(made.store);
  const analysis::SensorModel models = film_line_model();
  bench::ReportExtras extras;
  extras.unit = analysis::PressureUnit::kKilopascal;
  extras.laboratory.place = "hall 2";
  extras.laboratory.instruments = {{"R-1", "", "", "", "2026-02-01", ""}};
  const bench::JudgementRecord judged =
      judged_by(runs, models, bench::evaluate_runs(runs, models, {2}), extras.laboratory.instruments);
  // Of a run without evaluations, so that no other models are made.
  const analysis::ReportInput input = bench::report_input(runs, 1, models, {}, judged, {}, &extras);
  CHECK(input.unit == analysis::PressureUnit::kKilopascal);
  CHECK(input.laboratory.place == "hall 2");
  REQUIRE(input.judgement.figures.size() == 4);
  CHECK(input.judgement.figures[0].verdict == analysis::Verdict::kInconclusive);
  CHECK(input.judgement.figures[3].verdict == analysis::Verdict::kPass);
  CHECK(input.judgement.untraced->overdue_since == "2026-02-01");
  CHECK_FALSE(input.uncertainty);
  CHECK(input.evaluation.levels.empty());
}

TEST_CASE("sensor trend: values come from the models in use for a run, grouped by its recipes") {
  FilmStore made;
  FilmRun two;
  two.levels = kFilmInnerLoop;
  two.sequences = {"up"};
  REQUIRE(made.add(two) == 1);
  analysis::Runs runs(made.store);
  const analysis::SensorModel elam = bench::fit_run(made.store, runs.dataset(1));
  CHECK(elam.fit == 1);
  const analysis::Evaluation own = analysis::evaluate(runs.dataset(1), elam);
  db::RunRecord run = made.store.run(1);
  run.sequences.push_back({1, "down", "", "", 1, 1});
  CHECK(bench::record_sensor_trend(made.store, run, elam, own) == "sensor/S-1/up+down");
  CHECK(made.store.figures_of(1, "sensor/S-1/up+down").at("mean_error_psi") == own.mean_error_psi);
  run.sensor_serial.clear();
  CHECK(bench::record_sensor_trend(made.store, run, elam, own).empty());
  const auto subjects = [&] { return made.store.subjects_of(1); };
  CHECK(subjects() == std::vector<std::string>{"sensor/S-1/up+down"});
  bench::record_fit_trend(made.store, elam, own);
  CHECK(subjects() == std::vector<std::string>{"sensor/S-1/up", "sensor/S-1/up+down"});
  made.store.replace_figures(1, "sensor/S-1/up", {});
  analysis::SensorModel other = film_line_model();
  other.fit = analysis::store_fit(made.store, other, "1", "2026-03-01T02:00:00Z");
  bench::record_fit_trend(made.store, other, own);
  CHECK(made.store.figures_of(1, "sensor/S-1/up").empty());
  const analysis::SensorModel dynamic = bench::fit_run_dynamic(made.store, runs, 1);
  CHECK(dynamic.content_sha256 == made.store.run(1).content_sha256);
  CHECK(dynamic.program_version == bench::build_info().version);
  const analysis::Evaluation of_dynamic = analysis::evaluate(runs.dataset(1), dynamic);
  bench::record_fit_trend(made.store, dynamic, of_dynamic);
  CHECK(made.store.figures_of(1, "sensor/S-1/up/dynamic").at("mean_error_psi") == of_dynamic.mean_error_psi);
}
