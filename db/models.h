// What is concluded from runs: fits of models, verdicts by limits, figures over time, baselines and approved reports.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "db/record.h"

namespace tactbench::db {

class Database;

// Part of a RunStore.
class Models {
 public:
  explicit Models(Database& database) : database_(&database) {}

  std::int64_t add_fit(const FitRecord& fit);
  // The newest fit marked `stands`; if there is none, the newest fit.
  [[nodiscard]] std::optional<FitRecord> default_fit(std::int64_t run) const;
  [[nodiscard]] FitRecord fit(std::int64_t fit) const;
  [[nodiscard]] std::vector<FitRecord> fits(std::int64_t run) const;  // oldest first
  // Replaces the run's verdicts by the same limits from any fit of the same model on the same run as `fit`. Verdicts
  // from other models or by other limits stay: a later limits file does not undo a verdict by an earlier one. fit 0:
  // judged without a stored fit.
  void replace_verdicts(std::int64_t run, std::int64_t fit, const std::vector<VerdictRecord>& verdicts);
  // For copies of runs from several stores with one run each: sets the fits of the run's verdicts, in the order of
  // verdicts(); 0: unchanged.
  void link_verdicts(std::int64_t run, const std::vector<std::int64_t>& fits);
  [[nodiscard]] std::vector<VerdictRecord> verdicts(
      std::int64_t run) const;  // verdicts on the run, in the order stored
  // Verdicts on any run, from all fits that were made from this run; in the order stored.
  [[nodiscard]] std::vector<VerdictRecord> verdicts_of_models(std::int64_t run) const;

  // Figures tracked over time. Replaces all figures of this subject in this run.
  void replace_figures(std::int64_t run, const std::string& subject, const std::map<std::string, double>& figures);
  // Figures of runs that are not void, by run, then name. Empty subject: figures of all subjects.
  [[nodiscard]] std::vector<FigureRecord> figures(const std::string& subject) const;
  [[nodiscard]] std::vector<std::string> subjects() const;  // of all figures, by name
  [[nodiscard]] std::vector<std::string> subjects_of(std::int64_t run) const;
  [[nodiscard]] std::map<std::string, double> figures_of(std::int64_t run, const std::string& subject) const;
  // The newest run before `before` with these seeds and figures of this subject; 0: none.
  [[nodiscard]] std::int64_t last_run_of(const std::string& subject, std::int64_t seed, std::int64_t sensor_seed,
                                         std::int64_t before) const;
  // The runs of `runs` that repeat an earlier one, each with that earlier run: they have the same content (and so the
  // same seeds), or the same value of every figure of the subject, unless all figures are whole numbers. A repetition
  // adds nothing to the spread.
  [[nodiscard]] std::map<std::int64_t, std::int64_t> repeated_runs(const std::string& subject,
                                                                   std::vector<std::int64_t> runs) const;

  // TB-STORE-BLANK without reason or name. TB-STORE-CONFLICT without date or runs, for a void run, for a run without
  // figures of the subject, for runs of several origins, and for several runs that all repeat the same run, so that no
  // figure has a spread.
  std::int64_t add_baseline(const BaselineRecord& baseline);
  // Copies a baseline that was accepted in another store, with the numbers of its runs here; it is not judged again.
  // TB-STORE-CONFLICT when a run does not exist.
  std::int64_t copy_baseline(const BaselineRecord& baseline);
  [[nodiscard]] std::vector<BaselineRecord> baselines() const;  // oldest first; the last one of a subject is in use
  [[nodiscard]] std::optional<BaselineRecord> last_baseline(const std::string& subject) const;

  // Approved reports. TB-STORE-BLANK without name, TB-STORE-CONFLICT when that number is approved already, or when
  // `replaces` is not the last approved report; a report that replaces another needs a reason (TB-STORE-BLANK), others
  // must not have one.
  void add_report(const ReportRecord& report);
  [[nodiscard]] std::vector<ReportRecord> reports(std::int64_t run) const;  // oldest first
  [[nodiscard]] std::vector<ReportRecord> reports() const;                  // of all runs

 private:
  Database* database_;
};

}  // namespace tactbench::db
