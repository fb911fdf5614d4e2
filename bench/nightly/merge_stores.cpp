#include "bench/nightly/merge_stores.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <set>
#include <tuple>

#include "analysis/counted.h"
#include "bench/common/error.h"
#include "bench/nightly/night_store.h"

namespace tactbench::bench {
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
