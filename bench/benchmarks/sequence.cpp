#include "bench/benchmarks/sequence.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <limits>

#include "bench/common/process_time.h"
#include "bench/common/utc.h"
#include "bench/rig/rig.h"
#include "bench/run/characterize.h"

namespace tactbench::bench {

namespace {

using RealClock = std::chrono::steady_clock;

double seconds_since(RealClock::time_point start) {
  return std::chrono::duration<double>(RealClock::now() - start).count();
}

RunRequest request_of(int round) {
  RunRequest request;
  request.bench = read_bench(find_config("simulated.toml"), {}, {static_cast<std::uint64_t>(round), 1});
  request.recipes = {sequences::read_recipe(
      find_recipe("descending"), {{"repeats", "1"}, {"conditioning.cycles", "0"}, {"conditioning.least", "0"}})};
  request.sensor_type = read_sensor_type(find_config("sensor.toml"));
  request.sensor = {"B-1",
                    request.sensor_type.name,
                    request.sensor_type.text,
                    db::sha256_hex(request.sensor_type.text),
                    "SIM-SCANNER-1",
                    "",
                    utc_now()};
  request.operator_name = "benchmark";
  request.check_seating = false;
  return request;
}

struct Taken {
  double run_s = 0.0;
  std::vector<db::FrameRecord> frames;
};

// From the first step to the last, set-up and way out left out.
Taken run_once(int round, const std::string& path) {
  db::RunStore store = db::RunStore::open(path, db::Durability::kNormal);
  RunRequest request = request_of(round);
  store.add_sensor(request.sensor);
  RealClock::time_point first{}, last{};
  request.on_step = [&](const sequences::Step&) {
    last = RealClock::now();
    if (first == RealClock::time_point{}) first = last;
  };
  Progress quiet(Progress::Mode::kQuiet);
  const RunResult result = characterize(request, store, quiet);
  if (result.error) throw *result.error;
  Taken taken{std::chrono::duration<double>(last - first).count(), store.frames(result.run)};
  taken.frames.pop_back();  // the last step's end is not known
  return taken;
}

// The same polls at the same times, the same commands and scans.
double exchanges_again(int round, const std::vector<db::FrameRecord>& frames) {
  Rig rig(request_of(round).bench);
  rig.open();
  const devices::Nanoseconds begun = rig.clock().now();
  const devices::Nanoseconds offset = begun - devices::Nanoseconds(frames.front().time_ns) + seconds(60.0);
  const auto start = RealClock::now();
  for (const db::FrameRecord& frame : frames) {
    const devices::Nanoseconds end = offset + devices::Nanoseconds(frame.time_ns);
    const devices::Nanoseconds command = end - devices::Nanoseconds(frame.since_command_ns);
    bool commanded = false;
    for (const db::TracePoint& point : frame.trace) {
      const devices::Nanoseconds time = end - seconds(static_cast<double>(point.before_frame_s));
      if (!commanded && time > command) {
        rig.clock().wait_until(command);
        (void)rig.source().command(devices::Psi(frame.setpoint_psi));
        commanded = true;
      }
      rig.clock().wait_until(time);
      rig.source().keep_alive();
      (void)rig.source().feedback();
      (void)rig.reference().read();
    }
    rig.clock().wait_until(end);
    (void)rig.array().read(frame.scans);
  }
  return seconds_since(start);
}

double frames_again(const std::vector<db::FrameRecord>& frames, int round, const std::string& path) {
  db::RunStore store = db::RunStore::open(path, db::Durability::kNormal);
  const RunRequest request = request_of(round);
  store.add_sensor(request.sensor);
  db::RunRecord run;
  run.uuid = db::new_uuid();
  run.origin = "simulated";
  run.state = "prepared";
  run.sensor_serial = request.sensor.serial;
  run.sequences = {{0, "descending", "", "", 1, static_cast<int>(frames.size())}};
  const std::int64_t number = store.begin_run(run);
  db::BranchRecord branch;
  const std::int64_t row = store.begin_branch(number, branch);
  const auto start = RealClock::now();
  for (db::FrameRecord frame : frames) {
    frame.branch = row;
    store.append_frame(number, frame);
  }
  return seconds_since(start);
}

}  // namespace

std::vector<Figure> benchmark_sequence(int rounds, const std::string& folder) {
  constexpr double kNone = std::numeric_limits<double>::infinity();
  SequenceTimes best{0.0, kNone, kNone, kNone};
  for (int round = 1; round <= rounds; ++round) {
    const Taken taken = run_once(round, fmt::format("{}/run-{}.db", folder, round));
    best.steps = static_cast<double>(taken.frames.size());
    best.run_s = std::min(best.run_s, taken.run_s);
    best.exchanges_s = std::min(best.exchanges_s, exchanges_again(round, taken.frames));
    best.store_s =
        std::min(best.store_s, frames_again(taken.frames, round, fmt::format("{}/bare-{}.db", folder, round)));
  }
  return figures_of(best);
}

std::vector<Figure> figures_of(const SequenceTimes& times) {
  const double per_step = 1e6 / times.steps;
  return {{"sequence_steps", times.steps, "1"},
          {"sequence_run", times.run_s * per_step, "us/step"},
          {"sequence_bare_exchanges", times.exchanges_s * per_step, "us/step"},
          {"sequence_bare_store", times.store_s * per_step, "us/step"},
          {"sequence_ratio", times.run_s / (times.exchanges_s + times.store_s), "x"}};
}

}  // namespace tactbench::bench
