#include "tests/benchmarks/study/histories.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "bench/simulation/plant.h"
#include "devices/clock.h"

namespace tactbench::bench {

namespace {

using sequences::RandomKind;
using enum sequences::RandomKind;

constexpr double kPsiPerS = 20.0;  // where nothing else is said
constexpr double kDense = 76.0;    // scans a second of the shipped scanner

// As a recipe goes: a scan at each level between the points, `dwell_s` after its arrival.
Legs levels(const std::vector<double>& points, double move_s = 0.4, double dwell_s = 2.0) {
  constexpr double kStep = 2.0;
  Legs legs;
  for (std::size_t i = 1; i < points.size(); ++i) {
    const double way = points[i] - points[i - 1];
    const int count = static_cast<int>(std::lround(std::abs(way) / kStep));
    for (int k = 1; k <= count; ++k) {
      legs.push_back({points[i - 1] + way * k / count, move_s, 0});
      legs.push_back({legs.back().psi, dwell_s, 1});
    }
  }
  return legs;
}

Leg timed(double psi, double seconds, double per_second) {
  return {psi, seconds, std::max(1, static_cast<int>(std::lround(seconds * per_second)))};
}

// Without stops.
void pass(Legs& legs, const std::vector<double>& points, double psi_per_s, double per_second) {
  for (const double point : points)
    if (const double way = std::abs(point - (legs.empty() ? 0.0 : legs.back().psi)); way > 0.0)
      legs.push_back(timed(point, way / psi_per_s, per_second));
}

// Triangles of about 1 Hz about the pressure that was held.
void tremble(Legs& legs, Draw& draw, double size, double seconds, double per_second) {
  const double held = legs.back().psi;
  double side = 1.0;
  for (double passed = 0.0; passed < seconds; side = -side) {
    const double half = draw.between(0.3, 0.7);
    legs.push_back(timed(held + side * size * draw.between(0.8, 1.0), half, per_second));
    passed += half;
  }
}

Legs reversals(Draw& draw, double low, double high, int count) {
  return levels(draw.points(kReversals, 2.0, low, high, count));
}

Legs all_over(Draw& draw) { return reversals(draw, 0.0, 60.0, 31); }

// Twice: up, held for a minute, released.
Legs press(Draw& draw, double highest) {
  Legs legs;
  for (int i = 0; i < 2; ++i) {
    const double height = draw.between(highest - 3.0, highest);
    legs.insert(legs.end(),
                {{height, height / kPsiPerS, 0}, {height, 60.0, 60}, {0.0, height / kPsiPerS, 0}, {0.0, 20.0, 20}});
  }
  return legs;
}

Legs tremor(Draw& draw, double size) {
  Legs legs;
  pass(legs, {draw.between(25.0, 45.0)}, kPsiPerS, 10.0);
  tremble(legs, draw, size, 120.0, 10.0);
  return legs;
}

Legs walk(Draw& draw, double low, double high, double most, double psi_per_s) {
  Legs legs;
  pass(legs, draw.points(kWander, 0.5, low, high, 301, most), psi_per_s, 10.0);
  return legs;
}

Legs grasps(Draw& draw) {
  Legs legs;
  for (int i = 0; i < 8; ++i) {
    legs.push_back(timed(draw.between(8.0, 55.0), draw.between(0.5, 2.0), 20.0));
    tremble(legs, draw, 0.2, draw.between(5.0, 10.0), 20.0);
    legs.push_back(timed(0.0, draw.between(0.3, 1.0), 20.0));
    legs.push_back(timed(0.0, draw.between(2.0, 5.0), 20.0));
  }
  return legs;
}

Legs sine(Draw& draw, double hertz, double seconds, double per_second) {
  const double middle = draw.between(25.0, 35.0), size = draw.between(5.0, hertz > 1.0 ? 12.0 : 24.0);
  Legs legs;
  pass(legs, {middle}, kPsiPerS, per_second);
  for (int i = 1; i <= std::lround(seconds * per_second); ++i)
    legs.push_back({middle + size * std::sin(2.0 * std::numbers::pi * hertz * i / per_second), 1.0 / per_second, 1});
  return legs;
}

Legs dense_holds(Draw& draw) {
  Legs legs;
  for (int i = 0; i < 4; ++i) {
    const double height = draw.between(5.0, 60.0);
    pass(legs, {height}, kPsiPerS, kDense);
    legs.push_back(timed(height, 6.0, kDense));
    pass(legs, {0.0}, kPsiPerS, kDense);
    legs.push_back(timed(0.0, 2.0, kDense));
  }
  return legs;
}

// A regulator that follows within 20 ms, without rate limit, steps or hysteresis.
PlantOptions well_regulated(PlantOptions options, std::uint64_t seed) {
  options.seed = seed;
  options.chamber.time_constant_s = 0.01;
  options.chamber.damping = 1.0;
  options.chamber.slew_psi_per_s = 1e6;
  options.chamber.resolution_v = options.chamber.hysteresis_share = options.chamber.leak_psi_per_s = 0.0;
  return options;
}

class Player {
 public:
  Player(const PlantOptions& options, std::uint64_t seed)
      : options_(well_regulated(options, seed)),
        plant_(options_, clock_),
        counts_(static_cast<std::size_t>(options_.specimen.rows) * static_cast<std::size_t>(options_.specimen.columns)),
        status_(static_cast<std::size_t>(options_.specimen.rows)) {}

