// What the benchmarks measure on: known taxels (computed in Python from the same seeds), levels of Table 1, noise and
// play as stated in bench/benchmarks/synthetic_array.h. And how figures are named and rounds are taken.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <string>

#include "analysis/dataset.h"
#include "analysis/models/elam.h"
#include "bench/benchmarks/compensate.h"
#include "bench/benchmarks/figure.h"
#include "bench/benchmarks/identify.h"
#include "bench/benchmarks/synthetic_array.h"
#include "db/run_store.h"
#include "tests/support/process.h"

using namespace tactbench;
using namespace tactbench::bench;
using analysis::ElamCurve;
using analysis::ElamModel;

namespace {

constexpr double kVolt = 65536.0 / 5.0;  // counts
constexpr double kNoise = 0.004;

void check_knots(std::span<const double> curve, const std::vector<std::pair<std::size_t, double>>& expected) {
  REQUIRE(curve.size() == 31);
  for (const auto& [knot, volts] : expected) {
    INFO("knot " << knot);
    CHECK(curve[knot] == Approx(volts).epsilon(1e-11).margin(1e-15));
  }
}

// Mean and spread of what is drawn around 0.
struct Spread {
  double sum = 0.0, squares = 0.0, largest = 0.0;
  int count = 0;
  void add(double value) {
    sum += value;
    squares += value * value;
    largest = std::max(largest, std::abs(value));
    ++count;
  }
  [[nodiscard]] double deviation() const { return std::sqrt(squares / count); }
  [[nodiscard]] double mean() const { return sum / count; }
};

}  // namespace

TEST_CASE("benchmarks' taxels: patterns and parameters of seed 5") {
  std::mt19937 random(5);
  const ElamModel first = taxel_like_the_paper(random), second = taxel_like_the_paper(random);
  check_knots(first.ascending.y(), {{0, 0.0},
                                    {1, 0.112060852119},
                                    {10, 1.37820165176},
                                    {20, 2.43344342847},
                                    {29, 2.79154980352},
                                    {30, 2.79504496429}});
  check_knots(first.descending.y(), {{0, 0.0},
                                     {1, 0.19082892254},
                                     {10, 1.8200671906},
                                     {20, 2.65541988054},
                                     {29, 2.78821731457},
                                     {30, 2.79504496429}});
  check_knots(second.ascending.y(), {{1, 0.166311401017}, {20, 3.33700846382}, {30, 3.81926309355}});
  check_knots(second.descending.y(), {{1, 0.287732248252}, {20, 3.67759124016}, {29, 3.81340671567}});
  CHECK(first.parameters.alpha_d == Approx(0.765413804296));
  CHECK(first.parameters.beta_d == Approx(0.97473275997));
  CHECK(first.parameters.alpha_a1 == Approx(-0.00658629845041));
  CHECK(first.parameters.alpha_a0 == Approx(0.558982103422));
  CHECK(first.parameters.beta_a == Approx(0.377265674582));
  CHECK(second.parameters.alpha_a1 == Approx(-0.00799638690374));
  CHECK(second.parameters.beta_a == Approx(0.368232245797));
  for (std::size_t i = 0; i < 31; ++i) CHECK(first.ascending.x()[i] == Approx(2.0 * static_cast<double>(i)));
}

