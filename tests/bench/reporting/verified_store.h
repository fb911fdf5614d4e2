// A store whose fits and verdicts are verified, each result in one line.
#pragma once

#include <fmt/format.h>

#include <string>
#include <utility>
#include <vector>

#include "analysis/identify/stored/model_document.h"
#include "bench/reporting/evaluation.h"
#include "bench/reporting/judgement.h"
#include "bench/reporting/verification.h"
#include "db/sqlite.h"
#include "tests/bench/reporting/film_runs.h"

namespace tactbench::tests {

inline FilmRun film_inner_loops(std::vector<std::string> sequences = {"a"}) {
  FilmRun made;
  made.levels = {0.0,  10.0, 20.0, 30.0, 40.0, 50.0, 60.0, 50.0, 40.0, 30.0, 20.0,
                 30.0, 40.0, 50.0, 60.0, 50.0, 40.0, 30.0, 20.0, 10.0, 0.0};
  made.sequences = std::move(sequences);
  made.columns = 2;
  made.tags = {"nightly"};  // whose frames may be removed
  return made;
}

inline const std::string kVerifiedLimits =
    "schema = 1\nname = \"a\"\nrule = \"simple\"\nmean_compensation_error_psi = 30\nworst_taxel_error_psi = 60\n"
    "distance_of_mean_percent_fs = 100\nunfit_taxels = 1\n";

inline bool is_film_build() { return bench::this_build().find("modified") == std::string::npos; }

// What is said of a fit of this build.
inline std::string by_film_build() {
  return is_film_build() ? "bit for bit: same build and class of processor"
                         : fmt::format("1e-12 relative: the fit is of {0}, this is {0}", bench::this_build());
}

class VerifiedStore : public FilmStore {
 public:
  std::int64_t fitted(std::int64_t run, const analysis::FitOptions& options = {}) {
    return bench::keep_fit(store, analysis::fit_array(analysis::load_dataset(store, run), options));
  }
  // Judged and stored by the limits, as `fit` does.
  void judge(std::int64_t fit, const std::vector<std::int64_t>& held_out,
             const std::vector<analysis::InstrumentNote>& notes = {}) {
    write_file(path("limits.toml"), kVerifiedLimits);
    analysis::Runs runs(store);
    const analysis::SensorModel models = analysis::load_fit(store.fit(fit));
    (void)bench::judge_and_store(store, runs, models, bench::evaluate_runs(runs, models, held_out), path("limits.toml"),
                                 false, notes);
  }
  // "fit of run, what, rows, recomputed: compared | difference"
  static std::string in_words(const bench::VerifiedResult& result) {
    return fmt::format("{} of {}, {}, {}{}: {} | {}", result.fit, result.fit_run, result.what, result.rows,
                       result.recomputed ? ", recomputed" : "", result.compared, result.difference);
  }
  [[nodiscard]] std::vector<std::string> verified(std::int64_t run) const {
    std::vector<std::string> lines;
    const bench::RunVerification verified = bench::verify_run(store, run);
    for (const bench::VerifiedResult& result : verified.results) lines.push_back(in_words(result));
    lines.push_back(verified.first_difference);
    return lines;
  }
  void change(const std::string& sql) const {
    db::sqlite::Connection(store.path(), db::sqlite::Access::kReadWrite).execute(sql.c_str());
  }
  void prune(std::int64_t run) { (void)store.prune_frames(run, "old nights", "2026-04-01T00:00:00Z"); }
};

using VerifiedLines = std::vector<std::string>;

}  // namespace tactbench::tests
