#include "analysis/judgement/judgement.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <utility>

#include "analysis/counted.h"
#include "analysis/json_fields.h"
#include "analysis/loop.h"
#include "analysis/statistics/figures/levels.h"
#include "analysis/statistics/numbers/moments.h"

namespace tactbench::analysis {
namespace {

struct SourceNames {
  const char* source;
  const char* why;
};
constexpr std::array<SourceNames, kSources.size()> kSourceNames = {{
    // by Source
    {"history", "every judged run repeats the fitted set-points: errors on other inner branches are not known"},
    {"re-mounting", "no judged run and no study has the sensor re-mounted"},
    {"temperature", "no judged run and no study is at another temperature"},
    {"time", "no judged run is a day or more apart from the run of the models"},
    {"creep", "no study holds the load for longer than the runs do"},
    {"age of the reference's calibration",
     "neither its date nor its due date is stated: its drift cannot be scaled with time"},
}};

bool counts(const EvidenceRun& run) {
  return run.counts == EvidenceRun::Counts::kYes || run.counts == EvidenceRun::Counts::kVoidOnRequest;
}

// Errors against the reference depend on it; differences and counts do not.
bool is_traceable(const Figure& figure, const ReferenceUncertainty& reference) {
  if (!reference.untraced() || quantity_of(figure.criterion) != Quantity::kPressure) return true;
  return is_per_reading(figure.criterion) && !reference.overdue && reference.holds_at(figure.scope.low_psi) &&
         reference.holds_at(figure.scope.high_psi);
}

class Judging {
 public:
  Judging(const Evidence& evidence, const Limits& limits) : evidence_(evidence), limits_(limits) {}

  std::vector<JudgedFigure> judged(const EvidenceRun& run) const {
    std::vector<JudgedFigure> figures;
    const auto add = [&](Criterion criterion, const Scope& scope, double limit) {
      figures.push_back(judged(run, criterion, scope, limit));
    };
    add(Criterion::kMeanError, {}, limits_.mean_compensation_error_psi);
    add(Criterion::kWorstTaxelError, {}, limits_.worst_taxel_error_psi);
    add(Criterion::kDistanceOfMean, {}, limits_.distance_of_mean_fs);
    add(Criterion::kUnfitTaxels, {}, limits_.unfit_taxels);
    for (const Limits::Mismatch& mismatch : limits_.mismatch)
      for (const Direction direction : {Direction::kUp, Direction::kDown})
        add(Criterion::kMismatch, Scope::level(level_near(run, mismatch.pressure_psi), direction), mismatch.std_fs);
    for (const Limits::Mpe& mpe : limits_.mpe)
      add(Criterion::kMpe, Scope::span(mpe.low_psi, mpe.high_psi, mpe.share), mpe.mpe_psi);
    return figures;
  }

 private:
  JudgedFigure judged(const EvidenceRun& run, Criterion criterion, const Scope& scope, double limit) const {
    JudgedFigure out;
    out.criterion = criterion;
    out.scope = scope;
    out.value = std::numeric_limits<double>::quiet_NaN();
    for (const Figure& figure : run.figures)
      if (figure.criterion == criterion && figure.scope == scope) static_cast<Figure&>(out) = figure;
    out.run = run.run;
    out.fit = evidence_.fit;
    out.model_run = evidence_.model_run;
    out.limit = limit;
    out.limits_sha256 = limits_.sha256;
    out.rule = rule_applied(limits_.rule, out.u.expanded);
    // A single reading whose U is not known does not pass by its mean error alone.
    if (limits_.rule == DecisionRule::kDefault && is_per_reading(criterion) && out.value <= limit)
      out.rule = DecisionRule::kFourWay;
    out.verdict = verdict_of(out.rule, out.value, limit, out.u.expanded);
    if (out.verdict == Verdict::kReportOnly) return out;
    if (!counts(run) || !is_traceable(out, run.reference)) out.verdict = Verdict::kInconclusive;
    // A stored verdict by the same limits is kept if it is worse, because a laboratory file may be missing now. Of two
    // fits with the same models the newer one counts.
    const JudgedFigure* stands = nullptr;
    for (const JudgedFigure& stored : evidence_.stored)
      if (stored.run == out.run && stored.criterion == criterion && stored.scope == scope &&
          stored.limits_sha256 == limits_.sha256 && (stands == nullptr || stored.fit >= stands->fit))
        stands = &stored;
    if (stands != nullptr) out.verdict = std::max(out.verdict, stands->verdict);
    return out;
  }

