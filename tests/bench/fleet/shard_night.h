// A night in three parts, and stores of its parts.
#pragma once

#include <filesystem>
#include <string>

#include "bench/fleet/shard_folder.h"
#include "db/run_store.h"

namespace tactbench::tests {

inline bench::ShardedNight night_of_three() {
  bench::ShardedNight night;
  night.words = {"nightly", "./it's.toml", "--jobs", "3"};
  night.suite.name = "parts";
  night.suite.file = "parts.toml";
  night.suite.text = "schema = 1\n";
  night.selection_json = "{\"only\":\"\"}";
  night.shards = 3;
  night.jobs = 4;
  return night;
}

inline db::NightRecord record_of_part(int shard) {
  db::NightRecord record;
  record.suite = "parts";
  record.suite_file = "parts.toml";
  record.suite_toml = "schema = 1\n";
  record.selection_json = "{\"only\":\"\"}";
  record.shard = shard;
  record.shards = 3;
  record.begun_utc = record.ended_utc = "2026-01-01T00:00:00Z";
  record.program = "p";
  return record;
}

inline void store_part(const std::string& path, const db::NightRecord& record) {
  std::filesystem::remove(path);
  (void)db::RunStore::open(path, db::Durability::kNormal).add_night(record);
}

}  // namespace tactbench::tests
