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

// The stored verdicts on a fit's models, from all fits of the run that have the same models.
struct StoredVerdicts {
  std::vector<analysis::JudgedFigure> figures;  // in the order stored, without verdicts on void runs
  std::vector<std::int64_t> runs;               // independent runs on which they were judged, by number
  std::string limits_toml;                      // of the newest verdict; empty: these models were never judged
  std::vector<analysis::Remark> lost;           // reasons why stored verdicts no longer count
};
StoredVerdicts stored_verdicts(analysis::Runs& runs, const analysis::SensorModel& fit, bool void_too);

// One run per evaluation; the figures of the runs that count, or of the first if none does. U of a reading is computed
// from the models' run alone, so that stored verdicts do not depend on a report's studies. `notes`: from the laboratory
// file. Throws as evaluate(), StoreError.
analysis::Evidence gather_evidence(analysis::Runs& runs, const analysis::SensorModel& fit,
                                   const std::vector<NamedEvaluation>& evaluations, const analysis::Limits& limits,
                                   bool void_too, const std::vector<analysis::InstrumentNote>& notes = {},
                                   const StoredVerdicts& stored = {});

// Runs from which models were made: the fitted run and, for a dynamic model, those from which lag and creep were
// fitted. None of them is independent data for the models.

// The number in this store of a run from which lag or creep was fitted. Runs get new numbers in a copy of a store, so
// the run is identified by its content hash, or by its number if the model has no hash. None: the store does not have
// it.
std::optional<std::int64_t> run_of_source(const db::RunReader& store, const analysis::SensorDynamics::Source& source);

// Each run once, the fitted run first; runs that this store does not have are left out.
std::vector<std::int64_t> source_runs(const db::RunReader& store, const analysis::SensorModel& fit);

// Checks the runs that are named on the command line: which of them a verb may use.
struct RunSelectionRules {
  std::string at;  // the option or place, for the error: "--held-out"
  std::int64_t models_of =
      0;  // the models were made from this run, which is not independent data for them; 0: any run may be named
  bool void_can_be_used = true;  // the verb has the option --void-too
};

// The stored runs. Each must exist, be named only once (TB-RUN-TWICE) and not be the run of the models (TB-RUN-OWN). A
// void run is refused (TB-RUN-VOID) or, with `void_too` (--void-too), used with a warning on standard error.
std::vector<db::RunRecord> named_runs(analysis::Runs& runs, const std::vector<std::int64_t>& numbers,
                                      const RunSelectionRules& named, bool void_too);

}  // namespace tactbench::bench