  // The measured level that the limits mean; the level of the limits if none was measured.
  static double level_near(const EvidenceRun& run, double pressure_psi) {
    double nearest = pressure_psi, off = kTypedLevelPsi;
    for (const Figure& figure : run.figures) {
      const double own = std::abs(figure.scope.low_psi - pressure_psi);
      if (figure.criterion != Criterion::kMismatch || !(own <= off)) continue;
      off = own;
      nearest = figure.scope.low_psi;
    }
    return nearest;
  }

  const Evidence& evidence_;
  const Limits& limits_;
};

// Void runs that counted, and those that did not.
void remark_on_runs(const Evidence& evidence, Judgement& judgement) {
  using Kind = Remark::Kind;
  for (const VoidRun& run : evidence.models_void)
    if (evidence.void_too) judgement.void_counted.push_back(run);
  for (const EvidenceRun& run : evidence.runs)
    if (run.counts == EvidenceRun::Counts::kVoidOnRequest) judgement.void_counted.push_back(run.voided);
  for (const VoidRun& run : judgement.void_counted) judgement.remarks.push_back({Kind::kVoidCounted, run});
  judgement.remarks.insert(judgement.remarks.end(), evidence.lost.begin(), evidence.lost.end());
  for (const EvidenceRun& run : evidence.runs)
    if (run.counts == EvidenceRun::Counts::kVoid)
      judgement.remarks.push_back({Kind::kVoidLeftOut, run.voided, run.run});
}

void note_conditions(const Evidence& evidence, Judgement& judgement) {
  std::set<Source> assessed = evidence.studied;
  bool dated = true;
  for (JudgedRun& judged : judgement.runs) {
    const auto run = std::ranges::find(evidence.runs, judged.run, &EvidenceRun::run);
    judged.trajectory = run->trajectory;
    if (!states_conformity(judgement.overall)) continue;
    assessed.insert(run->shows.begin(), run->shows.end());
    dated = dated && run->shows.contains(Source::kReferenceAge);
    const std::optional<TraceabilityGap> untraced = run->reference.untraced();
    if (!untraced) continue;
    if (!judgement.untraced) judgement.untraced = untraced;
    judgement.remarks.push_back({Remark::Kind::kNotTraceable, {}, run->run, 0, untraced});
  }
  if (!states_conformity(judgement.overall)) return;
  if (!dated) assessed.erase(Source::kReferenceAge);
  for (const Source source : kSources)
    if (!assessed.contains(source)) judgement.not_assessed.push_back(source);
}

}  // namespace

VoidRun void_of(const db::RunRecord& run) { return {run.run, run.void_by, run.void_utc, run.void_reason}; }

std::string display_text(const VoidRun& run) {
  return fmt::format("run {} was declared void by {} on {}: {}", run.run, run.by, run.utc, run.reason);
}

const char* to_string(Source source) { return kSourceNames.at(static_cast<std::size_t>(source)).source; }
const char* why_not_assessed(Source source) { return kSourceNames.at(static_cast<std::size_t>(source)).why; }

std::string display_text(const Remark& remark, PressureUnit unit) {
  switch (remark.kind) {
    case Remark::Kind::kNoIndependentData:
      return "no independent data: the figures come from the run from which the models were made";
    case Remark::Kind::kModelsVoid:
      return display_text(remark.voided) + ", and the models were made from it";
    case Remark::Kind::kOnVoid:
      return "the run, or the one from which the models were made, was declared void";
    case Remark::Kind::kVoidCounted:
      return display_text(remark.voided) + "; --void-too includes it";
    case Remark::Kind::kVoidLeftOut:
      return fmt::format("run {} is not judged: {}", remark.run, display_text(remark.voided));
    case Remark::Kind::kStoredOnVoid:
      return fmt::format("the models were judged on run {}, but {}", remark.run, display_text(remark.voided));
    case Remark::Kind::kOtherModels:
      return fmt::format("the judged fit {} of run {} has other models", remark.fit, remark.run);
    case Remark::Kind::kNotTraceable:
      break;
  }
  return fmt::format("run {}: {}; verdicts on errors against the reference are inconclusive", remark.run,
                     display_text(remark.untraced.value(), unit));
}

std::optional<Verdict> worst_of(std::span<const JudgedFigure> figures) {
  std::optional<Verdict> worst;  // none ranks better than any verdict
  for (const JudgedFigure& figure : figures) worst = std::max(worst, std::optional(figure.verdict));
  return worst;
}

void conclude(Judgement& judgement) {
  const std::vector<JudgedFigure>& figures = judgement.figures;
  judgement.runs.clear();
  judgement.decided_by.clear();
  judgement.deciding.reset();
  judgement.closest_pass.reset();
  const std::optional<Verdict> worst = worst_of(figures);
  judgement.overall = worst;
  if (judgement.not_judged)
    judgement.overall = Verdict::kInconclusive;
  else if (worst_of(judgement.stored_worse) == Verdict::kFail)
    judgement.overall = Verdict::kFail;
  judgement.rests_on_means_alone =
      passes(judgement.overall) &&
      std::ranges::none_of(figures, [](const JudgedFigure& figure) { return is_per_reading(figure.criterion); });
  if (judgement.not_judged) return;
  for (std::size_t i = 0; i < figures.size(); ++i) {
    const JudgedFigure& own = figures[i];
    const auto closer = [&](const std::optional<std::size_t>& than) {
      return !than || own.use_of_limit() > figures[*than].use_of_limit();
    };
    if (own.verdict == worst && states_conformity(worst) && closer(judgement.deciding)) judgement.deciding = i;
    if (own.verdict == Verdict::kPass && closer(judgement.closest_pass)) judgement.closest_pass = i;
    const auto known = std::ranges::find(judgement.runs, own.run, &JudgedRun::run);
    if (known == judgement.runs.end())
      judgement.runs.push_back({own.run, own.verdict, {}});
    else
      known->verdict = std::max(known->verdict, own.verdict);
  }
  for (const JudgedRun& run : judgement.runs)
    if (run.verdict == worst) judgement.decided_by.push_back(run.run);
  std::ranges::sort(judgement.decided_by);
}

Judgement judge(const Evidence& evidence, const Limits& limits) {
  Judgement out;
  out.limits_name = limits.name;
  out.limits_toml = limits.toml;
  out.limits_sha256 = limits.sha256;
  if (evidence.runs.empty()) return out;
  remark_on_runs(evidence, out);
  const bool models_count = evidence.models_void.empty() || evidence.void_too;
  const Judging judging(evidence, limits);
  const auto take = [&](const EvidenceRun& run) {
    const std::vector<JudgedFigure> own = judging.judged(run);
    out.figures.insert(out.figures.end(), own.begin(), own.end());
  };
  for (const EvidenceRun& run : evidence.runs)
    if (models_count && counts(run)) take(run);
  if (out.figures.empty()) {
    take(evidence.runs.front());
    if (!models_count) {
      out.not_judged = {Remark::Kind::kModelsVoid, evidence.models_void.front()};
      for (JudgedFigure& figure : out.figures)
        if (figure.verdict != Verdict::kReportOnly) figure.verdict = Verdict::kInconclusive;
    } else if (limits.rule != DecisionRule::kReportOnly) {
      out.not_judged = {Remark::Kind::kNoIndependentData};
    }
  }
  const Verdict found = std::max(worst_of(out.figures).value_or(Verdict::kPass), Verdict::kPass);
  for (const JudgedFigure& stored : evidence.stored)
    if (!out.not_judged && stored.run != stored.model_run && stored.verdict > found) out.stored_worse.push_back(stored);
  conclude(out);
  if (!out.not_judged) note_conditions(evidence, out);
  return out;
}

std::string condition_text(const Judgement& judgement, PressureUnit unit) {
  if (judgement.overall == Verdict::kInconclusive && judgement.untraced)
    return ": " + display_text(*judgement.untraced, unit);
  std::string text;
  if (judgement.rests_on_means_alone) text += ", for means only: no limit applies to single readings";
  if (passes(judgement.overall) && !judgement.not_assessed.empty()) text += ", under repeatability conditions only";
  return text;
}

std::string statement_text(const Judgement& judgement, PressureUnit unit) {
  return judgement.overall ? to_string(*judgement.overall) + condition_text(judgement, unit) : "";
}

std::vector<std::string> kinds_left_open(const Judgement& judgement) {
  std::set<UseCondition> counted;
  if (passes(judgement.overall))
    for (const JudgedFigure& figure : judgement.figures) counted.insert(figure.u.kinds.begin(), figure.u.kinds.end());
  std::vector<std::string> open;
  for (std::size_t kind = 0; kind < kHistoryKinds && !counted.empty(); ++kind)
    if (!counted.contains(static_cast<UseCondition>(kind))) open.emplace_back(name_of(static_cast<UseCondition>(kind)));
  return open;
}

std::string not_assessed_text(const Judgement& judgement) {
  std::vector<const char*> sources;
  for (const Source source : judgement.not_assessed) sources.push_back(to_string(source));
  return fmt::format("{}", fmt::join(sources, "; "));
}

namespace {
using Json = nlohmann::ordered_json;
}

// trajectory reversals inner_share dwell_s fitted_dwell_s other_dwell; without the run's number.
nlohmann::ordered_json trajectory_json(const JudgedTrajectory& judged) {
  return {{"trajectory", to_string(judged.trajectory)},
          JSON_FIELDS(judged, reversals, inner_share, dwell_s, fitted_dwell_s, other_dwell)};
}

nlohmann::ordered_json judgement_json(const Judgement& judgement) {
  const PressureUnit psi = PressureUnit::kPsi;
  Json runs = Json::array(), missing = Json::array(), voids = Json::array(), stored = Json::array(),
       remarks = Json::array();
  for (const JudgedRun& run : judgement.runs)
    runs.push_back(
        {{"run", run.run}, {"verdict", to_string(run.verdict)}, {"trajectory", trajectory_json(run.trajectory)}});
  for (const Source source : judgement.not_assessed)
    missing.push_back({{"source", to_string(source)}, {"why", why_not_assessed(source)}});
  for (const VoidRun& run : judgement.void_counted) voids.push_back({JSON_FIELDS(run, run, reason, by, utc)});
  const auto figure = [](const JudgedFigure& own) {
    Json json = {JSON_FIELDS(own, run, model_run)};
    json.update(figure_json(own));
    return json;
  };
  for (const JudgedFigure& own : judgement.stored_worse) stored.push_back(figure(own));
  for (const Remark& remark : judgement.remarks) remarks.push_back(display_text(remark, psi));
  const auto of = [&](const std::optional<std::size_t>& at) { return at ? figure(judgement.figures[*at]) : Json(); };
  return {{"overall", verdict_text(judgement.overall)},
          {"statement", statement_text(judgement, psi)},
          {"rests_on_means_alone", judgement.rests_on_means_alone},
          {"deciding", of(judgement.deciding)},
          {"closest_pass", of(judgement.closest_pass)},
          {"not_judged", judgement.not_judged ? display_text(*judgement.not_judged, psi) : ""},
          {"runs", runs},
          {"decided_by", judgement.decided_by},
          {"kinds_left_open", kinds_left_open(judgement)},
          {"not_assessed", missing},
          {"untraced", judgement.untraced ? display_text(*judgement.untraced, psi) : ""},
          {"void_runs", voids},
          {"stored_worse", stored},
          {"remarks", remarks}};
}

namespace {

constexpr double kFullSweepShare = 0.01;  // as external_loop
constexpr double kOtherDwellShare = 0.2;
constexpr std::size_t kFewestRandomTurns = 8;
constexpr double kTurnsAtEndsShare = 1.0 / 3.0;  // of random reversals at most; a first-order reversal curve has half

std::vector<double> set_points_of(const SequenceData& data) {
  std::vector<double> set_points;
  if (data.repeats.empty()) return set_points;
  for (const Sample& step : data.repeats.front().steps) set_points.push_back(step.setpoint_psi);
  return set_points;
}

bool same_path(const std::vector<double>& a, const std::vector<double>& b) {
  return std::ranges::equal(a, b, same_level);
}

double median_held_s(const Dataset& dataset) {
  std::vector<double> held;
  for (const SequenceData& data : dataset.sequences)
    for (const Repeat& repeat : data.repeats)
      for (const Sample& step : repeat.steps)
        if (step.held_s > 0.0) held.push_back(step.held_s);
  return median_of(std::move(held));
}

struct Path {
  std::size_t turns = 0, at_ends = 0, frames = 0, inner = 0;
};

Path path_of(const std::vector<double>& set_points, double low, double high) {
  Path path;
  const double near = kFullSweepShare * (high - low);
  const auto at_end = [&](double psi) { return psi - low <= near || high - psi <= near; };
  const std::vector<Branch> branches = branches_along(set_points);
  for (std::size_t i = 0; i < branches.size(); ++i) {
    const double from = set_points[static_cast<std::size_t>(branches[i].first)],
                 to = set_points[static_cast<std::size_t>(branches[i].last)];
    const auto frames = static_cast<std::size_t>(branches[i].last - branches[i].first);
    path.frames += frames;
    if (std::abs(to - from) < high - low - 2.0 * near) path.inner += frames;
    if (i + 1 == branches.size()) continue;
    ++path.turns;
    path.at_ends += at_end(to) ? 1 : 0;
  }
  return path;
}

}  // namespace

const char* to_string(Trajectory trajectory) {
  switch (trajectory) {
    case Trajectory::kAsFitted:
      return "set-points as fitted";
    case Trajectory::kRandomReversals:
      return "random reversals";
    case Trajectory::kOther:
      break;
  }
  return "other set-points";
}

JudgedTrajectory judged_trajectory(const Dataset& judged, const Dataset& fitted) {
  JudgedTrajectory out;
  out.run = judged.run;
  std::vector<std::vector<double>> own, known;
  for (const SequenceData& data : judged.sequences) own.push_back(set_points_of(data));
  for (const SequenceData& data : fitted.sequences) known.push_back(set_points_of(data));
  double low = kNan, high = kNan;
  for (const std::vector<double>& set_points : own)
    for (const double psi : set_points) {
      low = std::fmin(low, psi);
      high = std::fmax(high, psi);
    }
  bool as_fitted = true, random = false;
  std::size_t frames = 0, inner = 0;
  for (const std::vector<double>& set_points : own) {
    as_fitted &= std::ranges::any_of(known, [&](const auto& other) { return same_path(set_points, other); });
    const Path path = path_of(set_points, low, high);
    frames += path.frames;
    inner += path.inner;
    out.reversals = std::max(out.reversals, path.turns);
    random |= path.turns >= kFewestRandomTurns &&
              static_cast<double>(path.at_ends) < kTurnsAtEndsShare * static_cast<double>(path.turns);
  }
  out.inner_share = frames > 0 ? static_cast<double>(inner) / static_cast<double>(frames) : 0.0;
  out.trajectory = as_fitted ? Trajectory::kAsFitted : random ? Trajectory::kRandomReversals : Trajectory::kOther;
  set_dwell(out, median_held_s(judged), median_held_s(fitted));
  return out;
}

void set_dwell(JudgedTrajectory& judged, double dwell_s, double fitted_dwell_s) {
  judged.dwell_s = dwell_s;
  judged.fitted_dwell_s = fitted_dwell_s;
  judged.other_dwell = std::abs(dwell_s - fitted_dwell_s) > kOtherDwellShare * fitted_dwell_s;
}

std::string display_text(const JudgedTrajectory& judged) {
  std::string text = fmt::format("{}: {}, {:.0f} % of the frames on inner branches", to_string(judged.trajectory),
                                 counted(judged.reversals, "turning point"), 100.0 * judged.inner_share);
  if (std::isfinite(judged.dwell_s)) text += fmt::format("; dwell {:.1f} s", judged.dwell_s);
  if (judged.other_dwell) text += fmt::format(" (fitted: {:.1f} s)", judged.fitted_dwell_s);
  return text;
}

}  // namespace tactbench::analysis
