#include "tests/benchmarks/speed/synthetic_array.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "analysis/loop.h"
#include "bench/common/utc.h"

namespace tactbench::speed {

namespace {

using namespace analysis;

constexpr double kVoltsPerCount = 5.0 / 65536.0, kFull = 60.0, kStep = 2.0, kNoise = 0.004, kReferenceNoise = 0.03;
constexpr double kPlay = 6.0, kPlayShare = 0.015;  // psi, of full scale
constexpr int kKnots = 31;

// Table 1.
const std::vector<double> descending_turns{0, 60, 0, 50, 0, 40, 0, 30, 0, 20, 0, 10, 0};
const std::vector<double> ascending_turns{0, 60, 10, 60, 0, 60, 20, 60, 0, 60, 30, 60, 0, 60, 40, 60, 0, 60, 50, 60, 0};

std::vector<double> levels_of(const std::vector<double>& turns) {
  std::vector<double> levels{turns.front()};
  for (std::size_t i = 1; i < turns.size(); ++i) {
    const double way = turns[i] - turns[i - 1];
    const auto count = std::lround(std::abs(way) / kStep);
    for (long k = 1; k <= count; ++k)
      levels.push_back(turns[i - 1] + way * static_cast<double>(k) / static_cast<double>(count));
  }
  return levels;
}

// All taxels along one pressure.
class Walk {
 public:
  explicit Walk(const std::vector<ElamModel>& models) : models_(&models) {
    for (const ElamModel& model : models) curves_.emplace_back(model, true, model.x0(), model.y0());
  }
  void go(double x, std::vector<double>& volts) {
    const bool up = x > x_;
    play_ = std::clamp(play_, x - kPlay, x);
    const double bulge = kPlayShare * (x - play_) / kPlay * std::sin(3.1415927 * x / kFull);
    for (std::size_t t = 0; t < curves_.size(); ++t) {
      const ElamModel& model = (*models_)[t];
      if (x != x_ && up != curves_[t].ascending()) curves_[t] = ElamCurve(model, up, x_, curves_[t].output(x_));
      volts.push_back(curves_[t].output(x) - bulge * model.yu());
    }
    x_ = x;
  }

