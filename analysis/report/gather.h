// Collects a report's input from a run, except for models, figures and verdicts.
#pragma once

#include <cstdint>
#include <exception>
#include <map>
#include <optional>
#include <vector>

#include "analysis/dataset.h"
#include "analysis/report/report.h"
#include "analysis/report/run_log.h"
#include "analysis/statistics/studies/contact.h"

// Cache of the runs that one command uses, each read from the store once: the row on first use, all other data with the
// first result that needs them. Functions take a Runs instead of a store and a run number.

namespace tactbench::analysis {

// For one command and one thread. A result does not change after the first call; references are valid as long as the
// Runs object. The frames are not kept, because they need more memory than all results. `store` must outlive the
// object.
class Runs {
 public:
  explicit Runs(const db::RunStore& store) : store_(store) {}
  Runs(const Runs&) = delete;
  Runs& operator=(const Runs&) = delete;

  [[nodiscard]] const db::RunStore& store() const { return store_; }
  // The run's row. Throws StoreError TB-STORE-NOT-FOUND.
  const db::RunRecord& record(std::int64_t run);
  // Results of load_dataset, load_press_runs, load_run_log and temperatures_of. Their exceptions are thrown at each
  // call; StoreError if the run cannot be read. The history does not contain the sensor's earlier seating.
  const Dataset& dataset(std::int64_t run);
  const std::vector<PressRun>& press_runs(std::int64_t run);
  const RunLog& history(std::int64_t run);
  const std::vector<double>& temperatures_c(std::int64_t run);

 private:
  // A value, or the exception of its computation.
  template <class Value>
  struct Result {
    std::optional<Value> value;
    std::exception_ptr error;
    template <class Compute>
    void set_from(Compute compute) {
      try {
        value = compute();
      } catch (...) {
        error = std::current_exception();
      }
    }
    [[nodiscard]] const Value& get() const {
      if (error) std::rethrow_exception(error);
      return *value;
    }
  };
  struct Results {
    Result<Dataset> dataset;
    Result<std::vector<PressRun>> press_runs;
    Result<RunLog> history;
    Result<std::vector<double>> temperatures_c;
  };
  const Results& results_of_run(std::int64_t run);

  const db::RunStore& store_;
  std::map<std::int64_t, db::RunRecord> records_;
  std::map<std::int64_t, Results> results_;
};

// Fills in run, sensor, frame_count, history, health, behaviour (also creep of the further runs) and approvals of run
// `run`; fit and evaluation, if any, must be in `input` before. Throws StoreError, AnalysisError.
void gather_run(ReportInput& input, Runs& runs, std::int64_t run, const std::vector<std::int64_t>& further = {});

// The taxels used for raw figures: those with a model; if there are no models, those that the health check accepts.
std::vector<int> counted_taxels(const SensorModel& fit, const Health& health);

}  // namespace tactbench::analysis
