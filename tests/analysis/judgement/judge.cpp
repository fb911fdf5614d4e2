// From evidence to judgement: the verdict of each figure, which runs count, and what follows from the figures; decision
// rules; which trajectory a run judges.

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <limits>

#include "analysis/judgement/figure.h"
#include "analysis/judgement/judgement.h"
#include "analysis/statistics/numbers/moments.h"

using namespace tactbench::analysis;
using namespace tactbench;

namespace judging {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
using Counts = EvidenceRun::Counts;

Figure figure(Criterion criterion, const Scope& scope, double value, double expanded = kNan) {
  Figure out{criterion, scope, value, {}};
  out.u.expanded = expanded;
  return out;
}

EvidenceRun run_of(std::int64_t number, double mean_psi = 0.25, Counts counts = Counts::kYes) {
  EvidenceRun run;
  run.run = number;
  run.counts = counts;
  if (counts == Counts::kVoid || counts == Counts::kVoidOnRequest) run.voided = {number, "me", "2026", "gauge closed"};
  run.figures = {figure(Criterion::kMeanError, {}, mean_psi), figure(Criterion::kWorstTaxelError, {}, 0.5),
                 figure(Criterion::kDistanceOfMean, {}, 0.0125), figure(Criterion::kUnfitTaxels, {}, 1.0, 0.0)};
  return run;
}

Evidence evidence_of(std::vector<EvidenceRun> runs) {
  Evidence evidence;
  evidence.fit = 4;
  evidence.model_run = 1;
  evidence.runs = std::move(runs);
  return evidence;
}

Limits limits_of(DecisionRule rule = DecisionRule::kSimple) {
  Limits limits;
  limits.rule = rule;
  limits.mean_compensation_error_psi = limits.worst_taxel_error_psi = 0.5;
  limits.distance_of_mean_fs = 0.0125;
  limits.unfit_taxels = 1;
  limits.sha256 = "abc";
  return limits;
}

JudgedFigure stored_row(std::int64_t run, double value, Verdict verdict, const char* sha256, std::int64_t fit = 4) {
  JudgedFigure row;
  static_cast<Figure&>(row) = figure(Criterion::kMeanError, {}, value);
  row.run = run;
  row.fit = fit;
  row.model_run = 1;
  row.limit = 9.0;
  row.verdict = verdict;
  row.limits_sha256 = sha256;
  return row;
}

std::vector<std::int64_t> runs_in(const Judgement& judgement) {
  std::vector<std::int64_t> runs;
  for (const JudgedRun& run : judgement.runs) runs.push_back(run.run);
  return runs;
}

}  // namespace

TEST_CASE("judge: gives each requirement its value, limit and verdict, in the order of the limits") {
  EvidenceRun run = run_of(7);
  for (const double psi : {20.0, 40.0})
    for (const Direction direction : {Direction::kUp, Direction::kDown})
      run.figures.push_back(figure(Criterion::kMismatch, Scope::level(psi, direction),
                                   psi / (direction == Direction::kUp ? 1000.0 : 500.0)));
  run.figures.push_back(figure(Criterion::kMpe, Scope::span(0, 60, 0.95), 2.0));
  Limits limits = limits_of();
  limits.worst_taxel_error_psi = 0.25;
  limits.mismatch = {{40.0, 0.05}, {30.0, 0.05}};
  limits.mpe = {{0.0, 60.0, 3.0, 0.95}, {20.0, 20.0, 1.0, 0.5}};
  const Judgement judgement = judge(evidence_of({run}), limits);
  struct Row {
    Criterion criterion;
    Scope scope;
    double value, limit;
    Verdict verdict;
  };
  const Scope up40 = Scope::level(40, Direction::kUp), down40 = Scope::level(40, Direction::kDown);
  const std::vector<Row> expected = {
      {Criterion::kMeanError, {}, 0.25, 0.5, Verdict::kPass},
      {Criterion::kWorstTaxelError, {}, 0.5, 0.25, Verdict::kFail},
      {Criterion::kDistanceOfMean, {}, 0.0125, 0.0125, Verdict::kPass},
      {Criterion::kUnfitTaxels, {}, 1.0, 1.0, Verdict::kPass},
      {Criterion::kMismatch, up40, 0.04, 0.05, Verdict::kPass},
      {Criterion::kMismatch, down40, 0.08, 0.05, Verdict::kFail},
      {Criterion::kMismatch, Scope::level(30, Direction::kUp), kNan, 0.05, Verdict::kInconclusive},
      {Criterion::kMismatch, Scope::level(30, Direction::kDown), kNan, 0.05, Verdict::kInconclusive},
      {Criterion::kMpe, Scope::span(0, 60, 0.95), 2.0, 3.0, Verdict::kPass},
      {Criterion::kMpe, Scope::span(20, 20, 0.5), kNan, 1.0, Verdict::kInconclusive}};
  REQUIRE(judgement.figures.size() == expected.size());
  for (std::size_t i = 0; i < expected.size(); ++i) {
    const JudgedFigure& own = judgement.figures[i];
    INFO(to_string(own.criterion) << ", " << i);
    CHECK((own.criterion == expected[i].criterion && own.scope == expected[i].scope));
    CHECK((own.value == expected[i].value || (std::isnan(own.value) && std::isnan(expected[i].value))));
    CHECK((own.limit == expected[i].limit && own.verdict == expected[i].verdict));
    CHECK((own.run == 7 && own.fit == 4 && own.model_run == 1 && own.rule == DecisionRule::kSimple));
    CHECK(own.limits_sha256 == "abc");
  }
}