TEST_CASE("benchmarks' levels: both sequences of Table 1 in steps of 2 psi") {
  const auto levels = table_1_levels();
  REQUIRE(levels.size() == 2);
  REQUIRE(levels[0].size() == 211);
  REQUIRE(levels[1].size() == 451);
  for (const auto& sequence : levels) {
    CHECK(sequence.front() == 0.0);
    CHECK(sequence.back() == 0.0);
    for (std::size_t i = 1; i < sequence.size(); ++i)
      CHECK(std::abs(sequence[i] - sequence[i - 1]) == Approx(2.0).epsilon(1e-12));
  }
  const auto turns = [](const std::vector<double>& sequence) {
    std::vector<double> found;
    for (std::size_t i = 1; i + 1 < sequence.size(); ++i)
      if ((sequence[i] - sequence[i - 1]) * (sequence[i + 1] - sequence[i]) < 0.0) found.push_back(sequence[i]);
    return found;
  };
  CHECK(turns(levels[0]) == std::vector<double>{60, 0, 50, 0, 40, 0, 30, 0, 20, 0, 10});
  CHECK(turns(levels[1]) ==
        std::vector<double>{60, 10, 60, 0, 60, 20, 60, 0, 60, 30, 60, 0, 60, 40, 60, 0, 60, 50, 60});
}

TEST_CASE("benchmarks' run: levels, times, noise of the reference, and a play that no ELAM follows") {
  const analysis::Dataset dataset = synthetic_dataset(2, 3, 2);
  CHECK(dataset.taxels() == 6);
  CHECK((dataset.rows == 2 && dataset.columns == 3 && dataset.run == 1));
  CHECK(dataset.origin == "simulated");
  CHECK(dataset.at_limit == std::vector<bool>(6, false));
  REQUIRE(dataset.sequences.size() == 2);
  CHECK(dataset.sequences[0].name == "descending");
  CHECK(dataset.sequences[1].name == "ascending");
  CHECK(dataset.noise_v == std::vector<double>(6, kNoise));
  const auto levels = table_1_levels();
  double time = 0.0;
  Spread reference;
  for (std::size_t s = 0; s < 2; ++s) {
    REQUIRE(dataset.sequences[s].repeats.size() == 2);
    for (const analysis::Repeat& repeat : dataset.sequences[s].repeats) {
      REQUIRE(repeat.steps.size() == levels[s].size());
      REQUIRE(repeat.volts.size() == 6 * levels[s].size());
      for (std::size_t i = 0; i < levels[s].size(); ++i) {
        const analysis::Sample& step = repeat.steps[i];
        CHECK(step.setpoint_psi == levels[s][i]);
        CHECK(step.time_s == (time += 2.0));
        CHECK(step.held_s == 2.0);
        CHECK((step.reference_psi >= 0.0 && step.reference_psi <= 60.0));
        if (levels[s][i] > 1.0 && levels[s][i] < 59.0) reference.add(step.reference_psi - levels[s][i]);
      }
    }
  }
  CHECK(reference.deviation() == Approx(0.03).epsilon(0.08));
  CHECK(std::abs(reference.mean()) < 0.004);
  // The first two branches are external: up behind a full play, down with none below 54 psi.
  std::mt19937 random(5);
  Spread noise;
  for (std::size_t t = 0; t < 6; ++t) {
    const ElamModel model = taxel_like_the_paper(random);
    const ElamCurve up(model, true, model.x0(), model.y0()), down(model, false, model.xu(), model.yu());
    const analysis::Repeat& repeat = dataset.sequences[0].repeats[0];
    for (std::size_t i = 1; i < 60; ++i) {
      const double x = i == 30 ? 60.0 : repeat.steps[i].reference_psi;
      const double behind = i <= 30 ? std::min(x, 6.0) : std::max(0.0, x - 54.0);
      const double bulge = 0.015 * behind / 6.0 * std::sin(3.14159265358979 * x / 60.0) * model.yu();
      const double volts = (i <= 30 ? up : down).output(x) - bulge;
      noise.add(repeat.volts[6 * i + t] - volts);
    }
  }
  CHECK(noise.deviation() == Approx(kNoise).epsilon(0.1));
  CHECK(noise.largest < 5.0 * kNoise);
}

