#include "bench/benchmarks/sequence.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <optional>

#include "bench/benchmarks/simulated_run.h"
#include "bench/common/process_time.h"
#include "bench/rig/rig.h"

namespace tactbench::bench {

namespace {

RunRequest one_repeat(int round) { return descending_request(1, static_cast<unsigned>(round)); }

struct Taken {
  double run_s = 0.0;
  std::vector<db::FrameRecord> frames;
};

// From the first step to the last, set-up and way out left out.
Taken run_once(int round, const std::string& path) {
  db::RunStore store = db::RunStore::open(path, db::Durability::kNormal);
  RunRequest request = one_repeat(round);
  std::optional<double> first;
  double last = 0.0;
  request.on_step = [&](const sequences::Step&) {
    last = now_s(By::kWall);
    if (!first) first = last;
  };
  const std::int64_t run = carry_out(request, store).run;
  Taken taken{last - first.value(), store.frames(run)};
  taken.frames.pop_back();  // the last step's end is not known
  return taken;
}

double exchanges_again(int round, const std::vector<BareExchange>& exchanges) {
  Rig rig(one_repeat(round).bench);
  rig.open();
  const devices::Nanoseconds begun = rig.clock().now() - devices::Nanoseconds(exchanges.front().time_ns);
  return best_seconds(1, [&] {
    for (const BareExchange& one : exchanges) {
      rig.clock().wait_until(begun + devices::Nanoseconds(one.time_ns));
      switch (one.kind) {
        case BareExchange::Kind::kCommand:
          (void)rig.source().command(devices::Psi(one.psi));
          break;
        case BareExchange::Kind::kPoll:
          rig.source().keep_alive();
          (void)rig.source().feedback();
          (void)rig.reference().read();
          break;
        case BareExchange::Kind::kFrame:
          (void)rig.array().read(one.scans);
          break;
      }
    }
  });
}

double frames_again(std::vector<db::FrameRecord> frames, int round, const std::string& path) {
  db::RunStore store = db::RunStore::open(path, db::Durability::kNormal);
  const RunRequest request = one_repeat(round);
  store.add_sensor(request.sensor);
  db::RunRecord run;
  run.uuid = db::new_uuid();
  run.origin = "simulated";
  run.state = "prepared";
  run.sensor_serial = request.sensor.serial;
  run.sequences = {{0, "descending", "", "", 1, static_cast<int>(frames.size())}};
  const std::int64_t number = store.begin_run(run), branch = store.begin_branch(number, {});
  return best_seconds(1, [&] {
    for (db::FrameRecord& frame : frames) {
      frame.branch = branch;
      store.append_frame(number, frame);
    }
  });
}

}  // namespace

std::vector<Figure> benchmark_sequence(int rounds, const std::string& folder) {
  constexpr double kNone = std::numeric_limits<double>::infinity();
  SequenceTimes best{0.0, kNone, kNone, kNone};
  for (int round = 1; round <= rounds; ++round) {
    const Taken taken = run_once(round, fmt::format("{}/run-{}.db", folder, round));
    best.steps = static_cast<double>(taken.frames.size());
    best.run_s = std::min(best.run_s, taken.run_s);
    best.exchanges_s = std::min(best.exchanges_s, exchanges_again(round, bare_exchanges(taken.frames)));
    best.store_s =
        std::min(best.store_s, frames_again(taken.frames, round, fmt::format("{}/bare-{}.db", folder, round)));
  }
  return figures_of(best);
}

std::vector<BareExchange> bare_exchanges(const std::vector<db::FrameRecord>& frames) {
  using Kind = BareExchange::Kind;
  std::vector<BareExchange> exchanges;
  for (const db::FrameRecord& frame : frames) {
    const std::int64_t command_ns = frame.time_ns - frame.since_command_ns;
    bool commanded = false;
    for (const db::TracePoint& point : frame.trace) {
      const std::int64_t time_ns = frame.time_ns - seconds(static_cast<double>(point.before_frame_s)).count();
      if (!commanded && time_ns > command_ns) {
        exchanges.push_back({Kind::kCommand, command_ns, frame.setpoint_psi, 0});
        commanded = true;
      }
      exchanges.push_back({Kind::kPoll, time_ns, 0.0, 0});
    }
    exchanges.push_back({Kind::kFrame, frame.time_ns, 0.0, frame.scans});
  }
  return exchanges;
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