TEST_CASE("judge: a limit's level matches the nearest measured level within 0.01 psi, and is reported as that") {
  const auto judged_at = [](double typed, std::vector<double> measured) {
    EvidenceRun run = run_of(7);
    for (const double psi : measured)
      run.figures.push_back(figure(Criterion::kMismatch, Scope::level(psi, Direction::kUp), psi / 1000.0));
    Limits limits = limits_of();
    limits.mismatch = {{typed, 0.05}};
    return judge(evidence_of({run}), limits).figures[4];
  };
  constexpr double kKilopascals = 6.894757293168361;
  const double level = 100.0 / kKilopascals;  // 14.503774 psi
  for (const double typed : {14.5038, 14.5, 14.51, 14.50377}) {
    CAPTURE(typed);
    CHECK(
        (judged_at(typed, {level, 40}).verdict == Verdict::kPass && judged_at(typed, {level}).scope.low_psi == level));
  }
  for (const double other : {14.49, 14.515, 15.0})
    CHECK(judged_at(other, {level, 40}).verdict == Verdict::kInconclusive);
  for (const auto& [level_kpa, typed] :
       {std::pair(40.0, 5.8015), std::pair(40.0, 5.80), std::pair(120.0, 17.4045), std::pair(20.0, 2.9008)})
    CHECK(judged_at(typed, {level_kpa / kKilopascals}).verdict == Verdict::kPass);
  CHECK(judged_at(14.497, {level, 14.498}).value == Approx(0.014498));  // steps finer than that: the nearest
}

TEST_CASE("judge: the default rule is four-way if U of the value is known, simple if not") {
  EvidenceRun run = run_of(7);
  run.figures[0].u.expanded = 0.3;
  const std::vector<JudgedFigure> rows = judge(evidence_of({run}), limits_of(DecisionRule::kDefault)).figures;
  CHECK((rows[0].rule == DecisionRule::kFourWay && rows[0].verdict == Verdict::kConditionalPass));
  CHECK((rows[1].rule == DecisionRule::kSimple && rows[1].verdict == Verdict::kPass));
  CHECK(rows[3].rule == DecisionRule::kFourWay);  // U of a count is 0
  // A single reading without U does not pass by its error alone, and fails by it.
  run.figures.push_back(figure(Criterion::kMpe, Scope::span(0, 40, 0.95), 1.0));
  const auto reading = [&](double mpe_psi) {
    Limits limits = limits_of(DecisionRule::kDefault);
    limits.mpe = {{0, 40, mpe_psi, 0.95}};
    return judge(evidence_of({run}), limits).figures.back().verdict;
  };
  CHECK((reading(1.0) == Verdict::kInconclusive && reading(0.5) == Verdict::kFail));
  const std::vector<JudgedFigure> guarded = judge(evidence_of({run}), limits_of(DecisionRule::kGuarded)).figures;
  CHECK((guarded[0].verdict == Verdict::kFail && guarded[1].verdict == Verdict::kInconclusive));
}