TEST_CASE("benchmarks' run in a store: the same volts to half a count, completed") {
  const analysis::Dataset made = synthetic_dataset(2, 3, 2);
  const tests::TemporaryFolder folder;
  db::RunStore store = db::RunStore::open(folder.path("b.db"), db::Durability::kNormal);
  const std::int64_t number = store_run(store, made);
  const db::RunRecord run = store.run(number);
  CHECK(run.outcome == db::Outcome::kCompleted);
  CHECK(run.safe_state == db::SafeState::kVerified);
  REQUIRE(run.sequences.size() == 2);
  CHECK((run.sequences[0].sequence == 0 && run.sequences[0].repeats == 2 && run.sequences[0].frames_per_repeat == 211));
  CHECK((run.sequences[1].sequence == 1 && run.sequences[1].repeats == 2 && run.sequences[1].frames_per_repeat == 451));
  const std::vector<db::FrameRecord> frames = store.frames(number);
  REQUIRE(frames.size() == 2 * (211 + 451));
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const std::size_t of_first = 2 * 211, at = i < of_first ? i % 211 : (i - of_first) % 451;
    CHECK(frames[i].ordinal == static_cast<int>(at));
    CHECK(frames[i].feedback_psi == frames[i].setpoint_psi);
    CHECK(frames[i].scans == 1);
  }
  const analysis::Dataset read = analysis::load_dataset(store, number);
  CHECK(read.sensor_serial == "B-1");
  CHECK(read.scanner_serial == "SIM-SCANNER-1");
  CHECK(read.rows == 2);
  CHECK(read.columns == 3);
  CHECK(read.scans == 1);
  REQUIRE(read.sequences.size() == 2);
  for (std::size_t s = 0; s < 2; ++s) {
    CHECK(read.sequences[s].name == made.sequences[s].name);
    REQUIRE(read.sequences[s].repeats.size() == 2);
    for (std::size_t r = 0; r < 2; ++r) {
      const analysis::Repeat &from = made.sequences[s].repeats[r], &to = read.sequences[s].repeats[r];
      REQUIRE(to.steps.size() == from.steps.size());
      double farthest = 0.0;
      for (std::size_t i = 0; i < from.volts.size(); ++i)
        farthest = std::max(farthest, std::abs(to.volts[i] - std::max(0.0, from.volts[i])));
      CHECK(farthest <= 0.5001 / kVolt);
      CHECK(to.steps[7].setpoint_psi == from.steps[7].setpoint_psi);
      CHECK(to.steps[7].reference_psi == from.steps[7].reference_psi);
      CHECK(to.steps[7].time_s == from.steps[7].time_s);
      CHECK(to.steps[7].held_s == 2.0);
    }
  }
}

TEST_CASE("benchmark compensate: its frames go 0-60-10-50-0 psi in phase, with 4 mV of noise") {
  constexpr std::size_t kTaxels = 40, kFrames = 80;
  const CompensationCase c = slow_cycles(kTaxels, kFrames);
  CHECK(c.frames == kFrames);
  REQUIRE(c.counts.size() == kTaxels * kFrames);
  CHECK(*std::ranges::min_element(c.counts) == 0);  // noise below 0 V
  REQUIRE(c.models.size() == kTaxels);
  CHECK(c.setup.volts_per_count == 5.0 / 65536.0);
  CHECK_FALSE(c.setup.start_unknown);
  CHECK(c.setup.taxels[3].noise_v == kNoise);
  CHECK(c.setup.taxels[3].usable);
  CHECK_FALSE(c.setup.taxels[3].falling);
  Spread noise;
  for (std::size_t t = 0; t < kTaxels; ++t) {
    const ElamModel& model = c.models[t];
    const ElamCurve up(model, true, 0.0, model.y0()), down(model, false, 60.0, model.yu());
    const ElamCurve again(model, true, 10.0, down.output(10.0)), back(model, false, 50.0, again.output(50.0));
    for (std::size_t f = 0; f < kFrames; ++f) {
      const double share = static_cast<double>(f % 20) / 20.0;
      const double volts = f < 20   ? up.output(60.0 * share)
                           : f < 40 ? down.output(60.0 - 50.0 * share)
                           : f < 60 ? again.output(10.0 + 40.0 * share)
                                    : back.output(50.0 - 50.0 * share);
      if (volts > 0.05) noise.add(c.counts[f * kTaxels + t] / kVolt - volts);
    }
  }
  CHECK(noise.count > 2900);
  CHECK(noise.deviation() == Approx(kNoise).epsilon(0.06));
  CHECK(std::abs(noise.mean()) < 0.0004);
  CHECK(noise.largest < 6.0 * kNoise);
}

