// A store whose fits and verdicts are verified.
#pragma once

#include <fmt/format.h>

#include <catch2/catch.hpp>
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
  made.levels = kFilmInnerLoop;
  made.sequences = std::move(sequences);
  made.columns = 2;
  made.tags = {"nightly"};  // whose frames may be removed
  return made;
}

inline const std::string kVerifiedLimits =
    "schema = 1\nname = \"a\"\nrule = \"simple\"\nmean_compensation_error_psi = 30\nworst_taxel_error_psi = 60\n"
    "distance_of_mean_percent_fs = 100\nunfit_taxels = 1\n";

class VerifiedStore : public FilmStore {
 public:
  std::int64_t fitted(std::int64_t run, const analysis::FitOptions& options = {}) {
    return bench::keep_fit(store, analysis::fit_array(analysis::load_dataset(store, run), options));
  }
  // The verdicts, judged and stored by the limits, as `fit` does.
  void judge(std::int64_t fit, const std::vector<std::int64_t>& held_out,
             const std::vector<analysis::InstrumentNote>& notes = {}) {
    write_file(path("limits.toml"), kVerifiedLimits);
    analysis::Runs runs(store);
    const analysis::SensorModel models = analysis::load_fit(store.fit(fit));
    (void)bench::judge_and_store(store, runs, models, bench::evaluate_runs(runs, models, held_out), path("limits.toml"),
                                 false, notes);
  }
  // "fit of run, what, rows: holds", "differs", or "left" where it cannot be worked out again.
  static std::string outcome(const bench::VerifiedResult& result) {
    return fmt::format("{} of {}, {}, {}: {}", result.fit, result.fit_run, result.what, result.rows,
                       !result.difference.empty() ? "differs"
                       : result.recomputed        ? "holds"
                                                  : "left");
  }
  [[nodiscard]] std::vector<bench::VerifiedResult> results(std::int64_t run) const {
    return bench::verify_run(store, run).results;
  }
  // Of a run whose content holds: the outcomes, of which the first difference is told.
  [[nodiscard]] std::vector<std::string> verified(std::int64_t run) const {
    std::vector<std::string> lines;
    const bench::RunVerification verified = bench::verify_run(store, run);
    std::string first;
    for (const bench::VerifiedResult& result : verified.results) {
      lines.push_back(outcome(result));
      if (first.empty()) first = result.difference;
    }
    CHECK(verified.first_difference.empty() == first.empty());
    CHECK(verified.first_difference.ends_with(first));
    return lines;
  }
  void change(const std::string& sql) const {
    db::sqlite::Connection(store.path(), db::sqlite::Access::kReadWrite).execute(sql.c_str());
  }
  void prune(std::int64_t run) { (void)store.prune_frames(run, "old nights", "2026-04-01T00:00:00Z"); }
};

using VerifiedLines = std::vector<std::string>;

}  // namespace tactbench::tests
