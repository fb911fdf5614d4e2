#include "bench/nightly/night_store.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iterator>
#include <map>
#include <set>
#include <tuple>
#include <utility>

#include "analysis/counted.h"
#include "db/hash_chain.h"

namespace tactbench::bench {
namespace {

// Whether the scenario's runs have the same frames as the runs that start with `earlier`. A scenario's runs have
// successive numbers and one purpose.
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
std::vector<std::string> changed_figures(const TrendReader& history, std::int64_t earlier,
                                         const std::map<std::string, double>& figures) {
  std::vector<std::string> lines;
  std::size_t stored_figures = 0;
  for (const auto& [name, before] : history.figures_of(earlier)) {
    const auto own = figures.find(name);
    stored_figures += own == figures.end() ? 0 : 1;
    if (own == figures.end())
      lines.push_back(fmt::format("{} is missing; run {} has it, with the same frames", name, earlier));
    else if (!equal(own->second, before))
      lines.push_back(
          fmt::format("{} is {:.9g}, was {:.9g} in run {}, with the same frames", name, own->second, before, earlier));
  }
  if (stored_figures < figures.size())
    lines.push_back(fmt::format("{} that run {}, with the same frames, does not have",
                                analysis::counted(figures.size() - stored_figures, "figure"), earlier));
  return lines;
}

// Compares the scenario with the last one with the same seeds, if any: fixed seeds must give the same data.
void compare_with_before(const db::RunStore& store, const std::string& subject, const TrendReader& history,
                         ScenarioResult& result) {
  const db::RunRecord own = store.run(result.runs.front().run);
  const std::int64_t earlier = store.last_run_of(subject, own.seed, own.sensor_seed, own.run);
  if (earlier == 0) {
    result.compared = "first run with this seed";
    return;
  }
  if (same_frames(store, result.runs, earlier)) {
    result.compared = fmt::format("same frames as run {}", earlier);
    std::ranges::move(changed_figures(history, earlier, result.figures), std::back_inserter(result.remarks));
    return;
  }
  const db::RunRecord before = store.run(earlier);
  result.compared = fmt::format("frames changed since run {} ({}, commit {})", earlier,
                                before.started_utc.substr(0, 10), before.git_commit.substr(0, 12));
  result.remarks.push_back(fmt::format("with the same seeds the {}", result.compared));
}

}  // namespace

std::string subject_of(const Scenario& scenario) { return fmt::format("nightly/{}", scenario.name); }

StoreOfResult in_stores_of(const std::string& folder) {
  return [folder](const ScenarioResult& result) {
    return db::RunStore::open_read_only((std::filesystem::path(folder) / fmt::format("{}.db", result.name)).string());
  };
}

namespace {

// For all seeds of a scenario except the last, earlier runs are not shown.
void keep_newest_alone(SubjectTrend& followed) {
  for (TrendFigure& figure : followed.figures) {
    figure.runs = {figure.runs.back()};
    figure.values = {figure.values.back()};
    figure.accepted = {figure.accepted.back()};
  }
}

std::size_t place_of(const Suite& suite, const ScenarioResult& result) {
  return static_cast<std::size_t>(std::ranges::find(suite.scenarios, result.name, &Scenario::label) -
                                  suite.scenarios.begin());
}

// The numbers in `store` of a result's runs; empty: it does not have them.
std::vector<std::int64_t> numbers_here(const db::RunStore& source, const ScenarioResult& result,
                                       const db::RunStore& store) {
  std::vector<std::int64_t> numbers;
  for (const ScenarioRun& run : result.runs) {
    const std::int64_t here = store.run_of_uuid(source.run(run.run).uuid);
    if (here != 0) numbers.push_back(here);
  }
  return numbers.size() == result.runs.size() ? numbers : std::vector<std::int64_t>();
}

std::vector<std::int64_t> take_runs(const db::RunStore& source, const ScenarioResult& result, db::RunStore& store) {
  if (std::vector<std::int64_t> there = numbers_here(source, result, store); !there.empty()) return there;
  std::vector<std::int64_t> numbers;
  for (const ScenarioRun& run : result.runs) numbers.push_back(run.run);
  return store.copy_runs_from(source, numbers);
}

bool same_night(const db::NightRecord& a, const db::NightRecord& b) {
  return a.suite_toml == b.suite_toml && a.selection_json == b.selection_json && a.begun_utc == b.begun_utc &&
         a.shard == b.shard && a.shards == b.shards && a.results.size() == b.results.size() &&
         std::ranges::equal(a.results, b.results, {}, &db::NightResultRecord::first_run,
                            &db::NightResultRecord::first_run);
}

}  // namespace

bool store_night(db::NightRecord night, const Suite& suite, std::vector<ScenarioResult>& results,
                 const StoreOfResult& store_of, db::RunStore& store) {
  for (ScenarioResult& result : results) {
    const std::size_t place = place_of(suite, result);
    if (!result.runs.empty()) {
      const std::vector<std::int64_t> numbers = take_runs(store_of(result), result, store);
      for (std::size_t i = 0; i < numbers.size(); ++i) {
        result.runs[i].run = numbers[i];
        store.set_tags(numbers[i], {"nightly"}, {});
      }
      store.replace_figures(numbers.front(), subject_of(suite.scenarios.at(place)), result.figures);
    }
    night.results.push_back(
        {static_cast<int>(place), result.name, to_json(result), result.runs.empty() ? 0 : result.runs.front().run});
  }
  if (std::ranges::any_of(store.nights(), [&](const db::NightRecord& own) { return same_night(own, night); }))
    return false;
  store.add_night(night);
  return true;
}

std::vector<SubjectTrend> compare_night(const Suite& suite, std::vector<ScenarioResult>& results,
                                        const db::RunStore& store) {
  std::vector<std::pair<ScenarioResult*, SubjectTrend>> night;
  std::map<std::string, TrendReader> histories;
  for (ScenarioResult& result : results) {
    if (result.runs.empty()) continue;
    const std::string subject = subject_of(suite.scenarios.at(place_of(suite, result)));
    const TrendReader& history = histories.try_emplace(subject, store, subject).first->second;
    compare_with_before(store, subject, history, result);
    if (!night.empty() && night.back().second.subject == subject) keep_newest_alone(night.back().second);
    night.emplace_back(&result, history.up_to(result.runs.front().run));
  }
  std::vector<SubjectTrend*> family;
  for (auto& [result, followed] : night) family.push_back(&followed);
  judge_shifts(family);
  std::vector<SubjectTrend> all;
  for (auto& [result, followed] : night) {
    std::ranges::move(outside_band_lines(followed), std::back_inserter(result->wrong));
    std::ranges::move(shift_lines(followed), std::back_inserter(result->remarks));
    if (!all.empty() && all.back().subject == followed.subject) all.pop_back();  // another seed of the same scenario
    all.push_back(std::move(followed));
  }
  return all;
}

namespace {

bool same_fit(const db::FitRecord& a, const db::FitRecord& b) {
  const auto said = [](const db::FitRecord& fit) {
    return std::tie(fit.model, fit.stands, fit.fitted, fit.document, fit.made_by, fit.program_version, fit.created_utc);
  };
  return said(a) == said(b);
}

void copy_figures(const db::RunStore& other, std::int64_t there, db::RunStore& store, std::int64_t here) {
  const std::set<std::string> known = [&] {
    const std::vector<std::string> subjects = store.subjects_of(here);
    return std::set(subjects.begin(), subjects.end());
  }();
  for (const std::string& subject : other.subjects_of(there)) {
    if (known.contains(subject)) continue;
    store.replace_figures(here, subject, other.figures_of(there, subject));
  }
}

}  // namespace

std::size_t copy_fits(const db::RunStore& other, std::int64_t there, db::RunStore& store, std::int64_t here) {
  if (const std::vector<std::string> wrong = other.check_seals(there); !wrong.empty())
    throw db::StoreError(
        "TB-STORE-CONFLICT",
        fmt::format("store {}: run {} has changed since it was stored: {}", other.path(), there, wrong.front()),
        "tactbench verify RUN shows more; restore the last snapshot");
  const std::vector<db::FitRecord> known = store.fits(here);
  std::map<std::int64_t, std::int64_t> taken;
  for (db::FitRecord fit : other.fits(there)) {
    if (std::ranges::any_of(known, [&](const db::FitRecord& own) { return same_fit(own, fit); })) continue;
    const std::int64_t number = fit.fit;
    fit.run = here;
    taken[number] = store.add_fit(fit);
  }
  std::map<std::pair<std::int64_t, std::string>, std::vector<db::VerdictRecord>> judged;  // by fit and limits
  for (const db::VerdictRecord& verdict : other.verdicts(there))
    if (taken.contains(verdict.fit)) judged[{verdict.fit, verdict.limits_sha256}].push_back(verdict);
  for (const auto& [by, verdicts] : judged) store.replace_verdicts(here, taken.at(by.first), verdicts);
  copy_figures(other, there, store, here);
  return taken.size();
}

}  // namespace tactbench::bench