TEST_CASE("judge: every run that counts is judged in order, the worst decides, and the closest values are named") {
  const Judgement judgement =
      judge(evidence_of({run_of(1, 0.1, Counts::kUsedByModels), run_of(7, 1.0), run_of(3, 0.75), run_of(4, 0.25)}),
            limits_of());
  CHECK(runs_in(judgement) == std::vector<std::int64_t>{7, 3, 4});
  CHECK(judgement.figures.size() == 12);
  CHECK((judgement.overall == Verdict::kFail && !judgement.not_judged));
  CHECK(judgement.decided_by == std::vector<std::int64_t>{3, 7});
  CHECK(judgement.runs[2].verdict == Verdict::kPass);
  REQUIRE((judgement.deciding && judgement.closest_pass));
  CHECK(judgement.figures[*judgement.deciding].run == 7);  // 1 of 0.5 psi, further beyond than 0.75
  CHECK(judgement.figures[*judgement.closest_pass].use_of_limit() == 1.0);
  CHECK_FALSE(judgement.rests_on_means_alone);  // it does not pass
  const Judgement nothing = judge(evidence_of({}), limits_of());
  CHECK((nothing.figures.empty() && !nothing.overall && nothing.decided_by.empty() && !nothing.deciding));
}

TEST_CASE("judge: without a run that counts the first run's values are inconclusive, and the reason is stated") {
  const Judgement own = judge(evidence_of({run_of(1, 0.1, Counts::kUsedByModels)}), limits_of());
  CHECK((own.overall == Verdict::kInconclusive && own.not_judged->kind == Remark::Kind::kNoIndependentData));
  CHECK((own.figures.size() == 4 && own.runs.empty() && own.not_assessed.empty()));
  CHECK(worst_of(own.figures) == Verdict::kInconclusive);
  CHECK(std::ranges::all_of(own.figures, [](const auto& row) { return row.verdict == Verdict::kInconclusive; }));
  Evidence by_void = evidence_of({run_of(2), run_of(3)});
  by_void.models_void = {{1, "me", "2026", "leak"}};
  const Judgement none = judge(by_void, limits_of());
  CHECK((none.not_judged->kind == Remark::Kind::kModelsVoid && none.figures.size() == 4));
  CHECK(worst_of(none.figures) == Verdict::kInconclusive);
  by_void.void_too = true;
  const Judgement asked = judge(by_void, limits_of());
  CHECK((!asked.not_judged && asked.overall == Verdict::kPass && asked.void_counted.size() == 1));
  const Judgement listed =
      judge(evidence_of({run_of(1, 0.1, Counts::kUsedByModels)}), limits_of(DecisionRule::kReportOnly));
  CHECK((!listed.not_judged && listed.overall == Verdict::kReportOnly));
}

TEST_CASE("judge: a void run is left out with its reason, or counted on request and named") {
  Evidence evidence = evidence_of({run_of(3, 2.0, Counts::kVoid), run_of(2)});
  evidence.lost = {{Remark::Kind::kOtherModels, {}, 1, 2}};
  const Judgement without = judge(evidence, limits_of());
  CHECK(runs_in(without) == std::vector<std::int64_t>{2});
  REQUIRE(without.remarks.size() == 2);
  CHECK(without.remarks[0].kind == Remark::Kind::kOtherModels);
  CHECK((without.remarks[1].kind == Remark::Kind::kVoidLeftOut && without.remarks[1].voided.run == 3));
  evidence.runs[0].counts = Counts::kVoidOnRequest;
  const Judgement with = judge(evidence, limits_of());
  CHECK((runs_in(with) == std::vector<std::int64_t>{3, 2} && with.overall == Verdict::kFail));
  CHECK((with.remarks[0].kind == Remark::Kind::kVoidCounted && with.void_counted.at(0).run == 3));
}

