// Derives verdicts from evidence: Evidence (runs, which of them count, why others do not) -> judge(Evidence, Limits) ->
// Judgement, which is stored, printed, rendered. Pure functions. Runs that the models were made from, including those
// for lag and creep of a dynamic model, would look too good and are no evidence; nor is a void run.
#pragma once

#include <array>
#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "analysis/judgement/figure.h"
#include "analysis/judgement/trajectory.h"
#include "analysis/statistics/uncertainty/instrument_calibration.h"
#include "analysis/statistics/uncertainty/reference_uncertainty.h"

namespace tactbench::analysis {

// Dominant sources of error in use. Each is assessed when a judged run shows it or a study is in the budgets.
enum class Source { kHistory, kRemounting, kTemperature, kTime, kCreep, kReferenceAge };
inline constexpr std::array kSources = {Source::kHistory, Source::kRemounting, Source::kTemperature,
                                        Source::kTime,    Source::kCreep,      Source::kReferenceAge};
const char* to_string(Source source);         // "re-mounting"
const char* why_not_assessed(Source source);  // "no judged run and no study is of the sensor mounted anew"

// Who declared a run void, when and why.
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
    kNoIndependentData,  // there are only runs that the models were made from
    kModelsVoid,         // `voided` is what the models were made from
    kOnVoid,             // stored verdicts rest on a void run, which is not known any more
    kVoidCounted,        // `voided` counts on request
    kVoidLeftOut,        // `voided` was to be judged
    kStoredOnVoid,       // the models were judged on `voided`
    kOtherModels,        // `fit` of `run` was judged, which has other models
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
  enum class Counts { kYes, kVoidOnRequest, kVoid, kUsedByModels };  // kUsedByModels: also what lag and creep are from
  std::int64_t run = 0;
  Counts counts = Counts::kYes;
  VoidRun voided = {};
  std::vector<Figure> figures;     // all that limits may ask for; empty for a run that does not count
  ReferenceUncertainty reference;  // on the run's day
  JudgedTrajectory trajectory;
  std::set<Source> shows = {};  // in which it differs from the run of the models; kReferenceAge: a date is stated
};

struct Evidence {
  std::int64_t fit = 0, model_run = 0;  // of the models
  std::vector<VoidRun> models_void;     // what the models were made from and was declared void
  bool void_too = false;                // void runs were asked for
  std::vector<EvidenceRun> runs;
  std::set<Source> studied;          // by further runs, in the budgets
  std::vector<JudgedFigure> stored;  // verdicts on the same models that still count
  std::vector<Remark> lost;          // why stored verdicts do not
};

struct JudgedRun {
  std::int64_t run = 0;
  Verdict verdict = Verdict::kInconclusive;  // the worst of its figures
  JudgedTrajectory trajectory;
};

struct Judgement {
  std::vector<JudgedFigure> figures;  // of each run in turn, in the order of the limits; none without limits
  // Inconclusive when the figures are not judged, fail when a stored verdict is fail, else the worst figure's; none
  // without limits.
  std::optional<Verdict> overall;
  std::optional<Remark> not_judged;         // why the figures are no evidence: then each is inconclusive
  std::vector<JudgedRun> runs;              // in the order of the figures; none when not judged
  std::vector<std::int64_t> decided_by;     // the runs whose verdict is the worst, by number
  std::optional<std::size_t> deciding;      // in `figures`: of the worst verdict the one furthest beyond its limit
  std::optional<std::size_t> closest_pass;  // of those that pass the one closest to its limit
  bool rests_on_means_alone = false;        // it passes, and no requirement is on single readings ([[mpe]])
  std::vector<Source> not_assessed;         // with any, a pass is one under repeatability conditions only (VIM 2.20)
  std::optional<TraceabilityGap> untraced;  // of the first run whose errors against the reference are not traceable
  // Stored verdicts on these models that are worse than the figures': by other limits, or on runs left out.
  std::vector<JudgedFigure> stored_worse;
  std::vector<Remark> remarks;
  std::vector<VoidRun> void_counted;
  std::string limits_name, limits_toml, limits_sha256;  // what was judged by; empty: nothing
};

// What the limits do not ask for is left out; what they ask for and no run has is a figure that was not measured, and
// inconclusive. Errors against a reference that was overdue, or beyond its certificate, are inconclusive, whatever U
// and limit say; differences and counts are not concerned. Where no run counts, the first one's figures are listed.
Judgement judge(const Evidence& evidence, const Limits& limits);

// Of figures with their verdicts, such as stored ones: what follows from them alone (overall, runs, decided_by,
// deciding, closest_pass, rests_on_means_alone). not_judged and stored_worse count when they are given.
void conclude(Judgement& judgement);

// The worst of the verdicts; none without figures.
std::optional<Verdict> worst_of(std::span<const JudgedFigure> figures);

// Text after the verdict itself: ", under repeatability conditions only", ", of means alone", ": reference overdue
// since ..."; empty: none.
std::string condition_text(const Judgement& judgement, PressureUnit unit);
// The overall verdict as a statement: "pass, under repeatability conditions only"; empty without one.
std::string statement_text(const Judgement& judgement, PressureUnit unit);
// Of a pass by [[mpe]] the kinds of history that no judged run's U was counted for: "held pressures"; empty: none, or a
// stored verdict, which does not tell.
std::vector<std::string> kinds_left_open(const Judgement& judgement);
// "re-mounting; temperature"; empty: all are assessed.
std::string not_assessed_text(const Judgement& judgement);

// overall statement rests_on_means_alone deciding closest_pass not_judged runs decided_by kinds_left_open not_assessed
// untraced void_runs stored_worse remarks. Texts state pressures in psi.
nlohmann::ordered_json judgement_json(const Judgement& judgement);

}  // namespace tactbench::analysis
