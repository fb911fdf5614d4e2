// Stores of the parts of a nightly run, and of benches, written directly: runs of one frame, results, fits, figures.
#pragma once

#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "bench/nightly/suite.h"
#include "db/run_store.h"
#include "tests/support/process.h"

namespace tactbench::tests {

inline const std::string kPartSuite =
    "schema = 1\nname = \"parts\"\n[[scenario]]\nname = \"one\"\nabout = \"first\"\n[[scenario]]\nname = "
    "\"two\"\nabout = \"second\"\n[[scenario]]\nname = \"three\"\nabout = \"third\"\n";

// Of that suite, without results.
inline db::NightRecord part_night(const std::string& begun_utc, const std::string& ended_utc,
                                  const std::string& program = "p") {
  db::NightRecord night;
  night.suite = "parts";
  night.suite_file = "parts.toml";
  night.suite_toml = kPartSuite;
  night.selection_json = bench::to_json(bench::Selection{});
  night.begun_utc = begun_utc;
  night.ended_utc = ended_utc;
  night.program = program;
  return night;
}

class PartStore {
 public:
  explicit PartStore(const std::string& path) : store(db::RunStore::open(path, db::Durability::kNormal)) {
    store.add_sensor({"SIM-0001", "t", "", db::sha256_hex(""), "", "", ""});
  }
  // `uuid` empty: its own. Its only frame has these counts.
  std::int64_t add_run(const std::string& purpose, std::int64_t seed, std::uint16_t counts = 7,
                       const std::string& uuid = {}) {
    db::RunRecord run;
    run.uuid = uuid.empty() ? db::new_uuid() : uuid;
    run.origin = "simulated";
    run.state = "prepared";
    run.sensor_serial = "SIM-0001";
    run.operator_name = "nightly";
    run.purpose = purpose;
    run.seed = seed;
    run.sensor_seed = 1;
    run.started_utc = "2026-01-02T03:04:05Z";
    run.git_commit = "0123456789abcdef0123";
    run.sequences = {{0, "s", "", "", 1, 1}};
    const std::int64_t number = store.begin_run(run);
    db::FrameRecord frame;
    frame.branch = store.begin_branch(number, {});
    frame.rows = frame.columns = frame.scans = 1;
    frame.counts = {counts};
    store.append_frame(number, frame);
    store.end_run(number, db::Outcome::kCompleted, "", db::SafeState::kVerified, "2026-01-02T03:05:00Z");
    return number;
  }
  // A result of that scenario with one run for each seed.
  bench::ScenarioResult add_result(const std::string& label, const std::vector<std::int64_t>& seeds,
                                   const std::map<std::string, double>& figures) {
    bench::ScenarioResult result;
    result.name = label;
    result.about = "of " + label;
    result.figures = figures;
    for (const std::int64_t seed : seeds) {
      const std::int64_t run = add_run("nightly: " + label, seed);
      result.runs.push_back({run, "completed", "", "verified", store.run(run).content_sha256});
    }
    return result;
  }
  void add_night(int shard, int shards, const std::string& begun_utc, const std::string& ended_utc,
                 const std::string& program, const std::vector<std::pair<int, bench::ScenarioResult>>& results) {
    db::NightRecord night = part_night(begun_utc, ended_utc, program);
    night.shard = shard;
    night.shards = shards;
    for (const auto& [position, result] : results)
      night.results.push_back(
          {position, result.name, bench::to_json(result), result.runs.empty() ? 0 : result.runs.front().run});
    (void)store.add_night(night);
  }
  db::RunStore store;
};

}  // namespace tactbench::tests