TEST_CASE("judge: errors are inconclusive if the reference is overdue or out of its range, other values are not") {
  EvidenceRun run = run_of(2);
  run.figures.push_back(figure(Criterion::kMpe, Scope::span(0, 40, 0.95), 1.0));
  run.figures.push_back(figure(Criterion::kMpe, Scope::span(0, 60, 0.95), 1.0));
  Limits limits = limits_of();
  limits.mpe = {{0, 40, 3.0, 0.95}, {0, 60, 3.0, 0.95}};
  const auto words = [&](const EvidenceRun& judged) {
    std::string out;
    for (const JudgedFigure& row : judge(evidence_of({judged}), limits).figures)
      out += row.verdict == Verdict::kInconclusive ? '?' : '+';
    return out;
  };
  CHECK(words(run) == "++++++");
  EvidenceRun beyond = run;
  beyond.run = 3;
  beyond.reference.low_psi = 0.0;
  beyond.reference.high_psi = 50.0;
  beyond.reference.beyond = TraceabilityGap{.run_high_psi = 60, .high_psi = 50, .above = true};
  CHECK(words(beyond) == "??+++?");
  EvidenceRun overdue = run;
  overdue.reference.overdue = true;
  overdue.reference.calibration.due = "2020-01-31";
  CHECK(words(overdue) == "??++??");
  const Judgement judgement = judge(evidence_of({run_of(5), overdue, beyond}), limits);
  CHECK(judgement.untraced->overdue_since == "2020-01-31");  // of the first such run
  CHECK(std::ranges::count(judgement.remarks, Remark::Kind::kNotTraceable, &Remark::kind) == 2);
  CHECK_THAT(statement_text(judgement, PressureUnit::kPsi), Catch::EndsWith("2020-01-31"));
  CHECK(words(run_of(5)) == "++++??");  // nothing measured for [[mpe]]
}

TEST_CASE("judge: a worse stored verdict by the same limits prevails, and all worse stored verdicts are listed") {
  Evidence evidence = evidence_of({run_of(1, 0.1, Counts::kUsedByModels), run_of(2), run_of(3)});
  evidence.stored = {stored_row(2, 5.0, Verdict::kFail, "abc", 3), stored_row(2, 6.0, Verdict::kPass, "abc", 4),
                     stored_row(3, 8.0, Verdict::kConditionalFail, "other"),
                     stored_row(4, 9.0, Verdict::kPass, "other"), stored_row(1, 9.0, Verdict::kFail, "other")};
  const Judgement both = judge(evidence, limits_of());
  CHECK(worst_of(both.figures) == Verdict::kPass);
  REQUIRE(both.stored_worse.size() == 2);  // the older fit's, too, and none on the models' own run
  CHECK((both.stored_worse[0].value == 5.0 && both.stored_worse[1].value == 8.0));
  CHECK(both.overall == Verdict::kFail);  // a stored fail outlives what was found now
  CHECK_FALSE(both.rests_on_means_alone);
  evidence.stored.erase(evidence.stored.begin());
  CHECK(judge(evidence, limits_of()).overall == Verdict::kPass);
  evidence.stored.push_back(stored_row(3, 0.25, Verdict::kInconclusive, "abc"));  // by a laboratory file
  const Judgement withheld = judge(evidence, limits_of());
  CHECK((withheld.overall == Verdict::kInconclusive && withheld.figures[4].verdict == Verdict::kInconclusive));
  // One that is as bad is no worse.
  evidence.runs[1] = run_of(2, 2.0);
  CHECK(judge(evidence, limits_of()).stored_worse.empty());
}

TEST_CASE("judge: a pass without a limit on single readings says so in its statement") {
  EvidenceRun run = run_of(2);
  run.shows = {kSources.begin(), kSources.end()};
  Evidence evidence = evidence_of({run});
  evidence.studied = {Source::kCreep};
  const auto statement = [&](const Limits& limits) {
    const Judgement judgement = judge(evidence, limits);
    CHECK(judgement_json(judgement)["rests_on_means_alone"] == judgement.rests_on_means_alone);
    return std::pair(judgement.rests_on_means_alone, statement_text(judgement, PressureUnit::kPsi));
  };
  const auto [alone, words] = statement(limits_of());
  CHECK(alone);
  CHECK_THAT(words, Catch::StartsWith("pass, ") && Catch::Contains("means only"));
  Limits with_mpe = limits_of();
  with_mpe.mpe = {{0, 40, 3.0, 0.95}};
  evidence.runs[0].figures.push_back(figure(Criterion::kMpe, Scope::span(0, 40, 0.95), 1.0));
  CHECK(statement(with_mpe) == std::pair(false, std::string("pass")));
  evidence.runs[0].figures[0].value = 9.0;
  CHECK_FALSE(statement(limits_of()).first);  // a fail
}

