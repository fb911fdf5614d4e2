#include "bench/nightly/night_store.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iterator>
#include <map>
#include <set>
#include <tuple>
#include <utility>

#include "analysis/counted.h"
#include "bench/common/error.h"
#include "db/hash_chain.h"

namespace tactbench::bench {
namespace {

// Whether the scenario's runs have the same frames as the runs that start with `earlier`. A scenario's runs have
// successive numbers and one purpose.
bool same_frames(const db::RunReader& store, const std::vector<ScenarioRun>& runs, std::int64_t earlier) {
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

void copy_figures(const db::Models& other, std::int64_t there, db::Models& store, std::int64_t here) {
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

std::size_t copy_fits(const db::RunStore& other, std::int64_t there, db::Models& store, std::int64_t here) {
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

namespace {

namespace fs = std::filesystem;

// A night or one part of it, and its store.
struct StoredPart {
  const db::RunStore* store = nullptr;
  db::NightRecord night;
};

[[noreturn]] void refuse_parts(const std::string& what, const std::string& where, const std::string& remedy) {
  throw Error("TB-MERGE-SHARD", what, where, remedy);
}

std::vector<db::RunStore> open_parts(const std::vector<std::string>& names, const db::RunStore& store) {
  std::vector<db::RunStore> parts;
  for (std::size_t i = 0; i < names.size(); ++i) {
    std::error_code missing;
    if (fs::equivalent(names[i], store.path(), missing))
      throw Error("TB-USAGE", "a store cannot be merged into itself", names[i], "leave it out");
    for (std::size_t j = 0; j < i; ++j)
      if (fs::equivalent(names[i], names[j], missing))
        throw Error("TB-USAGE", "this store is named twice", names[i], "name each store once");
    parts.push_back(db::RunStore::open_read_only(names[i]));
  }
  return parts;
}

std::vector<ScenarioResult> results_of(const StoredPart& part) {
  std::vector<ScenarioResult> results;
  for (const db::NightResultRecord& row : part.night.results) {
    try {
      results.push_back(result_from_json(row.json));
    } catch (const std::invalid_argument& error) {
      throw db::StoreError("TB-STORE-SQL",
                           fmt::format("store {}: night {}: {}", part.store->path(), part.night.night, error.what()),
                           "another program changed the file: restore your last snapshot");
    }
  }
  return results;
}

// Parts of one night have the same suite, choice and number of parts. Whole nights are nights of one part each.
std::vector<std::vector<StoredPart>> nights_in(const std::vector<db::RunStore>& parts) {
  std::map<std::tuple<std::string, std::string, int>, std::vector<StoredPart>> sharded;
  std::vector<std::vector<StoredPart>> nights;
  for (const db::RunStore& part : parts) {
    for (const db::NightRecord& night : part.nights()) {
      const StoredPart stored{&part, night};
      if (night.shards == 1)
        nights.push_back({stored});
      else
        sharded[{night.suite_toml, night.selection_json, night.shards}].push_back(stored);
    }
  }
  for (auto& [key, own] : sharded) {
    std::ranges::sort(own, {}, [](const StoredPart& part) { return part.night.shard; });
    const int shards = own.front().night.shards;
    std::vector<int> missing;
    for (int shard = 1, i = 0; shard <= shards; ++shard) {
      if (i >= static_cast<int>(own.size()) || own[static_cast<std::size_t>(i)].night.shard != shard) {
        missing.push_back(shard);
        continue;
      }
      const StoredPart& part = own[static_cast<std::size_t>(i++)];
      if (i < static_cast<int>(own.size()) && own[static_cast<std::size_t>(i)].night.shard == shard)
        refuse_parts(fmt::format("part {} of {} of the night {} is there twice", shard, shards, part.night.suite),
                     fmt::format("{}, {}", part.store->path(), own[static_cast<std::size_t>(i)].store->path()),
                     "merge each night separately");
    }
    if (!missing.empty())
      refuse_parts(fmt::format("of the night {}, {} of {} missing: {}", own.front().night.suite,
                               missing.size() == 1 ? "one part is" : fmt::format("{} parts are", missing.size()),
                               shards, fmt::join(missing, ", ")),
                   own.front().store->path(),
                   fmt::format("run them: tactbench nightly SUITE --shard K/{} --db FILE", shards));
    nights.push_back(std::move(own));
  }
  std::ranges::stable_sort(nights, {}, [](const auto& own) { return own.front().night.begun_utc; });
  return nights;
}

MergedNight merge_night(const std::vector<StoredPart>& parts, db::RunStore& store) {
  MergedNight merged;
  merged.record = parts.front().night;
  merged.record.results.clear();
  merged.record.shard = merged.record.shards = 1;
  merged.suite = selected(parse_suite(merged.record.suite_toml, merged.record.suite_file),
                          selection_from_json(merged.record.selection_json));
  std::map<std::string, const db::RunStore*> store_of;  // by label
  std::map<std::string, std::size_t> place;
  for (const Scenario& scenario : merged.suite.scenarios) place.try_emplace(scenario.label, place.size());
  std::set<std::string> programs;
  for (const StoredPart& part : parts) {
    programs.insert(part.night.program);
    merged.record.begun_utc = std::min(merged.record.begun_utc, part.night.begun_utc);
    merged.record.ended_utc = std::max(merged.record.ended_utc, part.night.ended_utc);
    for (ScenarioResult& result : results_of(part)) {
      if (!place.contains(result.name))
        throw db::StoreError("TB-STORE-SQL",
                             fmt::format("store {}: a night has a result of '{}', which its suite does not have",
                                         part.store->path(), result.name),
                             "another program changed the file: restore your last snapshot");
      store_of[result.name] = part.store;
      merged.results.push_back(std::move(result));
    }
  }
  merged.record.program = fmt::format("{}", fmt::join(programs, "; "));
  std::ranges::sort(merged.results, {}, [&](const ScenarioResult& result) { return place.at(result.name); });
  merged.there = !store_night(
      merged.record, merged.suite, merged.results,
      [&](const ScenarioResult& result) { return db::RunStore::open_read_only(store_of.at(result.name)->path()); },
      store);
  merged.followed = compare_night(merged.suite, merged.results, store);
  return merged;
}

// Merges the runs of `part` that do not belong to a night; runs of a night that is already there count as there.
void merge_runs(const db::RunStore& part, db::RunStore& store, MergedStores& merged) {
  std::set<std::int64_t> of_nights;
  for (const db::NightRecord& night : part.nights())
    for (const db::NightResultRecord& row : night.results)
      if (row.first_run != 0)
        for (const ScenarioRun& run : result_from_json(row.json).runs) of_nights.insert(run.run);
  std::vector<std::int64_t> missing;
  for (const db::RunRecord& run : part.runs()) {
    const std::int64_t here = store.run_of_uuid(run.uuid);
    if (here == 0) {
      if (!of_nights.contains(run.run)) missing.push_back(run.run);
      continue;
    }
    if (store.run(here).content_sha256 != run.content_sha256)
      throw db::StoreError("TB-STORE-CONFLICT",
                           fmt::format("run {} of {} and run {} of {} have one UUID ({}) and different content",
                                       run.run, part.path(), here, store.path(), run.uuid),
                           "tactbench verify shows which of them is unchanged");
    ++merged.there;
    merged.fits += copy_fits(part, run.run, store, here);
  }
  merged.runs += store.copy_runs_from(part, missing).size();
}

bool same_acceptance(const db::BaselineRecord& a, const db::BaselineRecord& b) {
  return a.subject == b.subject && a.reason == b.reason && a.accepted_by == b.accepted_by &&
         a.accepted_utc == b.accepted_utc && a.runs == b.runs;
}

// All of a baseline's runs are here by now.
void merge_baselines(const db::RunStore& part, db::RunStore& store, MergedStores& merged) {
  const std::vector<db::BaselineRecord> here = store.baselines();
  for (db::BaselineRecord baseline : part.baselines()) {
    for (std::int64_t& run : baseline.runs) run = store.run_of_uuid(part.run(run).uuid);
    std::ranges::sort(baseline.runs);
    if (std::ranges::any_of(here, [&](const auto& own) { return same_acceptance(own, baseline); })) continue;
    store.copy_baseline(baseline);
    ++merged.baselines;
  }
}

}  // namespace

MergedStores merge_stores(const std::vector<std::string>& names, db::RunStore& store) {
  const std::vector<db::RunStore> parts = open_parts(names, store);
  const auto nights = nights_in(parts);  // before anything is copied
  MergedStores merged;
  for (const db::RunStore& part : parts) merge_runs(part, store, merged);
  // A night is compared with the baselines that were accepted before it.
  const std::size_t before = store.runs().size();
  for (const auto& night : nights) merged.nights.push_back(merge_night(night, store));
  merged.runs += store.runs().size() - before;
  for (const db::RunStore& part : parts) merge_baselines(part, store, merged);
  return merged;
}

}  // namespace tactbench::bench
