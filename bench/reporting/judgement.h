// Verdicts on a fit's models: every run that they were not made from is judged, and the worst one counts. The run that
// they were made from flatters them and is no evidence, and neither are those that lag and creep of a dynamic model
// were taken from (source_runs.h); nor is a void run.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "analysis/report/report.h"
#include "analysis/report/runs.h"
#include "bench/reporting/named_evaluation.h"

namespace tactbench::bench {

struct Judgement {
  std::vector<db::VerdictRecord> verdicts;  // of each judged run in turn; empty without limits
  analysis::JudgementNotes notes;
  std::vector<analysis::JudgedUncertainty> uncertainties;  // of the figures judged now, where the rule needs them
  std::vector<db::RunRecord> void_runs;                    // void runs that were counted on request
};

// The stored verdicts on a fit's models, from all fits of the run with the same models.
struct StoredJudgement {
  std::vector<db::VerdictRecord> verdicts;  // in the order stored, without those on void runs
  std::vector<std::int64_t> runs;           // independent runs that they were judged on, by number
  std::string limits_toml;                  // of the newest verdict; empty: these models were never judged
  std::vector<std::string> lost;            // why stored verdicts no longer count
};
StoredJudgement stored_judgement(analysis::Runs& runs, const analysis::SensorModel& fit, bool void_too);

// The verdicts on one evaluation; U, where the rule needs it, is added to `uncertainties`. Verdicts that rest on
// pressures that are not traceable are inconclusive.
std::vector<db::VerdictRecord> judge_anew(analysis::Runs& runs, const analysis::SensorModel& fit,
                                          const analysis::Evaluation& evaluation, const analysis::Limits& limits,
                                          std::vector<analysis::JudgedUncertainty>* uncertainties = nullptr);

// Judges each evaluation of a run other than the models'; when none counts, the first one's figures are listed with the
// limits, not judged. `stored`: its verdicts by these limits are taken over, and worse ones are reported. Stores
// nothing.
Judgement judge_runs(analysis::Runs& runs, const analysis::SensorModel& fit,
                     const std::vector<NamedEvaluation>& evaluations, const analysis::Limits& limits, bool void_too,
                     const StoredJudgement& stored = {});

// The same by a limits file, and stores the verdicts with the fit; for a report-only file stores nothing. `store`: that
// of `runs`. `notes` of a laboratory file can make a reference overdue (instrument_calibration.h).
Judgement judge_and_store(db::RunStore& store, analysis::Runs& runs, const analysis::SensorModel& fit,
                          const std::vector<NamedEvaluation>& evaluations, const std::string& limits_file,
                          bool void_too = false, const std::vector<analysis::InstrumentNote>& notes = {});

// For `report`: judges by `limits_file`, else by the limits last used for these models; without either no verdicts.
Judgement judge_for_report(analysis::Runs& runs, const analysis::SensorModel& fit,
                           const std::vector<NamedEvaluation>& evaluations, const std::string& limits_file,
                           const StoredJudgement& stored, bool void_too);

// The stored verdicts on a run without models: the newest judgement, and worse ones.
Judgement judgement_on(const db::RunStore& store, std::int64_t run);

// All stored verdicts of a run that still count: on it, and on any run by models made from it. Verdicts on the models'
// own runs are inconclusive and count only when there are no others. None for a void run, and none by models that rest
// on a void one.
std::vector<db::VerdictRecord> standing_verdicts(const db::RunStore& store, std::int64_t run);
// Fail if any verdict is fail, else the worst one by the newest limits; none without rows.
std::optional<analysis::Verdict> standing_verdict(const std::vector<db::VerdictRecord>& standing);

}  // namespace tactbench::bench
