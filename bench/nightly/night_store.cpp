#include "bench/nightly/night_store.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>
#include <iterator>
#include <set>
#include <utility>

#include "analysis/counted.h"
#include "db/frames_hash.h"

namespace tactbench::bench {
namespace {

// The run whose scenario was carried out last with the same seeds; 0: none.
std::int64_t last_with_these_seeds(const db::RunStore& store, const std::string& subject, const db::RunRecord& own) {
  std::set<std::int64_t, std::greater<>> earlier;
  for (const db::FigureRecord& figure : store.figures(subject))
    if (figure.run < own.run) earlier.insert(figure.run);
  for (const std::int64_t run : earlier) {
    const db::RunRecord record = store.run(run);
    if (record.seed == own.seed && record.sensor_seed == own.sensor_seed) return run;
  }
  return 0;
}

// Whether the scenario's runs measured what those beginning with `earlier` did. A scenario's runs have successive
// numbers and one purpose.
bool same_frames(const db::RunStore& store, const std::vector<ScenarioRun>& runs, std::int64_t earlier) {
  const std::string purpose = store.run(earlier).purpose;
  for (std::size_t i = 0; i < runs.size(); ++i) {
    const std::int64_t number = earlier + static_cast<std::int64_t>(i);
    if (number >= runs.front().run || store.run(number).purpose != purpose) return false;
    if (db::frames_hash(store, number) != db::frames_hash(store, runs[i].run)) return false;
  }
  return true;
}

bool equal(double a, double b) { return a == b || std::abs(a - b) <= 1e-9 * std::max(std::abs(a), std::abs(b)); }

// Equal frames must give equal figures.
std::vector<std::string> changed_figures(const db::RunStore& store, const std::string& subject, std::int64_t earlier,
                                         const std::map<std::string, double>& figures) {
  std::vector<std::string> lines;
  std::size_t present = 0;
  for (const db::FigureRecord& before : store.figures(subject)) {
    if (before.run != earlier) continue;
    const auto own = figures.find(before.name);
    present += own == figures.end() ? 0 : 1;
    if (own == figures.end())
      lines.push_back(fmt::format("{} is missing; run {} has it, of the same frames", before.name, earlier));
    else if (!equal(own->second, before.value))
      lines.push_back(fmt::format("{} is {:.9g}, was {:.9g} in run {}, of the same frames", before.name, own->second,
                                  before.value, earlier));
  }
  if (present < figures.size())
    lines.push_back(fmt::format("{} that run {} does not have, of the same frames",
                                analysis::counted(figures.size() - present, "figure"), earlier));
  return lines;
}

// Fixed seeds are held by what they measured: compares the scenario with the last one of the same seeds, if any.
void compare_with_before(const db::RunStore& store, const std::string& subject, ScenarioResult& result) {
  const db::RunRecord own = store.run(result.runs.front().run);
  const std::int64_t earlier = last_with_these_seeds(store, subject, own);
  if (earlier == 0) {
    result.compared = "first run with this seed";
    return;
  }
  if (same_frames(store, result.runs, earlier)) {
    result.compared = fmt::format("same frames as run {}", earlier);
    std::ranges::move(changed_figures(store, subject, earlier, result.figures), std::back_inserter(result.remarks));
    return;
  }
  const db::RunRecord before = store.run(earlier);
  result.compared = fmt::format("frames changed since run {} ({}, commit {})", earlier,
                                before.started_utc.substr(0, 10), before.git_commit.substr(0, 12));
  result.remarks.push_back(fmt::format("with the same seeds the {}", result.compared));
}

}  // namespace

std::string subject_of(const Scenario& scenario) { return fmt::format("nightly/{}", scenario.name); }

std::vector<Followed> keep_night(const Suite& suite, std::vector<ScenarioResult>& results, const std::string& stores,
                                 db::RunStore& store) {
  std::vector<std::pair<ScenarioResult*, Followed>> night;
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
    compare_with_before(store, subject, result);
    night.emplace_back(&result, follow(store, subject));
  }
  std::vector<Followed*> family;
  for (auto& [result, followed] : night) family.push_back(&followed);
  judge_together(family);
  std::vector<Followed> all;
  for (auto& [result, followed] : night) {
    std::ranges::move(outside_lines(followed), std::back_inserter(result->wrong));
    std::ranges::move(shift_lines(followed), std::back_inserter(result->remarks));
    if (!all.empty() && all.back().subject == followed.subject) all.pop_back();  // another seed of the same scenario
    all.push_back(std::move(followed));
  }
  return all;
}

}  // namespace tactbench::bench
