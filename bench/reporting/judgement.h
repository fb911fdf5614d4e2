// Verdicts on what a fit's models are worth: every run that they were not made from is judged, the worst one counts.
// The run that they were made from shows them at their kindest and is no evidence; neither is a void run.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "analysis/report/report.h"
#include "analysis/report/runs.h"
#include "bench/reporting/named_evaluation.h"

namespace tactbench::bench {

struct Judgement {
  std::vector<db::VerdictRecord> verdicts;  // of each run judged, one after the other; empty without limits
  analysis::JudgementNotes notes;
  std::vector<analysis::JudgedUncertainty> uncertainties;  // of the figures judged anew, where the rule asks for them
  std::vector<db::RunRecord> void_runs;                    // that count all the same
};

// What is stored of a fit's models, by whichever of the run's fits that has the same ones.
struct StoredJudgement {
  std::vector<db::VerdictRecord> verdicts;  // in the order stored, those on void runs left out
  std::vector<std::int64_t> runs;           // that they were judged on and that are independent data, by number
  std::string limits_toml;                  // of the newest; empty: these models were never judged
  std::vector<std::string> lost;            // why stored verdicts count no more
};
StoredJudgement stored_judgement(analysis::Runs& runs, const analysis::ArrayFit& fit, bool void_too);

// The verdict on one evaluation, with U where the rule asks for it, which is added to `uncertainties`. What rests on a
// reference that was overdue is inconclusive.
std::vector<db::VerdictRecord> judge_anew(analysis::Runs& runs, const analysis::ArrayFit& fit,
                                          const analysis::Evaluation& evaluation, const analysis::Limits& limits,
                                          std::vector<analysis::JudgedUncertainty>* uncertainties = nullptr);

// As judge_anew() did before an overdue reference counted: for verdicts that are that old.
std::vector<db::VerdictRecord> judge_by_earlier_rules(analysis::Runs& runs, const analysis::ArrayFit& fit,
                                                      const analysis::Evaluation& evaluation,
                                                      const analysis::Limits& limits);

// Judges each evaluation of another run than the models'; where there is none that counts, the first one's figures
// stand beside the limits, not judged. `stored`: its verdicts by these limits are taken as they are, and worse ones are
// said. Stores nothing.
Judgement judge_runs(analysis::Runs& runs, const analysis::ArrayFit& fit,
                     const std::vector<NamedEvaluation>& evaluations, const analysis::Limits& limits, bool void_too,
                     const StoredJudgement& stored = {});

// The same by a limits file, stored with the fit; of a report-only file nothing is stored. `store`: that of `runs`.
// `notes` of a laboratory file: they can make a reference overdue (instrument_calibration.h).
Judgement judge_and_store(db::RunStore& store, analysis::Runs& runs, const analysis::ArrayFit& fit,
                          const std::vector<NamedEvaluation>& evaluations, const std::string& limits_file,
                          bool void_too = false, const std::vector<analysis::InstrumentNote>& notes = {});

// For `report`: by `limits_file`, else by the limits that the models were judged by last; no verdicts without either.
Judgement judge_for_report(analysis::Runs& runs, const analysis::ArrayFit& fit,
                           const std::vector<NamedEvaluation>& evaluations, const std::string& limits_file,
                           const StoredJudgement& stored, bool void_too);

// What is stored of a run without models: the newest judgement on it, and worse ones.
Judgement judgement_on(const db::RunStore& store, std::int64_t run);

// All that is stored of a run and still counts: verdicts on it, and on any run by models made from it. What was judged
// on the models' own run is inconclusive, and counts only while there is nothing else. A void run has none.
std::vector<db::VerdictRecord> standing_verdicts(const db::RunStore& store, std::int64_t run);
// A fail where there is any, else the worst of what was judged by the newest limits; none without rows.
std::optional<analysis::Verdict> standing_verdict(const std::vector<db::VerdictRecord>& standing);

}  // namespace tactbench::bench