  // Calls take(seconds, psi, counts) at each scan: seconds since the scan before, or since the start.
  template <class Take>
  void go(const Leg& leg, Take take) {
    constexpr double kPiece = 0.01;  // a cell of the plant's grid
    const double from = psi_, begun = time_s_;
    const int parts = std::max(1, leg.scans);
    const int pieces = leg.psi == from ? 1 : static_cast<int>(std::ceil(leg.seconds / parts / kPiece));
    for (int k = 1; k <= parts * pieces; ++k) {
      const double share = static_cast<double>(k) / (parts * pieces);
      psi_ = from + (leg.psi - from) * share;
      plant_.drive(devices::Volts(psi_ / options_.chamber.span_psi * 10.0), devices::Nanoseconds::max(),
                   devices::Volts(0.0));
      time_s_ = begun + leg.seconds * share;
      clock_.wait_until(devices::Nanoseconds(std::llround(time_s_ * 1e9)));
      if (leg.scans == 0 || k % pieces != 0) continue;
      plant_.scan(counts_, status_);
      take(time_s_ - scanned_s_, plant_.true_pressure().value(), counts_);
      scanned_s_ = time_s_;
    }
  }
  void from_here() { scanned_s_ = time_s_; }
  [[nodiscard]] double time_s() const { return time_s_; }

