#include "bench/benchmarks/large_store.h"

#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <stdexcept>

#include "bench/benchmarks/own_program.h"
#include "db/run_store.h"

namespace tactbench::bench {
namespace {

constexpr int kFramesPerRun = 40;  // of 16 x 16 counts: the run of an inspection
constexpr int kSubjects = 58;      // as many as a night has scenarios
constexpr int kShown = 20;         // runs of the last day

db::RunRecord bulk_run(int number, int runs) {
  db::RunRecord run;
  run.uuid = db::new_uuid();
  run.origin = "simulated";
  run.state = "prepared";
  run.operator_name = "nightly";
  run.purpose = fmt::format("bulk {}", number);
  run.sensor_serial = "B-1";
  run.bench_id = "bulk";
  run.bench_toml = std::string(3000, '#');
  run.sensor_toml = std::string(600, '#');
  run.seed = number;
  run.started_utc = number < runs - kShown ? "2025-06-01T00:00:00Z" : "2026-01-31T00:00:00Z";
  run.sequences = {{0, "frames", std::string(1500, '#'), "", 1, kFramesPerRun}};
  run.devices = {{"tactile scanner", "synthetic", "1", "", "simulated", R"({"volts_per_count":0.0001})"}};
  return run;
}

void add_bulk(db::RunStore& store, int number, int runs, std::vector<db::FrameRecord>& frames) {
  const std::int64_t run = store.begin_run(bulk_run(number, runs));
  db::BranchRecord branch;
  branch.to_psi = 60.0;
  const std::int64_t of = store.begin_branch(run, branch);
  for (db::FrameRecord& frame : frames) {
    frame.branch = of;
    frame.counts[0] = static_cast<std::uint16_t>(number);
    store.append_frame(run, frame);
  }
  store.end_run(run, db::Outcome::kCompleted, "all steps done", db::SafeState::kVerified, "2026-01-31T01:00:00Z");
  store.set_tags(run, {"nightly"}, {});
  std::map<std::string, double> figures;
  for (int i = 0; i < 12; ++i) figures[fmt::format("figure_{}_psi", i)] = std::sin(1.0 + number * (i + 1));
  store.replace_figures(run, fmt::format("bulk/{}", number % kSubjects), figures);
  db::FitRecord fit;
  fit.run = run;
  fit.model = "bulk";
  const std::int64_t models = store.add_fit(fit, {});
  std::vector<db::VerdictRecord> verdicts(4);
  for (db::VerdictRecord& verdict : verdicts) {
    verdict.verdict = std::string("pass");
    verdict.scope = std::string("array");
    verdict.limits_sha256 = std::string("limits");
  }
  store.replace_verdicts(run, models, verdicts);
}

}  // namespace

void make_large_store(const std::string& path, int runs, const std::string& real) {
  db::RunStore store = db::RunStore::open(path, db::Durability::kNormal);
  store.add_sensor({"B-1", "synthetic", "", db::sha256_hex(""), "", "", ""});
  std::vector<db::FrameRecord> frames;
  for (int i = 0; i < kFramesPerRun; ++i) {
    db::FrameRecord& frame = frames.emplace_back();
    frame.rows = frame.columns = 16;
    frame.scans = 1;
    frame.ordinal = i;
    frame.setpoint_psi = frame.feedback_psi = frame.reference_psi = 60.0 * i / kFramesPerRun;
    frame.time_ns = std::int64_t{2'000'000'000} * i;
    for (int t = 0; t < 256; ++t) frame.counts.push_back(static_cast<std::uint16_t>(i * 251 + t * 7));
    frame.trace.resize(10);
  }
  for (int number = 0; number < runs - 2; ++number) add_bulk(store, number, runs, frames);
  store.copy_runs_from(db::RunStore::open_read_only(real), {1, 2});
}

std::vector<Figure> benchmark_large_store(const std::vector<int>& runs, int rounds, const std::string& folder,
                                          const std::string& file) {
  FigureList figures("large-store");
  const OwnProgram program(folder, file);
  program.run({"init"});
  program.run({"sensors", "add", "S-1", "--type", "sensor.toml", "--db", "real.db"});
  for (const char* seed : {"1", "2"})
    program.run({"run", "production", "--bench", "bench.toml", "--sensor", "S-1", "--operator", "benchmark", "--yes",
                 "-q", "--seed", seed, "--db", "real.db"});
  program.run({"fit", "1", "--held-out", "2", "--limits", "limits.toml", "--db", "real.db"});
  for (const int count : runs) {
    const std::string store = fmt::format("{}.db", count), path = fmt::format("{}/{}", folder, store);
    make_large_store(path, count, folder + "/real.db");
    const std::string real = std::to_string(count - 1);
    const auto add = [&](const char* name, const std::vector<std::string>& words) {
      std::vector<std::string> all = words;
      all.insert(all.end(), {"--db", store});
      figures.add(fmt::format("{}_of_{}", name, count), 1e3 * program.best_seconds(rounds, all), "ms");
    };
    figures.add(fmt::format("file_of_{}", count), 1e-6 * static_cast<double>(std::filesystem::file_size(path)), "MB");
    add("open_and_show", {"runs", "show", real});
    add("runs_list_all", {"runs", "list"});
    add("runs_list_20", {"runs", "list", "--since", "2026-01-31", "--sensor", "B-1"});
    add("trend_of_a_subject", {"trend", "--subject", "bulk/7"});
    add("trend_of_all", {"trend"});
    add("report", {"report", real, "-o", "report.html"});
    add("verify", {"verify", real});
    add("db_check", {"db", "check"});
    std::filesystem::remove(path);
  }
  return figures.take();
}

}  // namespace tactbench::bench
