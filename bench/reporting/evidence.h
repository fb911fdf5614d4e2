// Collects the Evidence for judge() from runs: which runs may count, what was measured on them, which conditions of use
// they cover.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "analysis/identify/sensor_model.h"
#include "analysis/judgement/judgement.h"
#include "analysis/report/gather.h"
#include "bench/reporting/named_evaluation.h"
#include "db/run_store.h"

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

// Runs that models were made from: the fitted run and, for a dynamic model, those that lag and creep were taken from.
// None of them is independent data for the models.

// The number in this store of a run that lag or creep was taken from. Runs get new numbers in a copy of a store: the
// run is identified by its content, and by its number only where the model does not state the content. None: the store
// does not have it.
std::optional<std::int64_t> run_of_source(const db::RunStore& store, const analysis::SensorDynamics::Source& source);

// Each once, the fitted run first; what this store does not have is left out.
std::vector<std::int64_t> source_runs(const db::RunStore& store, const analysis::SensorModel& fit);

// Checks the runs that are named on the command line: which of them a verb may use.

struct RunSelectionRules {
  std::string at;                // the option or place, for the error: "--held-out"
  std::int64_t models_of = 0;    // the models were made from this run, which is no independent data; 0: any run goes
  bool void_can_be_used = true;  // --void-too is an option of the verb
};

// The runs as stored. Each must exist, be named once (TB-RUN-TWICE), not be the models' own (TB-RUN-OWN), and count: a
// void one is refused (TB-RUN-VOID), or, with `void_too` (--void-too), used with a warning on standard error.
std::vector<db::RunRecord> named_runs(analysis::Runs& runs, const std::vector<std::int64_t>& numbers,
                                      const RunSelectionRules& named, bool void_too);

}  // namespace tactbench::bench
