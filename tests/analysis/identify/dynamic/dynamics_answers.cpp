// Lag and creep of films by formula: what of a run is looked at, what is found, and what undoing them leaves.
#include <catch2/catch.hpp>
#include <cmath>

#include "analysis/identify/dynamic/dynamic_alone.h"
#include "analysis/identify/dynamic/dynamic_fit.h"
#include "analysis/identify/dynamic/dynamics_search.h"
#include "analysis/identify/dynamic/own_creep.h"
#include "analysis/identify/dynamic/track.h"

using namespace tactbench::analysis;

namespace {

const std::vector<bool> kOneTaxel{true};

Dataset of_taxels(int taxels, std::vector<SequenceData> sequences) {
  Dataset data;
  data.rows = 1;
  data.columns = taxels;
  data.noise_v.assign(static_cast<std::size_t>(taxels), 0.0);
  data.at_limit.assign(static_cast<std::size_t>(taxels), false);
  data.sequences = std::move(sequences);
  return data;
}

// Samples a second apart at these pressures, of one taxel that follows them.
Dataset each_second(const std::vector<double>& psi) {
  Repeat repeat;
  for (std::size_t i = 0; i < psi.size(); ++i) {
    repeat.steps.push_back({psi[i], psi[i], static_cast<double>(i + 1), 1.0});
    repeat.volts.push_back(0.1 * psi[i]);
  }
  return of_taxels(1, {{"s", {repeat}}});
}

int holds_in(const std::vector<double>& psi) {
  ArrayDynamics result;
  result.creep_scale = {1.0};
  find_creep(each_second(psi), {0.0}, kOneTaxel, result);
  return result.holds;
}

// A linear film (psi a volt) whose pressure arrives late by a share, sample by sample.
struct LateFilm {
  double volts_per_psi, share;
};
Dataset loops_at(const std::vector<double>& dwell_s, double lag_s, const std::vector<LateFilm>& films,
                 const std::vector<double>& levels) {
  SequenceData sequence{"rate", {}};
  double late = 0.0, now = 0.0;
  for (const double dwell : dwell_s) {
    Repeat repeat;
    for (const double psi : levels) {
      now += dwell;
      late = psi + (late - psi) * std::exp(-dwell / lag_s);
      repeat.steps.push_back({psi, psi, now, dwell});
      for (const LateFilm& film : films)
        repeat.volts.push_back(0.5 + film.volts_per_psi * (psi + film.share * (late - psi)));
    }
    sequence.repeats.push_back(repeat);
  }
  return of_taxels(static_cast<int>(films.size()), {sequence});
}
const std::vector<double> kUpAndDown{0, 10, 20, 30, 20, 10, 0};

ArrayDynamics lag_of(const Dataset& data, const std::vector<bool>& usable) {
  return find_dynamics(&data, nullptr, std::vector<double>(usable.size(), 0.5), usable);
}

}  // namespace

TEST_CASE("holds that tell of creep: within half a psi of their first sample, above it, ten samples after six seconds",
          "[dynamic]") {
  const auto held = [](std::size_t samples, double psi) { return std::vector<double>(samples, psi); };
  CHECK(holds_in(held(16, 20.0)) == 1);
  CHECK(holds_in(held(15, 20.0)) == 0);
  CHECK(holds_in(held(40, 0.5)) == 0);
  CHECK(holds_in(held(40, 0.51)) == 1);
  std::vector<double> wavering = held(16, 20.0);
  wavering[8] = 20.49;
  wavering[9] = 19.51;
  CHECK(holds_in(wavering) == 1);
  wavering[8] = 20.5;
  CHECK(holds_in(wavering) == 0);
  wavering[8] = 19.5;
  CHECK(holds_in(wavering) == 0);
  std::vector<double> two = held(16, 20.0);
  two.insert(two.end(), 16, 40.0);
  two.insert(two.end(), 15, 20.0);
  CHECK(holds_in(two) == 2);
}

