#include "bench/nightly/night_store.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <functional>
#include <iterator>
#include <set>

namespace tactbench::bench {
namespace {

// Whether the newest earlier run of the subject with the same seeds has the same content.
std::string compared_with_before(const db::RunStore& store, const std::string& subject, std::int64_t newest) {
  const db::RunRecord own = store.run(newest);
  std::set<std::int64_t, std::greater<>> earlier_runs;
  for (const db::FigureRecord& figure : store.figures(subject))
    if (figure.run < newest) earlier_runs.insert(figure.run);
  for (const std::int64_t number : earlier_runs) {
    const db::RunRecord earlier = store.run(number);
    if (earlier.seed != own.seed || earlier.sensor_seed != own.sensor_seed) continue;
    if (earlier.content_sha256 == own.content_sha256) return fmt::format("same content as run {}", number);
    return fmt::format("content changed since run {} ({}, commit {})", number, earlier.started_utc.substr(0, 10),
                       earlier.git_commit.substr(0, 12));
  }
  return "first run with this seed";
}

}  // namespace

std::string subject_of(const Scenario& scenario) { return fmt::format("nightly/{}", scenario.name); }

std::vector<Followed> keep_night(const Suite& suite, std::vector<ScenarioResult>& results, const std::string& stores,
                                 db::RunStore& store) {
  std::vector<Followed> all;
  std::size_t figures = 0;
  for (const ScenarioResult& result : results) figures += result.figures.size();
  for (ScenarioResult& result : results) {
    const Scenario& scenario = *std::ranges::find(suite.scenarios, result.name, &Scenario::label);
    if (result.runs.empty()) continue;
    const db::RunStore own =
        db::RunStore::open_read_only((std::filesystem::path(stores) / fmt::format("{}.db", result.name)).string());
    std::vector<std::int64_t> numbers;
    for (const ScenarioRun& run : result.runs) numbers.push_back(run.run);
    numbers = store.copy_runs_from(own, numbers);
    for (std::size_t i = 0; i < numbers.size(); ++i) {
      result.runs[i].run = numbers[i];
      store.set_tags(numbers[i], {"nightly"}, {});
    }
    const std::string subject = subject_of(scenario);
    store.replace_figures(numbers.front(), subject, result.figures);
    result.compared = compared_with_before(store, subject, numbers.front());
    Followed followed = follow(store, subject, figures);
    std::ranges::move(outside_lines(followed), std::back_inserter(result.wrong));
    std::ranges::move(drift_lines(followed), std::back_inserter(result.remarks));
    if (!all.empty() && all.back().subject == subject) all.pop_back();  // another seed of the same scenario
    all.push_back(std::move(followed));
  }
  return all;
}

}  // namespace tactbench::bench
