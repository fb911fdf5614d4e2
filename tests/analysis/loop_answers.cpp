// Branches of noisy inputs, slopes where the reference hardly moves, and full sweeps at their limits: by hand.
#include <catch2/catch.hpp>
#include <string>

#include "analysis/loop.h"

using namespace tactbench::analysis;

namespace {

std::string branches_of(const std::vector<double>& x, double tolerance = 0.0) {
  std::string out;
  for (const Branch& branch : branches_along(x, tolerance))
    out += (branch.ascending ? "+" : "-") + std::to_string(branch.first) + "." + std::to_string(branch.last) + " ";
  return out;
}

TaxelTable along_levels(const std::vector<double>& psi, const std::vector<double>& values) {
  TaxelTable table;
  table.pressure_psi = psi;
  table.values = values;
  table.branches = branches_along(psi);
  return table;
}

// Sweeps up from `bottom` and down again to it, beside full ones from 0 to 100 psi: how many count.
bool counts_as_full(double bottom, double top, double turn = 0.0) {
  // The full ones read 0 at 50 psi, this one 100: the mean of two is 50.
  const std::vector<TaxelTable> tables{along_levels({0, 50, 100, 50, 0}, {0, 0, 0, 0, 0}),
                                       along_levels({bottom, 50, top, 50, bottom}, {0, 100, 0, 100, 0})};
  const ExternalLoop loop = external_loop(tables, 1, turn);
  CHECK(loop.ascending[1] == loop.descending[1]);
  CHECK((loop.ascending[1] == Approx(50.0) || loop.ascending[1] == 0.0));
  return loop.ascending[1] != 0.0;
}

// One branch up and down whose reference reads `reference` at the given step and the set-point elsewhere.
double moved_output(const std::vector<double>& setpoints, const std::vector<double>& references,
                    const std::vector<double>& volts, std::size_t step) {
  Repeat repeat;
  for (std::size_t i = 0; i < setpoints.size(); ++i) repeat.steps.push_back({setpoints[i], references[i]});
  repeat.volts = volts;
  return bring_to_common({"s", {repeat}}, 1).values[step];
}

}  // namespace

TEST_CASE("branches by hand: turns count beyond the tolerance, from the extreme, in both directions") {
  CHECK(branches_of({0, 1, 3, 2, 0}) == "+0.2 -2.4 ");
  CHECK(branches_of({5, 3, 4, 1}) == "-0.1 +1.2 -2.3 ");
  CHECK(branches_of({0, 1, 3, 2.5, 4, 0}, 0.5) == "+0.4 -4.5 ");  // back by half: not beyond it
  CHECK(branches_of({0, 1, 3, 2.4, 4, 0}, 0.5) == "+0.2 -2.3 +3.4 -4.5 ");
  CHECK(branches_of({4, 1, 1.5, 0, 3}, 0.5) == "-0.3 +3.4 ");
  CHECK(branches_of({4, 1, 1.6, 0, 3}, 0.5) == "-0.1 +1.2 -2.3 +3.4 ");
  CHECK(branches_of({0, 0.5, 0.2, 0.6, 2}, 0.5) == "+0.4 ");  // the first movement is beyond it at 0.6
  CHECK(branches_of({0, 0.5}, 0.5).empty());
  CHECK(branches_of({0, 0.51}, 0.5) == "+0.1 ");
  CHECK(branches_of({0, 3, 2.8, 2.6, 2.4, 0}, 0.5) == "+0.1 -1.5 ");  // the turn lies at the highest
  CHECK(branches_of({}).empty());
  CHECK(branches_of({0, 2, 2, 0, 0, 2}) == "+0.2 -2.4 +4.5 ");  // a held extreme belongs to the way to it
}

TEST_CASE("outputs moved by hand: the slope between neighbours of the branch, at its ends to one side") {
  // Up 0 10 20 psi by 0 1 4 V, down 10 0 by 3 0. The reference is 1 psi high at the step looked at.
  const std::vector<double> psi{0, 10, 20, 10, 0}, volts{0, 1, 4, 3, 0};
  const auto moved = [&](std::size_t step) {
    std::vector<double> reference = psi;
    reference[step] += 1.0;
    return moved_output(psi, reference, volts, step);
  };
  CHECK(moved(0) == Approx(0.0 - 1.0 / 9.0));   // to the next alone: 1 V over 9 psi
  CHECK(moved(1) == Approx(1.0 - 4.0 / 20.0));  // between 0 and 20 psi
  CHECK(moved(2) == Approx(4.0 - 3.0 / 11.0));  // the turn: of the way up
  CHECK(moved(3) == Approx(3.0 - 4.0 / 20.0));  // of the way down
  CHECK(moved(4) == Approx(0.0 - 3.0 / 9.0));
}

