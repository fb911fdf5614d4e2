#include "bench/cli/models/fit_many.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "analysis/counted.h"
#include "analysis/identify/stored/model_document.h"
#include "bench/cli/session.h"
#include "db/run_store.h"

namespace tactbench::bench {
namespace {

std::vector<std::int64_t> chosen_runs(const std::string& source, const db::RunStore& store, bool void_too) {
  const std::vector<RunRange> ranges = run_ranges(source);
  std::vector<std::int64_t> chosen;
  for (const db::RunRecord& run : store.runs()) {
    const auto inside = [&](const RunRange& range) { return range.holds(run.run); };
    if (std::ranges::none_of(ranges, inside) || run.outcome == db::Outcome::kIncomplete) continue;
    if ((run.is_void() && !void_too) || store.pruned(run.run) || store.frame_count(run.run) == 0) continue;
    chosen.push_back(run.run);
  }
  if (!chosen.empty()) return chosen;
  throw Error("TB-FIT-NONE", fmt::format("of the runs {} none can be fitted", source), store.path(),
              "tactbench runs list shows what there is; void runs are taken with --void-too");
}

}  // namespace

bool names_runs(const std::string& source) {
  return source.find_first_of("-,") != std::string::npos && !run_ranges(source).empty();
}

void fit_many(const FitModelsOptions& options, Session& session) {
  if (!options.output.empty() || !options.plot.empty() || !options.score.empty() || options.rate_run != 0 ||
      options.mean_taxel)
    throw Error("TB-USAGE", "several runs are fitted with one model each, of every taxel", "fit",
                "leave out --score, --rate, --creep, --output, --plot and --mean-taxel; or name one run");
  const std::vector<std::int64_t> runs =
      chosen_runs(options.source, db::RunStore::open_read_only(session.db), session.void_too);
  auto list = nlohmann::ordered_json::array();
  std::size_t failed = 0;
  for (const std::int64_t run : runs) {
    FitModelsOptions own = options;
    nlohmann::ordered_json row = {{"run", run}};
    try {
      own.source = std::to_string(run);
      const JudgedFit fit = fit_and_judge(own, session);
      const analysis::Evaluation& e = fit.evaluations.front().evaluation;
      row.update({{"fit", fit.model.fit}, {"taxels", fit.model.fitted().size()}, {"mean_error_psi", e.mean_error_psi}});
      if (!session.json)
        tty::print("run {:>5}: fit {}, {}, {}; mean error on the run itself {:.3f} psi\n", run, fit.model.fit,
                   analysis::label_of(fit.model), analysis::counted(fit.model.fitted().size(), "taxel"),
                   e.mean_error_psi);
    } catch (...) {
      const Error error = as_error(std::current_exception());
      if (error.code() == ExitCode::kStore || error.code() == ExitCode::kStopped || error.code() == ExitCode::kInternal)
        throw;
      ++failed;
      row["error"] = error.id();
      if (!session.json) tty::print("run {:>5}: not fitted: {} [{}]\n", run, one_line(error.what()), error.id());
    }
    list.push_back(row);
  }
  if (failed > 0) session.code = ExitCode::kInconclusive;
  if (session.json)
    print_json("fit.runs", {{"store", session.db}, {"runs", list}});
  else
    tty::print("{} fitted, {} not\n", analysis::counted(list.size() - failed, "run"), failed);
}

}  // namespace tactbench::bench