TEST_CASE("judge: effects shown by no judged run or study, and undated references, are listed as not assessed") {
  EvidenceRun mounted = run_of(2), dated = run_of(3);
  mounted.shows = {Source::kRemounting, Source::kReferenceAge};
  dated.shows = {Source::kTime, Source::kReferenceAge};
  Evidence evidence = evidence_of({mounted, dated});
  const auto missing = [&] { return judge(evidence, limits_of()).not_assessed; };
  CHECK(missing() == std::vector{Source::kHistory, Source::kTemperature, Source::kCreep});
  evidence.studied = {Source::kTemperature};
  evidence.runs[1].shows.erase(Source::kReferenceAge);
  CHECK(missing() == std::vector{Source::kHistory, Source::kCreep, Source::kReferenceAge});
  evidence.runs[0].counts = Counts::kUsedByModels;  // shows nothing
  CHECK(missing().size() == 4);
  CHECK(judge(evidence, limits_of(DecisionRule::kReportOnly)).not_assessed.empty());
}

TEST_CASE("judged value: is read back from store and JSON unchanged, and unknown enumeration text is refused") {
  JudgedFigure own = stored_row(2, 1.5, Verdict::kConditionalPass, "abc");
  own.criterion = Criterion::kMpe;
  own.scope = Scope::span(4, 40, 0.95);
  own.u.expanded = 0.25;
  own.rule = DecisionRule::kFourWay;
  const db::VerdictRecord record = record_of(own, "toml");
  const JudgedFigure back = figure_of(record);
  CHECK(figure_json(back) == figure_json(own));
  CHECK((back.run == 2 && back.fit == 4 && back.model_run == 1 && record.limits_toml == "toml"));
  for (const auto member : {&db::VerdictRecord::criterion, &db::VerdictRecord::scope_kind,
                            &db::VerdictRecord::direction, &db::VerdictRecord::rule, &db::VerdictRecord::verdict}) {
    db::VerdictRecord other = record;
    other.*member = "of another program";
    CHECK_THROWS(figure_of(other));
  }
  CHECK(scope_json({}) == nlohmann::ordered_json::parse(R"({"kind": "array"})"));
  CHECK(scope_json(Scope::level(40, Direction::kUp)) ==
        nlohmann::ordered_json::parse(R"({"kind": "level", "psi": 40.0, "direction": "up"})"));
  CHECK(scope_json(own.scope) == nlohmann::ordered_json::parse(
                                     R"({"kind": "span", "low_psi": 4.0, "high_psi": 40.0, "direction": "both",
                                         "share": 0.95})"));
  CHECK(display_text(Scope::level(40, Direction::kDown), PressureUnit::kKilopascal) == "275.8 kPa decreasing");
}

}  // namespace judging

// The ladder of verdicts, and the decision rules at the limit and U to either side of it.

TEST_CASE("Verdict: names are distinct, and stores keep all verdicts except report only") {
  const std::vector<std::string> ladder = {"report only",      "pass",         "conditional pass",
                                           "conditional fail", "inconclusive", "fail"};
  std::vector<std::string> words;
  for (const Verdict verdict : kVerdicts) {
    words.emplace_back(to_string(verdict));
    CHECK(verdict_from(words.back()) == verdict);
    CHECK(verdict_text(verdict) == words.back());
    CHECK(states_conformity(verdict) == (verdict != Verdict::kReportOnly));
    CHECK(passes(verdict) == (verdict == Verdict::kPass || verdict == Verdict::kConditionalPass));
  }
  CHECK(words == ladder);
  CHECK(std::ranges::is_sorted(kVerdicts));
  CHECK(verdict_names() == std::vector<std::string>(ladder.begin() + 1, ladder.end()));
  for (const char* other : {"", "Pass", "passed", "warning"}) CHECK_FALSE(verdict_from(other));
  CHECK(verdict_text(std::nullopt).empty());
  CHECK_FALSE((states_conformity(std::nullopt) || passes(std::nullopt)));
}

