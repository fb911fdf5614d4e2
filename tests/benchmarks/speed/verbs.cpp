// The program in processes of its own: verbs on stores of thousands of runs, and what many simulated characterizations
// take. Minutes, and a gigabyte of disk.
#include <benchmark/benchmark.h>
#include <fmt/format.h>
#include <sys/resource.h>
#include <sys/wait.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>

#include "bench/common/private_files.h"
#include "db/run_store.h"
#include "tests/support/paths.h"

namespace tactbench::speed {
namespace {

// `words` in `folder`; throws when the program ends with another exit code than 0, 1 or 6.
void program(const std::string& folder, const std::string& words) {
  const int status = std::system(
      fmt::format("cd '{}' && '{}' {} >said 2>&1 </dev/null", folder, tests::program_path(), words).c_str());
  const int code = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  if (code != 0 && code != 1 && code != 6)
    throw std::runtime_error(fmt::format("tactbench {} ended with {}; see {}/said", words, code, folder));
}

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
  const std::int64_t models = store.add_fit(fit);
  std::vector<db::VerdictRecord> verdicts(4);
  for (db::VerdictRecord& verdict : verdicts) {
    verdict.verdict = std::string("pass");
    verdict.limits_sha256 = std::string("limits");
  }
  store.replace_verdicts(run, models, verdicts);
}

// Small made-up runs with frames, figures, a fit and verdicts, and last two real characterizations. One store for each
// number of runs, <number>.db in the folder.
const std::string& folder_with_store(int runs) {
  static const bench::ScratchFolder scratch("tactbench-speed");
  const std::string &folder = scratch.path(), real = folder + "/real.db";
  if (!std::filesystem::exists(real)) {
    program(folder, "init");
    program(folder, "sensors add S-1 --type sensor.toml --db real.db");
    for (const int seed : {1, 2})
      program(folder,
              fmt::format("run production --bench bench.toml --sensor S-1 --operator benchmark --yes -q --seed {} "
                          "--db real.db",
                          seed));
    program(folder, "fit 1 --db real.db");
    program(folder, "judge 1 2 --limits limits.toml --db real.db");
  }
  const std::string path = fmt::format("{}/{}.db", folder, runs);
  if (std::filesystem::exists(path)) return folder;
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
  return folder;
}

// Words of the verb; {0} is the last run but one.
void verb(benchmark::State& state, const std::string& words) {
  const int runs = static_cast<int>(state.range(0));
  const std::string& folder = folder_with_store(runs);
  for (auto _ : state) program(folder, fmt::format(fmt::runtime(words), runs - 1) + fmt::format(" --db {}.db", runs));
  state.counters["file [MB]"] =
      1e-6 * static_cast<double>(std::filesystem::file_size(fmt::format("{}/{}.db", folder, runs)));
}

double core_seconds_of_ended_processes() {
  rusage usage{};
  ::getrusage(RUSAGE_CHILDREN, &usage);
  const auto seconds = [](const timeval& time) {
    return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
  };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

// 100 characterizations: each a rig and sensor of its own, the recipe `production`, ELAM for 256 taxels, figures, the
// night's page and store; in two parts, merged and pruned. Those of a million are a million times these.
void many_rigs(benchmark::State& state) {
  constexpr double kRigs = 100.0, kMillion = 1e6, kHour = 3600.0;
  for (auto _ : state) {
    const bench::ScratchFolder scratch("tactbench-speed");
    const std::string& folder = scratch.path();
    std::ofstream(folder + "/rigs.toml") << "schema = 1\nname = \"rigs\"\n[[scenario]]\nname = \"rig\"\n"
                                            "about = \"one characterization\"\nrecipes = [\"production\"]\n";
    const auto core_s = [&](const std::string& words) {
      const double before = core_seconds_of_ended_processes();
      program(folder, words);
      return core_seconds_of_ended_processes() - before;
    };
    const auto bytes = [&] { return static_cast<double>(std::filesystem::file_size(folder + "/all.db")); };
    const double night_s = core_s("nightly ./rigs.toml -q --seeds 100 --shard 1/2 --db 1.db") +
                           core_s("nightly ./rigs.toml -q --seeds 100 --shard 2/2 --db 2.db");
    const double merge_s = core_s("runs merge 1.db 2.db --db all.db --html all.html");
    const double kept = bytes();
    program(folder, "db prune --keep 2999-01-01 --yes --shrink --db all.db");
    state.SetIterationTime(night_s / kRigs);
    state.counters["store_of_one [MB]"] = 1e-6 * kept / kRigs;
    state.counters["store_of_one_pruned [MB]"] = 1e-6 * bytes() / kRigs;
    state.counters["million [core_h]"] = kMillion * night_s / kRigs / kHour;
    state.counters["million_merge [core_h]"] = kMillion * merge_s / kRigs / kHour;
    state.counters["million_store [TB]"] = 1e-12 * kMillion * kept / kRigs;
    state.counters["million_store_pruned [TB]"] = 1e-12 * kMillion * bytes() / kRigs;
  }
}
BENCHMARK(many_rigs)->UseManualTime()->Iterations(1)->Repetitions(1)->Unit(benchmark::kSecond);

const bool registered = [] {
  for (const auto& [name, words] :
       std::map<std::string, std::string>{{"open_and_show", "runs show {0}"},
                                          {"runs_list_all", "runs list"},
                                          {"runs_list_20", "runs list --since 2026-01-31 --sensor B-1"},
                                          {"trend_one_subject", "trend --subject bulk/7"},
                                          {"trend_all_subjects", "trend"},
                                          {"report", "report {0} -o report.html --replace"},
                                          {"verify", "verify {0}"},
                                          {"verify_store", "verify"}})
    benchmark::RegisterBenchmark(("large_store/" + name).c_str(), verb, words)
        ->Arg(2000)
        ->Arg(20000)
        ->Unit(benchmark::kMillisecond)
        ->UseRealTime()
        ->Iterations(1);
  return true;
}();

}  // namespace
}  // namespace tactbench::speed