TEST_CASE("lag by formula: time and share of the array, each taxel's own, of a taxel that is not usable the array's",
          "[dynamic]") {
  double lag_s = 0.1;
  for (int i = 0; i < 24; ++i) lag_s *= 1.1;  // 0.985 s, one of those that are tried
  const std::vector<LateFilm> films{{0.1, 0.10}, {0.05, 0.04}, {0.2, 0.3}};
  const ArrayDynamics found = lag_of(loops_at({3.0, 1.0, 40.0}, lag_s, films, kUpAndDown), {true, true, false});
  CHECK(found.rate_samples == 4);  // of seven steps, without the ends and the turn
  CHECK(found.shared.lag_s == Approx(lag_s));
  CHECK(found.shared.lag_share == Approx((0.1 * 0.10 + 0.05 * 0.04) / 0.15));  // weighted by the slopes
  CHECK(found.lag_share[0] == Approx(0.10));
  CHECK(found.lag_share[1] == Approx(0.04));
  CHECK(found.lag_share[2] == found.shared.lag_share);
  CHECK(found.creep_scale == std::vector<double>(3, 1.0));
  // No more than a half can be late.
  const ArrayDynamics half = lag_of(loops_at({1.0, 40.0}, lag_s, {{0.1, 0.6}}, kUpAndDown), kOneTaxel);
  CHECK((half.shared.lag_share == 0.5 && half.lag_share[0] == 0.5));
}

TEST_CASE("lag: one repeat has to last twice as long as another, and sequences of two steps tell nothing",
          "[dynamic]") {
  CHECK(lag_of(loops_at({1.0, 2.01}, 1.0, {{0.1, 0.1}}, kUpAndDown), kOneTaxel).rate_samples == 4);
  CHECK(lag_of(loops_at({1.0, 1.99}, 1.0, {{0.1, 0.1}}, kUpAndDown), kOneTaxel).rate_samples == 0);
  CHECK(lag_of(loops_at({1.0, 9.0}, 1.0, {{0.1, 0.1}}, {0, 10}), kOneTaxel).rate_samples == 0);
  CHECK(lag_of(loops_at({1.0, 9.0}, 1.0, {{0.1, 0.1}}, {0, 10, 20}), kOneTaxel).rate_samples == 1);
  CHECK(lag_of(loops_at({1.0, 9.0}, 1.0, {{0.1, 0.1}}, {0, 10, 10, 20}), kOneTaxel).rate_samples == 0);
  const ArrayDynamics none = lag_of(loops_at({1.0, 1.0}, 1.0, {{0.1, 0.1}}, kUpAndDown), kOneTaxel);
  CHECK((none.shared.lag_share == 0.0 && none.lag_share[0] == 0.0));
}

TEST_CASE("lag by formula: of the second sequence of a run, with creep that is known undone", "[dynamic]") {
  // The first sequence has one pace. Creep of half of the array's, beside a lag of 1.04857 s and 12 %.
  double lag_s = 0.1;
  for (int i = 0; i < 25; ++i) lag_s *= 1.1;
  const std::array<double, 3> share{0.02, 0.01, 0.03}, time_s{3.0, 30.0, 300.0};
  std::array<double, 3> psi{};
  std::vector<SequenceData> sequences{{"loop", {}}, {"rate", {}}};
  double late = 0.0, now = 0.0;
  for (const auto& [sequence, dwell] : {std::pair{0U, 2.0}, std::pair{1U, 1.0}, std::pair{1U, 60.0}}) {
    Repeat repeat;
    for (const double level : kUpAndDown) {
      now += dwell;
      late = level + (late - level) * std::exp(-dwell / lag_s);
      double creep = 0.0;
      for (std::size_t j = 0; j < 3; ++j) {
        const double target = level / (level + 10.0);
        psi[j] = target + (psi[j] - target) * std::exp(-dwell / time_s[j]);
        creep += 0.5 * share[j] * (psi[j] - 1.0);
      }
      repeat.steps.push_back({level, level, now, dwell});
      repeat.volts.push_back(0.5 + 0.1 * (level + 0.12 * (late - level)) * (1.0 + creep));
    }
    sequences[sequence].repeats.push_back(repeat);
  }
  ArrayDynamics known;
  known.shared.creep_share = share;
  known.creep_scale = {0.5};
  known.lag_share = {0.0};
  find_lag(of_taxels(1, sequences), {0.5}, kOneTaxel, known);
  CHECK(known.rate_samples == 4);
  CHECK(known.shared.lag_s == Approx(lag_s));
  CHECK(known.shared.lag_share == Approx(0.12).epsilon(1e-4));
}