TEST_CASE("decision rules: give the expected verdict at the limit and U to either side of it") {
  // Limit 2, U 0.25: both are exact in binary.
  const auto above = [](double value) { return std::nextafter(value, 9.0); };
  constexpr double kNotKnown = std::numeric_limits<double>::quiet_NaN();
  using enum DecisionRule;
  struct Case {
    DecisionRule rule;
    double value, expanded;
    Verdict verdict;
  };
  for (const Case& each : {Case{kFourWay, -1.0, 0.25, Verdict::kPass},
                           Case{kFourWay, 1.75, 0.25, Verdict::kPass},
                           Case{kFourWay, above(1.75), 0.25, Verdict::kConditionalPass},
                           Case{kFourWay, 2.0, 0.25, Verdict::kConditionalPass},
                           Case{kFourWay, above(2.0), 0.25, Verdict::kConditionalFail},
                           Case{kFourWay, 2.25, 0.25, Verdict::kConditionalFail},
                           Case{kFourWay, above(2.25), 0.25, Verdict::kFail},
                           Case{kFourWay, 2.0, 0.0, Verdict::kPass},
                           Case{kFourWay, above(2.0), 0.0, Verdict::kFail},
                           Case{kFourWay, 1.0, kNotKnown, Verdict::kInconclusive},
                           Case{kFourWay, kNotKnown, 0.25, Verdict::kInconclusive},
                           Case{kSimple, 2.0, 0.25, Verdict::kPass},
                           Case{kSimple, above(2.0), 0.25, Verdict::kFail},
                           Case{kSimple, 2.0, kNotKnown, Verdict::kPass},
                           Case{kGuarded, 1.75, 0.25, Verdict::kPass},
                           Case{kGuarded, above(1.75), 0.25, Verdict::kFail},
                           Case{kGuarded, 1.0, kNotKnown, Verdict::kInconclusive},
                           Case{kDefault, 2.0, 0.25, Verdict::kConditionalPass},
                           Case{kDefault, 2.0, kNotKnown, Verdict::kPass},
                           Case{kReportOnly, 9.0, 0.25, Verdict::kReportOnly}}) {
    CAPTURE(to_string(each.rule), each.value, each.expanded);
    CHECK(verdict_of(each.rule, each.value, 2.0, each.expanded) == each.verdict);
  }
  CHECK(verdict_of(kDefault, 1.0, kNotKnown, 0.1) == Verdict::kInconclusive);
}

TEST_CASE("decision rules: convert to and from names, and their text states the probabilities") {
  for (const char* name : {"default", "simple", "guarded", "four-way", "report-only"}) {
    const auto rule = decision_rule_from(name);
    REQUIRE(rule);
    CHECK(std::string(to_string(*rule)) == name);
    CHECK_THAT(rule_text(*rule), Catch::Contains("ILAC-G8:09/2019"));
  }
  CHECK_FALSE(decision_rule_from("strict"));
  CHECK_THAT(rule_text(DecisionRule::kSimple), Catch::Contains("50 %"));
  CHECK_THAT(rule_text(DecisionRule::kGuarded), Catch::Contains("2.5 %"));
  CHECK_THAT(rule_text(DecisionRule::kFourWay), Catch::Contains("2.5 %") && Catch::Contains("50 %"));
}

