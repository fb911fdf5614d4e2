#include "bench/cli/models/fit_many.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <nlohmann/json.hpp>
#include <sstream>
#include <utility>

#include "analysis/counted.h"
#include "analysis/identify/stored/model_document.h"
#include "bench/cli/session.h"
#include "db/run_store.h"

namespace tactbench::bench {
namespace {

using Range = std::pair<std::int64_t, std::int64_t>;

// Empty: not a list of runs.
std::vector<Range> ranges_in(const std::string& source) {
  std::vector<Range> ranges;
  std::istringstream parts(source);
  for (std::string part; std::getline(parts, part, ',');) {
    Range range{0, 0};
    const char *const begin = part.data(), *const end = begin + part.size();
    const auto first = std::from_chars(begin, end, range.first);
    range.second = range.first;
    const char* last = first.ptr;
    if (first.ec == std::errc() && last != end && *last == '-') {
      const auto second = std::from_chars(last + 1, end, range.second);
      if (second.ec != std::errc()) return {};
      last = second.ptr;
    }
    if (first.ec != std::errc() || last != end || range.first < 1 || range.second < range.first) return {};
    ranges.push_back(range);
  }
  return ranges;
}

std::vector<std::int64_t> chosen_runs(const std::string& source, const db::RunStore& store, bool void_too) {
  const std::vector<Range> ranges = ranges_in(source);
  std::vector<std::int64_t> chosen;
  for (const db::RunRecord& run : store.runs()) {
    const auto inside = [&](const Range& range) { return run.run >= range.first && run.run <= range.second; };
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
  return source.find_first_of("-,") != std::string::npos && !ranges_in(source).empty();
}

void fit_many(const FitModelsOptions& options, Session& session) {
  if (options.models.size() > 1 || !options.output.empty() || !options.score.empty() || !options.held_out.empty() ||
      options.rate_run != 0)
    throw Error("TB-USAGE", "several runs are fitted with one model each, and not judged", "fit",
                "leave out --score, --held-out, --rate, --creep, --output, and name one --model; or name one run");
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