TEST_CASE("creep by formula: shares, half and scales of two taxels are found again from holds", "[dynamic]") {
  // Two films of twice and half of the array's creep; holds of 200 samples of 2 s at 10, 30 and 60 psi.
  double half = 1.0;
  for (int i = 0; i < 10; ++i) half *= 1.2;  // 6.19 psi, one of those that are tried
  const std::array<double, 3> share{0.012, 0.010, 0.008}, time_s{3.0, 30.0, 300.0};
  std::array<double, 3> psi{};
  Repeat repeat;
  double now = 0.0;
  for (const double level : {10.0, 30.0, 60.0})
    for (int i = 1; i <= 200; ++i) {
      now += 2.0;
      const double target = level / (level + half);
      double creep = 0.0;
      for (std::size_t j = 0; j < 3; ++j) {
        psi[j] = target + (psi[j] - target) * std::exp(-2.0 / time_s[j]);
        creep += share[j] * (psi[j] - 1.0);
      }
      repeat.steps.push_back({level, level, now, 2.0 * i});
      for (const double scale : {1.2, 0.8}) repeat.volts.push_back(0.5 + 0.1 * level * (1.0 + scale * creep));
    }
  const ArrayDynamics found = find_dynamics(nullptr, nullptr, {0.5, 0.5}, {true, true});
  CHECK(found.holds == 0);
  const Dataset data = of_taxels(2, {{"creep-levels", {repeat}}});
  const ArrayDynamics creep = find_dynamics(nullptr, &data, {0.5, 0.5}, {true, true});
  CHECK(creep.holds == 3);
  CHECK(creep.shared.creep_half == Approx(half).epsilon(0.25));
  double sum = 0.0;
  for (const double own : creep.shared.creep_share) sum += own;
  CHECK(sum == Approx(0.03).epsilon(0.02));
  for (std::size_t j = 0; j < 3; ++j) CHECK(creep.shared.creep_share[j] == Approx(share[j]).epsilon(0.1));
  CHECK(creep.creep_scale[0] == Approx(1.2).epsilon(0.01));
  CHECK(creep.creep_scale[1] == Approx(0.8).epsilon(0.01));
  // The scales alone, of creep that is known: the same. A taxel that is not usable keeps the array's.
  ArrayDynamics known;
  known.shared.creep_share = share;
  known.shared.creep_half = half;
  known.creep_scale = {1.0, 1.0};
  known.lag_share = {0.0, 0.0};
  find_creep_scales(data, {0.5, 0.5}, {true, false}, known);
  CHECK(known.creep_scale[0] == Approx(1.2).epsilon(0.01));
  CHECK(known.creep_scale[1] == 1.0);
}

TEST_CASE("lag and creep undone by formula: each taxel's own creep, the array's lag, conditioning in between",
          "[dynamic]") {
  ArrayDynamics dynamics;
  dynamics.shared.creep_share = {0.1, 0.05, 0.0};
  dynamics.shared.creep_half = 10.0;
  dynamics.shared.lag_s = 2.0;
  dynamics.shared.lag_share = 0.2;
  dynamics.creep_scale = {1.0, 0.5};
  dynamics.lag_share = {0.2, 0.2};
  // 30 psi at 2 s, held for 2 s; at 5 s, 5 s of it; then 10 psi at 25 s, held for 4 s: 16 s of conditioning before it.
  Repeat repeat;
  repeat.steps = {{30, 30, 2, 2}, {30, 30, 5, 5}, {10, 10, 25, 4}};
  repeat.volts = {1.5, 2.5, 1.6, 2.6, 0.9, 1.9};
  const Dataset undone = lag_and_creep_undone(of_taxels(2, {{"s", {repeat}}}), dynamics, {0.5, 0.25}, 40.0);
  const std::vector<double>& volts = undone.sequences[0].repeats[0].volts;
  const std::vector<Sample>& steps = undone.sequences[0].repeats[0].steps;
  double fast = 0.0, slow = 0.0, late = 0.0;
  const auto check_at = [&](std::size_t i, double seconds, double target) {
    fast = target + (fast - target) * std::exp(-seconds / 3.0);
    slow = target + (slow - target) * std::exp(-seconds / 30.0);
    const double creep = 0.1 * (fast - 1.0) + 0.05 * (slow - 1.0);
    const double first = repeat.volts[2 * i] - 0.5, second = repeat.volts[2 * i + 1] - 0.25;
    CHECK(volts[2 * i] == Approx(0.5 + first / (1.0 + creep)));
    CHECK(volts[2 * i + 1] == Approx(0.25 + second / (1.0 + 0.5 * creep)));
    const double psi = repeat.steps[i].reference_psi, left = std::exp(-seconds / 2.0);
    CHECK(steps[i].reference_psi == Approx(psi + 0.2 * left * (late - psi)));
    late = psi + (late - psi) * left;
  };
  check_at(0, 2.0, 0.75);
  check_at(1, 3.0, 0.75);
  // 20 s passed of which 4 s were commanded: 16 s to and fro over 40 psi, the mean of p / (p + 10), and rest at 0.
  const double working = 1.0 - 10.0 / 40.0 * std::log(5.0);
  fast = working + (fast - working) * std::exp(-16.0 / 3.0);
  slow = working + (slow - working) * std::exp(-16.0 / 30.0);
  late = 0.0;
  check_at(2, 4.0, 0.5);
}