namespace trajectory_edges {

// Which trajectory a run judges, at the edges of its rules: how near to an end a turning point lies, how many there
// are, how long a branch is, how far two dwells differ.

namespace {

// One step for each set-point, without a time from command to frame.
SequenceData steps_at(const std::vector<double>& set_points) {
  Repeat repeat;
  for (const double psi : set_points) repeat.steps.push_back({psi, psi, 0.0, 0.0});
  return {"s", {repeat}};
}

Dataset run_at(const std::vector<std::vector<double>>& sequences) {
  Dataset dataset;
  dataset.run = 7;
  for (const std::vector<double>& set_points : sequences) dataset.sequences.push_back(steps_at(set_points));
  return dataset;
}

JudgedTrajectory judged(const std::vector<double>& set_points) {
  return judged_trajectory(run_at({set_points}), run_at({{0, 50, 0}}));
}

}  // namespace

TEST_CASE("trajectory: random if it has eight turning points, under a third of them within 1 % of an end") {
  using Row = std::pair<std::vector<double>, Trajectory>;
  const std::vector<Row> rows = {
      {{0, 50, 20, 60, 30, 70, 40, 80, 10, 100}, Trajectory::kRandomReversals},  // eight
      {{0, 50, 20, 60, 30, 70, 40, 80, 5}, Trajectory::kOther},                  // seven
      // Nine turning points from 0 to 100 psi: those at 99, 1 and 100 psi lie at an end.
      {{0, 99, 40, 60, 1, 50, 30, 100, 20, 70, 10}, Trajectory::kOther},
      {{0, 98.9, 40, 60, 1, 50, 30, 100, 20, 70, 10}, Trajectory::kRandomReversals},
      {{0, 99, 40, 60, 1.1, 50, 30, 100, 20, 70, 10}, Trajectory::kRandomReversals},
      {{0, 99, 40, 60, 1, 50, 30, 100, 20, 70, 10, 15}, Trajectory::kRandomReversals}};  // three of ten
  for (const auto& [set_points, trajectory] : rows) {
    CAPTURE(set_points);
    CHECK(judged(set_points).trajectory == trajectory);
  }
}

TEST_CASE("trajectory: a branch is inner when it is shorter than 98 % of the range") {
  // Six branches of one frame each: the last two span 97.9 of 100 psi.
  const JudgedTrajectory found = judged({0, 100, 0, 98, 0, 97.9, 0});
  CHECK(found.inner_share == Approx(2.0 / 6.0));
  CHECK(found.reversals == 5);
  // Frames count, not branches: 3 of 8.
  CHECK(judged({0, 50, 100, 50, 0, 100, 50, 40, 30}).inner_share == Approx(3.0 / 8.0));
}

TEST_CASE("trajectory: the range is that of all sequences, the turning points are those of the longest") {
  const JudgedTrajectory found = judged_trajectory(run_at({{0, 40, 0, 40, 0}, {20, 80, 20}}), run_at({{0, 40, 0}}));
  CHECK(found.reversals == 3);
  CHECK(found.inner_share == 1.0);
  CHECK(judged_trajectory(run_at({{20, 80, 20}, {0, 40, 0, 40, 0}}), run_at({{0, 40, 0}})).reversals == 3);
  CHECK(judged({50}).inner_share == 0.0);
  CHECK(judged({50}).reversals == 0);
}

TEST_CASE("trajectory: set-points equal the fitted ones within 1e-6 psi each, with no step missing") {
  CHECK(judged({0, 50.0000009, 0}).trajectory == Trajectory::kAsFitted);
  CHECK(judged({0, 50.0000011, 0}).trajectory == Trajectory::kOther);
  CHECK(judged({0, 50}).trajectory == Trajectory::kOther);
  CHECK(judged({0, 50, 0, 50}).trajectory == Trajectory::kOther);
  // Every sequence must be one of the fitted ones; not every fitted one must be there.
  CHECK(judged_trajectory(run_at({{0, 50, 0}, {0, 30, 0}}), run_at({{0, 30, 0}, {0, 50, 0}, {0, 20, 0}})).trajectory ==
        Trajectory::kAsFitted);
  CHECK(judged_trajectory(run_at({{0, 30, 0}, {0, 50, 0}}), run_at({{0, 50, 0}})).trajectory == Trajectory::kOther);
}

TEST_CASE("trajectory: dwells differ if they are more than 20 % of the fitted dwell apart") {
  for (const auto& [dwell_s, other] :
       {std::pair(6.0, false), {6.01, true}, {4.0, false}, {3.99, true}, {kNan, false}}) {
    JudgedTrajectory out;
    set_dwell(out, dwell_s, 5.0);
    CAPTURE(dwell_s);
    CHECK((out.dwell_s == dwell_s || std::isnan(dwell_s)));
    CHECK(out.fitted_dwell_s == 5.0);
    CHECK(out.other_dwell == other);
  }
}

TEST_CASE("trajectory: the dwell is the median of the stated times, and unknown if none is stated") {
  Dataset own = run_at({{0, 50, 0}}), fitted = own;
  const JudgedTrajectory none = judged_trajectory(own, fitted);
  CHECK(std::isnan(none.dwell_s));
  own.sequences[0].repeats[0].steps[1].held_s = 0.5;
  own.sequences[0].repeats[0].steps[2].held_s = 1.5;
  fitted.sequences[0].repeats[0].steps[2].held_s = 4.0;
  const JudgedTrajectory known = judged_trajectory(own, fitted);
  CHECK((known.dwell_s == 1.0 && known.fitted_dwell_s == 4.0));
}

}  // namespace trajectory_edges
