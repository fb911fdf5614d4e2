// Collects the Evidence for judge() from runs: which runs may count, what was measured on them, which conditions of use
// they cover.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "analysis/judgement/judgement.h"
#include "analysis/report/runs.h"
#include "bench/reporting/named_evaluation.h"

namespace tactbench::bench {

// The stored verdicts on a fit's models, from all fits of the run with the same models.
struct StoredVerdicts {
  std::vector<analysis::JudgedFigure> figures;  // in the order stored, without those on void runs
  std::vector<std::int64_t> runs;               // independent runs that they were judged on, by number
  std::string limits_toml;                      // of the newest verdict; empty: these models were never judged
  std::vector<analysis::Remark> lost;           // why stored verdicts no longer count
};
StoredVerdicts stored_verdicts(analysis::Runs& runs, const analysis::SensorModel& fit, bool void_too);

// Of each evaluation a run; the figures of those that count, where none does of the first. U of a reading is that of
// the models' run without further runs (studies), so that stored verdicts do not depend on a report's. `notes`: of a
// laboratory file. Throws as evaluate(), StoreError.
analysis::Evidence gather_evidence(analysis::Runs& runs, const analysis::SensorModel& fit,
                                   const std::vector<NamedEvaluation>& evaluations, const analysis::Limits& limits,
                                   bool void_too, const std::vector<analysis::InstrumentNote>& notes = {},
                                   const StoredVerdicts& stored = {});

}  // namespace tactbench::bench
