// Derives verdicts from evidence: Evidence (the runs, which of them count, and why others do not) -> judge(Evidence,
// Limits) -> Judgement, which is stored, printed, rendered. Pure functions. Runs from which the models were made,
// including those for lag and creep of a dynamic model, would give too small errors and are not evidence. A void run is
// not evidence either.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "analysis/dataset.h"
#include "analysis/judgement/figure.h"
#include "analysis/statistics/uncertainty/instruments.h"
#include "analysis/statistics/uncertainty/reference_uncertainty.h"

namespace tactbench::analysis {

// Compares the pressure trajectory of a judged run with that of the models' fit: an error is valid only for
// trajectories of the kind on which it was measured.
enum class Trajectory { kAsFitted, kRandomReversals, kOther };
const char* to_string(Trajectory trajectory);  // "set-points as fitted", "random reversals", "other set-points"

struct JudgedTrajectory {
  std::int64_t run = 0;
  Trajectory trajectory = Trajectory::kAsFitted;
  std::size_t reversals = 0;                   // turning points within the longest sequence
  double inner_share = 0.0;                    // share of the frames on branches that do not span the range
  double dwell_s = 0.0, fitted_dwell_s = 0.0;  // dwell of each run, see below
  bool other_dwell = false;                    // the two dwells differ by more than a fifth
};

// As fitted: each sequence has the same set-points in the same order as a sequence of `fitted`, however often repeated.
// Random reversals: at least eight turning points in a sequence, fewer than a third of them at the ends of the range.
// Dwell: the median time from a set-point's command to its frame, unless set_dwell() sets the requested one.
JudgedTrajectory judged_trajectory(const Dataset& judged, const Dataset& fitted);

// Sets the dwell requested by the recipes, from pressure in band to the frame.
void set_dwell(JudgedTrajectory& judged, double dwell_s, double fitted_dwell_s);

// "random reversals: 32 turning points, 87 % of the frames on inner branches; dwell 2.0 s (fitted: 1.0 s)".
std::string display_text(const JudgedTrajectory& judged);

// Dominant sources of error in use. Each is assessed if a judged run shows it or the budgets contain a study of it.
enum class Source { kHistory, kRemounting, kTemperature, kTime, kCreep, kReferenceAge };
inline constexpr std::array kSources = {Source::kHistory, Source::kRemounting, Source::kTemperature,
                                        Source::kTime,    Source::kCreep,      Source::kReferenceAge};
const char* to_string(Source source);         // "re-mounting"
const char* why_not_assessed(Source source);  // "no judged run and no study has the sensor re-mounted"

// A void run: who declared it void, when and why.
struct VoidRun {
  std::int64_t run = 0;
  std::string by, utc, reason;
};
VoidRun void_of(const db::RunRecord& run);
// "run 7 was declared void by me on 2026-01-31T12:00:00Z: gauge closed".
std::string display_text(const VoidRun& run);

// A statement in addition to the verdicts, or in place of them.
struct Remark {
  enum class Kind {
    kNoIndependentData,  // there are only runs from which the models were made
    kModelsVoid,         // the models were made from `voided`
    kOnVoid,             // stored verdicts are based on a void run that is not known any more
    kVoidCounted,        // the void run `voided` counts on request
    kVoidLeftOut,        // the void run `voided` was not judged
    kStoredOnVoid,       // the models were judged on `voided`
    kOtherModels,        // `fit` of `run`, with other models, was judged
    kNotTraceable,       // errors of `run` against the reference are not traceable: `untraced`
  };
  Kind kind = Kind::kNoIndependentData;
  VoidRun voided = {};
  std::int64_t run = 0, fit = 0;
  std::optional<TraceabilityGap> untraced = {};
};
std::string display_text(const Remark& remark, PressureUnit unit);

// A run that may be judged.
struct EvidenceRun {
  enum class Counts { kYes, kVoidOnRequest, kVoid, kUsedByModels };  // kUsedByModels: also for lag and creep
  std::int64_t run = 0;
  Counts counts = Counts::kYes;
  VoidRun voided = {};
  std::vector<Figure> figures;     // all figures that limits may require; empty for a run that does not count
  ReferenceUncertainty reference;  // valid on the day of the run
  JudgedTrajectory trajectory;
  std::set<Source> shows =
      {};  // sources in which it differs from the run of the models; kReferenceAge: a date is stated
};

struct Evidence {
  std::int64_t fit = 0, model_run = 0;  // fit and run of the models
  std::vector<VoidRun> models_void;     // void runs from which the models were made
  bool void_too = false;                // void runs were requested
  std::vector<EvidenceRun> runs;
  std::set<Source> studied;          // sources that further runs assessed in the budgets
  std::vector<JudgedFigure> stored;  // valid stored verdicts on the same models
  std::vector<Remark> lost;          // why other stored verdicts are not valid
};

struct JudgedRun {
  std::int64_t run = 0;
  Verdict verdict = Verdict::kInconclusive;  // the worst of its figures
  JudgedTrajectory trajectory;
};

struct Judgement {
  std::vector<JudgedFigure> figures;  // run by run, in the order of the limits; none without limits
  // Inconclusive if the figures are not judged, fail if a stored verdict is fail, else the verdict of the worst figure;
  // none without limits.
  std::optional<Verdict> overall;
  std::optional<Remark> not_judged;      // why the figures are not evidence: then each is inconclusive
  std::vector<JudgedRun> runs;           // in the order of the figures; empty if not judged
  std::vector<std::int64_t> decided_by;  // runs with the worst verdict, by number
  std::optional<std::size_t>
      deciding;  // index in `figures`: the one furthest beyond its limit among those with the worst verdict
  std::optional<std::size_t> closest_pass;  // index of the passed figure closest to its limit
  bool rests_on_means_alone = false;        // it passes, and no requirement applies to single readings ([[mpe]])
  std::vector<Source> not_assessed;         // if not empty, a pass holds under repeatability conditions only (VIM 2.20)
  std::optional<TraceabilityGap> untraced;  // for the first run with untraceable errors against the reference
  // Stored verdicts on these models that are worse than those of the figures: by other limits, or on runs left out.
  std::vector<JudgedFigure> stored_worse;
  std::vector<Remark> remarks;
  std::vector<VoidRun> void_counted;
  std::string limits_name, limits_toml, limits_sha256;  // the limits used; empty: none
};

// Figures without a limit are left out. A figure with a limit that no run has is listed as not measured and
// inconclusive. Errors against a reference that was overdue, or used beyond its certificate, are inconclusive whatever
// U and limit are; differences and counts are not affected. If no run counts, the figures of the first run are listed.
Judgement judge(const Evidence& evidence, const Limits& limits);

// Computes, from figures that have verdicts (such as stored ones), the members that follow from them: overall, runs,
// decided_by, deciding, closest_pass, rests_on_means_alone. not_judged and stored_worse are taken into account if set.
void conclude(Judgement& judgement);

// The worst of the verdicts; none without figures.
std::optional<Verdict> worst_of(std::span<const JudgedFigure> figures);

// Text after the verdict itself: ", under repeatability conditions only", ", of means alone", ": reference overdue
// since ..."; empty: none.
std::string condition_text(const Judgement& judgement, PressureUnit unit);
// The overall verdict as a statement: "pass, under repeatability conditions only"; empty without a verdict.
std::string statement_text(const Judgement& judgement, PressureUnit unit);
// For a pass by [[mpe]]: the kinds of history for which no judged run has U: "held pressures". Empty: none, or a stored
// verdict, which does not record them.
std::vector<std::string> kinds_left_open(const Judgement& judgement);
// "re-mounting; temperature"; empty: all are assessed.
std::string not_assessed_text(const Judgement& judgement);

// overall statement rests_on_means_alone deciding closest_pass not_judged runs decided_by kinds_left_open not_assessed
// untraced void_runs stored_worse remarks. Texts state pressures in psi.
nlohmann::ordered_json judgement_json(const Judgement& judgement);

}  // namespace tactbench::analysis