 private:
  PlantOptions options_;
  devices::ManualClock clock_;
  Plant plant_;
  std::vector<std::uint16_t> counts_;
  std::vector<std::uint8_t> status_;
  double psi_ = 0.0, time_s_ = 0.0, scanned_s_ = 0.0;
};

}  // namespace

std::vector<double> Draw::points(RandomKind kind, double step, double low, double high, int count, double most) {
  const auto steps = [step](double psi) { return std::lround(psi / step); };
  std::vector<double> points;
  for (const long point : sequences::draw_points({kind, generator_(), count, steps(low), steps(high), 1, steps(most)}))
    points.push_back(static_cast<double>(point) * step);
  return points;
}

const std::vector<HistoryKind>& history_kinds() {
  static const std::vector<std::string> kRemounted = {"simulation.mount_seed=1",
                                                      "simulation.effects.remount_variation=0.03"};
  static const std::vector<std::string> kMonth = {"simulation.temperature_c=28", "simulation.age_months=1",
                                                  "simulation.effects.gain_drift_per_month=0.01",
                                                  "simulation.effects.zero_drift_v_per_month=0.01"};
  static const std::vector<HistoryKind> kinds = {
      {"reversals over the range", all_over},
      {"small reversals that wander",
       [](Draw& draw) {
         std::vector<double> points = draw.points(kWander, 2.0, 4.0, 56.0, 81);
         points.insert(points.begin(), {0.0, 60.0});
         return levels(points);
       }},
      {"reversals, 0 to 20 psi", [](Draw& draw) { return reversals(draw, 0.0, 20.0, 61); }},
      {"reversals, 20 to 40 psi", [](Draw& draw) { return reversals(draw, 20.0, 40.0, 61); }},
      {"reversals, 40 to 60 psi", [](Draw& draw) { return reversals(draw, 40.0, 60.0, 61); }},
      {"reversals to 54 psi", [](Draw& draw) { return reversals(draw, 0.0, 54.0, 31); }},
      {"small, never above 45 psi",
       [](Draw& draw) { return levels(draw.points(kWander, 2.0, 4.0, 44.0, 81)); },
       {},
       false,
       45.0},
      {"press and hold, 20 psi", [](Draw& draw) { return press(draw, 20.0); }},
      {"press and hold, 30 psi", [](Draw& draw) { return press(draw, 30.0); }},
      {"press and hold, 40 psi", [](Draw& draw) { return press(draw, 40.0); }},
      {"press and hold, 50 psi", [](Draw& draw) { return press(draw, 50.0); }},
      {"press and hold, 60 psi", [](Draw& draw) { return press(draw, 60.0); }},
      {"tremor of 0.2 psi", [](Draw& draw) { return tremor(draw, 0.2); }},
      {"tremor of 0.5 psi", [](Draw& draw) { return tremor(draw, 0.5); }},
      {"tremor of 1 psi", [](Draw& draw) { return tremor(draw, 1.0); }},
      {"walk, reversals to 5 psi", [](Draw& draw) { return walk(draw, 4.0, 56.0, 5.0, 10.0); }},
      {"hover, 30 +- 3 psi", [](Draw& draw) { return walk(draw, 27.0, 33.0, 3.0, 5.0); }},
      {"steps of 0.2 s", [](Draw& draw) { return levels(draw.points(kReversals, 2.0, 0.0, 60.0, 31), 0.1, 0.1); }},
      {"grasps", grasps},
      {"sine of 0.05 Hz", [](Draw& draw) { return sine(draw, 0.05, 100.0, 5.0); }},
      {"sine of 0.3 Hz", [](Draw& draw) { return sine(draw, 0.3, 40.0, 20.0); }},
      {"sine of 2 Hz", [](Draw& draw) { return sine(draw, 2.0, 15.0, kDense); }},
      {"dense reversals",
       [](Draw& draw) {
         Legs legs;
         pass(legs, draw.points(kReversals, 0.5, 0.0, 60.0, 13), 10.0, kDense);
         return legs;
       }},
      {"dense presses", dense_holds},
      {"unknown start", all_over, {}, true},
      {"re-mounted", all_over, kRemounted},
      {"a month later, +5 degrees", all_over, kMonth},
  };
  return kinds;
}

Recording record(const HistoryKind& kind, PlantOptions plant, std::uint64_t seed, std::span<const std::size_t> taxels) {
  Draw draw(seed);
  Player player(plant, seed);
  const auto nothing = [](double, double, const std::vector<std::uint16_t>&) {};
  const double top = kind.conditioned_psi;
  for (int cycle = 0; cycle < (top < 60.0 ? 8 : 3); ++cycle)
    for (const double psi : {top, 0.0}) {
      player.go({psi, top / kPsiPerS, 0}, nothing);
      player.go({psi, 2.0, 0}, nothing);
    }
  Recording made;
  made.worked_s = player.time_s();
  player.from_here();
  const auto take = [&](double seconds, double psi, const std::vector<std::uint16_t>& counts) {
    made.seconds.push_back(seconds);
    made.psi.push_back(psi);
    for (const std::size_t taxel : taxels) made.volts.push_back(counts[taxel] * plant.scanner.volts_per_count);
  };
  player.go({0.0, 20.0, 1}, take);
  for (const Leg& leg : kind.legs(draw)) player.go(leg, take);
  if (!kind.unknown_start) return made;
  auto first = static_cast<std::size_t>(draw.between(0.25, 0.5) * static_cast<double>(made.psi.size()));
  while (made.psi[first] < 5.0) ++first;  // loaded
  const auto cut = [first](std::vector<double>& values, std::size_t of_each) {
    values.erase(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(first * of_each));
  };
  cut(made.seconds, 1);
  cut(made.psi, 1);
  cut(made.volts, taxels.size());
  made.worked_s = made.seconds.front() = 0.0;
  return made;
}

}  // namespace tactbench::bench