TEST_CASE("benchmark compensate: random counts of seed 9, and an array laid down several times") {
  const CompensationCase c = random_frames(4, 2);
  CHECK(c.counts == std::vector<std::uint16_t>{13352, 24986, 339, 14438, 488, 43914, 6187, 6329});
  const CompensationCase more = tiled(c, 3, 1);
  CHECK(more.frames == 1);
  CHECK(more.counts ==
        std::vector<std::uint16_t>{13352, 24986, 339, 14438, 13352, 24986, 339, 14438, 13352, 24986, 339, 14438});
  REQUIRE(more.models.size() == 12);
  REQUIRE(more.setup.taxels.size() == 12);
  CHECK(more.models[9].parameters.alpha_d == c.models[1].parameters.alpha_d);
  CHECK(more.setup.taxels[6].ascending_v == c.setup.taxels[2].ascending_v);
}

TEST_CASE("benchmark identify: the plain J counts each sample behind the turning point once") {
  std::mt19937 random(5);
  const ElamModel model = taxel_like_the_paper(random);
  const ElamCurve up(model, true, model.x0(), model.y0()), down(model, false, model.xu(), model.yu());
  const std::vector<analysis::TaxelBranch> branches{
      {true, {0.0, 20.0, 40.0, 60.0}, {0.0, up.output(20.0) + 0.1, up.output(40.0) - 0.2, up.output(60.0)}},
      {false, {60.0, 30.0, 0.0}, {model.yu(), down.output(30.0) + 0.3, 0.0}}};
  CHECK(plain_j(model, branches) == Approx(0.01 + 0.04 + 0.09));
}

TEST_CASE("benchmark figures carry the benchmark's name, and each goal stands behind its figure") {
  FigureList list("array");
  list.add("scan", 2.0, "us");
  list.add_at_most("ratio", 3.0, 4.0);
  list.add_at_least("gain", 5.0, 6.0, "1");
  std::string text;
  for (const Figure& figure : list.take())
    text += figure.name + ' ' + std::to_string(static_cast<int>(figure.value)) + ' ' + figure.unit + '\n';
  CHECK(
      text ==
      "array_scan 2 us\narray_ratio 3 x\narray_ratio_goal_at_most 4 x\narray_gain 5 1\narray_gain_goal_at_least 6 1\n");
}

TEST_CASE("benchmark rounds go through all acts in turn, by either clock") {
  for (const By by : {By::kWall, By::kProcessor}) {
    std::string order;
    const std::vector<double> best =
        best_seconds(3, std::vector<std::function<void()>>{[&] { order += 'a'; }, [&] { order += 'b'; }}, by);
    CHECK(order == "ababab");
    REQUIRE(best.size() == 2);
    for (const double seconds : best) CHECK((seconds >= 0.0 && seconds < 10.0));
  }
  int calls = 0;
  CHECK(best_seconds(2, [&] { ++calls; }) < 10.0);
  CHECK(calls == 2);
}

TEST_CASE("benchmark streams go through all frames round by round, the last stretch too") {
  std::vector<std::size_t> frames;
  const double seconds = sum_of_best_seconds(2, 250, [&](std::size_t f) { frames.push_back(f); });
  CHECK((seconds >= 0.0 && seconds < 10.0));
  REQUIRE(frames.size() == 500);
  for (std::size_t i = 0; i < frames.size(); ++i) CHECK(frames[i] == i % 250);
}