TEST_CASE("a track of a run: its samples in their order, the largest set-point its span, and creep along it",
          "[dynamic]") {
  Repeat first, second;
  first.steps = {{10, 11, 1, 1}, {20, 19, 3, 1}};
  second.steps = {{5, 5, 4, 1}};
  first.volts = {1, 2, 3, 4};
  second.volts = {5, 6};
  const Dataset data = of_taxels(2, {{"a", {first}}, {"b", {second}}});
  const Track track = track_of(data);
  CHECK(track.time == std::vector<double>{1, 3, 4});
  CHECK(track.pressure == std::vector<double>{11, 19, 5});
  CHECK(track.span == 20.0);
  CHECK(track.sequence == std::vector<std::size_t>{0, 0, 1});
  CHECK(track.step == std::vector<std::size_t>{0, 1, 0});
  CHECK((track.volts[1][0] == 3.0 && track.volts[2][1] == 6.0));
  Dynamics d;
  const auto psi = walk_creep(track, d);
  const double once = 11.0 / 21.0 * -std::expm1(-1.0 / 3.0);
  CHECK(psi[0][0] == Approx(once));
  CHECK(psi[1][0] == Approx(19.0 / 29.0 + (once - 19.0 / 29.0) * std::exp(-2.0 / 3.0)));
}

TEST_CASE("creep of one run: times evenly spaced over the logarithm, the slowest within half of the run", "[dynamic]") {
  CHECK(creep_times(300.0)[0] == Approx(3.0));
  CHECK(creep_times(300.0)[1] == Approx(30.0));
  CHECK(creep_times(300.0)[2] == Approx(300.0));
  CHECK(creep_times(10000.0)[1] == Approx(std::sqrt(30000.0)));
  const auto slowest = [](double last_s) {
    Dataset data = each_second({0, 10, 20, 10, 0});
    data.sequences[0].repeats[0].steps.back().time_s = last_s;
    return CreepMisfit(data, {0.0}, kOneTaxel, 20.0, {}).slowest_s();
  };
  CHECK(slowest(599.0).empty());
  CHECK(slowest(600.0) == std::vector<double>{300.0});
  CHECK(slowest(2000.0) == std::vector<double>{300.0, 1000.0});
  CHECK(slowest(30000.0) == std::vector<double>{300.0, 1000.0, 3000.0, 10000.0});
}

TEST_CASE("what of lag and creep a dynamic model undoes", "[dynamic]") {
  const auto with = [](std::array<double, 3> creep, double lag) {
    SensorDynamics dynamics;
    dynamics.shared.creep_share = creep;
    dynamics.shared.lag_share = lag;
    return std::string(undoes_creep(dynamics) ? "c" : "-") + (undoes_lag(dynamics) ? "l" : "-") +
           (in_time(dynamics) ? "t" : "-") + (creep_of_fitted_run(dynamics) ? "o" : "-");
  };
  CHECK(with({0, 0, 0}, 0) == "----");
  CHECK(with({0, 0, 0}, 0.1) == "-lt-");
  CHECK(with({0, 0, 0.1}, 0) == "c-t-");
  CHECK(with({0.1, 0.1, 0.1}, 0) == "c-to");
  CHECK(with({0.1, 0.1, 0.2}, 0.1) == "clt-");
}