TEST_CASE("outputs moved by hand: where the reference moves by a tenth of the command or less, the command counts") {
  // Between 0 and 20 psi by 0 and 4 V; the reference at the ends of it moves by `moves`.
  const auto moved = [](double moves) { return moved_output({0, 10, 20}, {0, 11, moves}, {0, 1, 4}, 1); };
  CHECK(moved(2.1) == Approx(1.0 - 4.0 / 2.1));
  CHECK(moved(1.9) == Approx(1.0 - 4.0 / 20.0));
  CHECK(moved(-5.0) == Approx(1.0 - 4.0 / 20.0));
  // Steps of one set-point: nothing is commanded, nothing is known of a slope.
  CHECK(moved_output({0, 0, 0, 10}, {0, 1, 2, 10}, {0, 5, 9, 20}, 1) == 5.0);
}

TEST_CASE("repeats chosen by hand: from the first to the last asked for, in their mean") {
  SequenceData sequence{"s", {}};
  for (const double v : {1.0, 2.0, 6.0, 9.0}) sequence.repeats.push_back({{{0, 0}, {2, 2}}, {v, v}});
  const auto mean = [&](int first, int last) {
    return bring_to_common(sequence, 1, {.move_to_setpoint = true, .first_repeat = first, .last_repeat = last})
        .values[0];
  };
  CHECK(mean(0, -1) == Approx(4.5));
  CHECK(mean(1, 2) == Approx(4.0));
  CHECK(mean(0, 0) == 1.0);
  CHECK(mean(3, 3) == 9.0);
  CHECK_THROWS_AS(mean(2, 1), AnalysisError);
  CHECK_THROWS_AS(mean(0, 4), AnalysisError);
  CHECK_THROWS_AS(mean(-1, 2), AnalysisError);
  // References of two repeats where nothing is moved: their mean.
  sequence.repeats[0].steps[1].reference_psi = 2.4;
  const TaxelTable left =
      bring_to_common(sequence, 1, {.move_to_setpoint = false, .first_repeat = 0, .last_repeat = 1});
  CHECK(left.pressure_psi[1] == Approx(2.2));
  CHECK(left.values[1] == Approx(1.5));
}

TEST_CASE("full sweeps: within 1 % of the span from both ends, or within the turn where that is more") {
  CHECK(counts_as_full(0, 100));
  CHECK(counts_as_full(0.99, 100));
  CHECK_FALSE(counts_as_full(1.01, 100));
  CHECK(counts_as_full(0, 99.01));
  CHECK_FALSE(counts_as_full(0, 98.99));
  CHECK(counts_as_full(4.9, 95.1, 5.0));
  CHECK_FALSE(counts_as_full(5.1, 100, 5.0));
  CHECK_FALSE(counts_as_full(0, 94.9, 5.0));
  CHECK(counts_as_full(0.99, 100, 0.5));
}

TEST_CASE("the external loop by hand: on the grid of the finest sweep up, others between their steps and beyond") {
  // Up in three steps and in two (that one reads 10 more), down in two.
  const std::vector<TaxelTable> tables{along_levels({0, 30, 40, 100}, {0, 3, 4, 10}),
                                       along_levels({0, 50, 100, 20, 0}, {10, 15, 20, 4, 0})};
  const ExternalLoop loop = external_loop(tables, 1);
  CHECK(loop.pressure_psi == std::vector<double>{0, 30, 40, 100});
  const std::vector<double> up{5, 8, 9, 15}, down{0, 6, 8, 20};
  for (std::size_t i = 0; i < 4; ++i) {
    CHECK(loop.ascending[i] == Approx(up[i]));
    CHECK(loop.descending[i] == Approx(down[i]));
  }
  CHECK(loop.left_out == 0.0);
  // A held step gives no point of the grid; a sweep that ends a little short goes on along its last steps.
  const std::vector<TaxelTable> held{along_levels({0, 50, 50, 100, 50, 0.5}, {0, 5, 7, 10, 5, 0.05})};
  const ExternalLoop short_one = external_loop(held, 1);
  CHECK(short_one.pressure_psi == std::vector<double>{0, 50, 100});
  CHECK(short_one.ascending[1] == Approx(7.0));
  CHECK(short_one.descending[0] == Approx(0.0).margin(1e-12));
}

TEST_CASE(
    "full sweeps of measured inputs: without ones between the extremes, percentiles are tried, of commanded none") {
  // 99 sweeps up and down between 0 and 100, and one sample at 200 on its own way up: of 401 inputs the one beyond.
  std::vector<double> psi{0};
  for (int i = 0; i < 99; ++i) psi.insert(psi.end(), {50, 100, 50, 0});
  psi.insert(psi.end(), {50, 100, 50, 10, 200});
  const std::vector<TaxelTable> tables{along_levels(psi, std::vector<double>(psi.size(), 1.0))};
  const ExternalLoop loop = external_loop(tables, 1, 0.1);
  CHECK(loop.left_out == 0.005);  // 2 of 402 are beyond each end; 0.2 % are none
  CHECK(loop.pressure_psi.back() == 100.0);
  CHECK_THROWS_AS(external_loop(tables, 1), AnalysisError);
  try {
    (void)external_loop(std::vector{along_levels({0, 10, 5}, {0, 1, 2})}, 1, 0.1);
    FAIL_CHECK("accepted");
  } catch (const AnalysisError& error) {
    CHECK(std::string(error.what()) == "no sweep falls over the full range of inputs");
  }
}