 private:
  const std::vector<ElamModel>* models_;
  std::vector<ElamCurve> curves_;
  double x_ = 0.0, play_ = 0.0;
};

}  // namespace

ElamModel taxel_like_the_paper(std::mt19937& random) {
  std::uniform_real_distribution<double> spread(-1.0, 1.0);
  const double full = 3.4 * (1.0 + 0.2 * spread(random)), bend = 1.35 + 0.1 * spread(random);
  const double gap = 0.22 + 0.03 * spread(random), fall = 0.015 + 0.005 * spread(random);
  std::vector<double> x, up, down;
  for (int i = 0; i < kKnots; ++i) {
    const double share = i / (kKnots - 1.0), rise = std::pow(std::sin(1.5707963 * std::pow(share, 0.8)), bend);
    x.push_back(kFull * share);
    up.push_back(full * rise);
    down.push_back(full * std::min(rise + gap * std::sin(3.1415927 * share) * (1.0 - share) + gap * share * (1 - rise),
                                   1.0 - fall * std::pow((1.0 - share) * 6.0, 1.3)));
  }
  down.front() = up.front();
  down.back() = up.back();
  const double start = 0.60 + 0.05 * spread(random), end = 0.17 + 0.03 * spread(random);
  return {PatternCurve(x, up, up.front(), up.back()),
          PatternCurve(x, down, up.front(), up.back()),
          {0.78 + 0.05 * spread(random), 0.975 + 0.01 * spread(random), (end - start) / kFull, start,
           0.338 + 0.04 * spread(random)},
          {}};
}

Dataset synthetic_dataset(int rows, int columns, int repeats) {
  Dataset dataset;
  dataset.run = 1;
  dataset.origin = "simulated";
  dataset.sensor_serial = "B-1";
  dataset.scanner_serial = "SIM-SCANNER-1";
  dataset.rows = rows;
  dataset.columns = columns;
  const auto width = static_cast<std::size_t>(dataset.taxels());
  dataset.noise_v.assign(width, kNoise);
  dataset.at_limit.assign(width, false);
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  std::vector<ElamModel> models;
  for (std::size_t t = 0; t < width; ++t) models.push_back(taxel_like_the_paper(random));
  Walk walk(models);
  double time = 0.0;
  for (const auto& [name, turns] : {std::pair{"descending", descending_turns}, {"ascending", ascending_turns}}) {
    SequenceData sequence{name, {}};
    const std::vector<double> levels = levels_of(turns);
    for (int r = 0; r < repeats; ++r) {
      Repeat repeat;
      repeat.volts.reserve(levels.size() * width);
      for (const double level : levels) {
        const double x = std::clamp(level + kReferenceNoise * normal(random), 0.0, kFull);
        repeat.steps.push_back({level, x, time += 2.0, 2.0});
        walk.go(level == 0.0 || level == kFull ? level : x, repeat.volts);
      }
      for (double& volts : repeat.volts) volts += kNoise * normal(random);
      sequence.repeats.push_back(std::move(repeat));
    }
    dataset.sequences.push_back(std::move(sequence));
  }
  return dataset;
}

namespace {

db::FrameRecord frame_of(const Dataset& dataset, const Sample& step, const double* volts) {
  db::FrameRecord frame;
  frame.setpoint_psi = frame.feedback_psi = step.setpoint_psi;
  frame.reference_psi = step.reference_psi;
  frame.time_ns = std::llround(1e9 * step.time_s);
  frame.since_command_ns = std::llround(1e9 * step.held_s);
  frame.rows = dataset.rows;
  frame.columns = dataset.columns;
  frame.scans = 1;
  for (int t = 0; t < dataset.taxels(); ++t)
    frame.counts.push_back(static_cast<std::uint16_t>(std::clamp(std::lround(volts[t] / kVoltsPerCount), 0L, 65534L)));
  return frame;
}

}  // namespace

std::int64_t store_run(db::RunStore& store, const Dataset& dataset) {
  store.add_sensor(
      {dataset.sensor_serial, "synthetic", "", db::sha256_hex(""), dataset.scanner_serial, "", bench::utc_now()});
  db::RunRecord run;
  run.uuid = db::new_uuid();
  run.origin = dataset.origin;
  run.state = "prepared";
  run.sensor_serial = dataset.sensor_serial;
  run.scanner_serial = dataset.scanner_serial;
  run.started_utc = bench::utc_now();
  for (const SequenceData& sequence : dataset.sequences)
    run.sequences.push_back({static_cast<int>(run.sequences.size()), sequence.name, "", "",
                             static_cast<int>(sequence.repeats.size()),
                             static_cast<int>(sequence.repeats.front().steps.size())});
  run.devices = {{"tactile scanner", "synthetic", dataset.scanner_serial, "", dataset.origin,
                  fmt::format("{{\"volts_per_count\": {}}}", kVoltsPerCount)}};
  const std::int64_t number = store.begin_run(run);
  const auto width = static_cast<std::size_t>(dataset.taxels());
  for (std::size_t s = 0; s < dataset.sequences.size(); ++s) {
    const std::vector<Repeat>& repeats = dataset.sequences[s].repeats;
    for (std::size_t r = 0; r < repeats.size(); ++r) {
      db::BranchRecord branch;
      branch.sequence = static_cast<int>(s);
      branch.repeat = static_cast<int>(r);
      const std::int64_t row = store.begin_branch(number, branch);
      for (std::size_t i = 0; i < repeats[r].steps.size(); ++i) {
        db::FrameRecord frame = frame_of(dataset, repeats[r].steps[i], &repeats[r].volts[i * width]);
        frame.branch = row;
        frame.ordinal = static_cast<int>(i);
        store.append_frame(number, frame);
      }
    }
  }
  store.end_run(number, db::Outcome::kCompleted, "", db::SafeState::kVerified, bench::utc_now());
  return number;
}

}  // namespace tactbench::speed
