// Branches, outputs moved to set-points and external loops by hand: tolerances, slopes that are not, sweeps that are
// nearly full, inputs that are left out.
#include "analysis/loop.h"

#include <catch2/catch.hpp>
#include <string>

using namespace tactbench::analysis;

namespace {

std::vector<std::vector<int>> branch_numbers(const std::vector<double>& x, double tolerance) {
  std::vector<std::vector<int>> out;
  for (const Branch& branch : branches_along(x, tolerance))
    out.push_back({branch.first, branch.last, branch.ascending ? 1 : -1});
  return out;
}

// One taxel along the set-points given, with what was measured of each.
SequenceData measured_sequence(const std::vector<double>& setpoints, const std::vector<double>& references,
                               const std::vector<double>& volts) {
  Repeat repeat;
  for (std::size_t i = 0; i < setpoints.size(); ++i) repeat.steps.push_back({setpoints[i], references[i]});
  repeat.volts = volts;
  return {"s", {repeat}};
}

TaxelTable table_along(const std::vector<double>& pressures, std::vector<Branch> branches) {
  TaxelTable table;
  table.pressure_psi = table.values = pressures;  // 1 V a psi
  table.branches = std::move(branches);
  return table;
}

std::string loop_refused(const std::vector<TaxelTable>& tables, double turn) {
  try {
    external_loop(tables, 1, turn);
  } catch (const AnalysisError& error) {
    return error.what();
  }
  return {};
}

// Up and down between 0 and 60 in 300 steps each way, then inputs that no branch holds.
TaxelTable fine_loop(const std::vector<double>& strays) {
  std::vector<double> pressures;
  for (int i = 0; i <= 300; ++i) pressures.push_back(0.2 * i);
  for (int i = 299; i >= 0; --i) pressures.push_back(0.2 * i);
  pressures.insert(pressures.end(), strays.begin(), strays.end());
  return table_along(pressures, {{0, 300, true}, {300, 600, false}});
}

}  // namespace

TEST_CASE("branches by hand: a turn counts once the input has gone back by more than the tolerance") {
  using Numbers = std::vector<std::vector<int>>;
  CHECK(branch_numbers({0, 2, 1.5, 3}, 0.5) == Numbers{{0, 3, 1}});
  CHECK(branch_numbers({0, 2, 1.25, 3}, 0.5) == Numbers{{0, 1, 1}, {1, 2, -1}, {2, 3, 1}});
  CHECK(branch_numbers({5, 4, 4.5, 3}, 0.5) == Numbers{{0, 3, -1}});
  CHECK(branch_numbers({5, 4, 4.75, 3}, 0.5) == Numbers{{0, 1, -1}, {1, 2, 1}, {2, 3, -1}});
  // Before it has moved by more than that it has no direction.
  CHECK(branch_numbers({0, 0.5, -0.5, 0.5}, 0.5).empty());
  CHECK(branch_numbers({0, 0.5, -0.75, -1}, 0.5) == Numbers{{0, 3, -1}});
  CHECK(branch_numbers({0, 0.5, 0.75, 1}, 0.5) == Numbers{{0, 3, 1}});
  // The turn is the furthest input, and of equal ones the last.
  CHECK(branch_numbers({0, 3, 2.75, 3, 2.75, 1}, 0.5) == Numbers{{0, 3, 1}, {3, 5, -1}});
  CHECK(branch_numbers({1, 2, 1}, 0.0) == Numbers{{0, 1, 1}, {1, 2, -1}});
  CHECK(branch_numbers({}, 0.0).empty());
}

TEST_CASE("outputs moved by hand: where the reference moved a tenth of the commanded step or less, that step counts") {
  // Over two steps 4 psi are commanded and 3 V come; at the middle 0.5 psi are missing.
  const auto moved = [](double reference_end) {
    return bring_to_common(measured_sequence({0, 2, 4}, {0, 1.5, reference_end}, {0, 1, 3}), 1).values[1];
  };
  CHECK(moved(4.0) == Approx(1.0 + 0.5 * 3.0 / 4.0));
  CHECK(moved(0.5) == Approx(1.0 + 0.5 * 3.0 / 0.5));
  CHECK(moved(0.47) == Approx(1.0 + 0.5 * 3.0 / 0.47));
  CHECK(moved(0.4) == Approx(1.0 + 0.5 * 3.0 / 4.0));
  CHECK(moved(-1.0) == Approx(1.0 + 0.5 * 3.0 / 4.0));
  // At the ends of a branch the slope is that of its one neighbour: 1 V in 1.5 psi, 2 V in 2.5 psi.
  const TaxelTable ends = bring_to_common(measured_sequence({0, 2, 4}, {-0.25, 1.25, 3.75}, {0, 1, 3}), 1);
  CHECK(ends.values[0] == Approx(0.25 * 1.0 / 1.5));
  CHECK(ends.values[2] == Approx(3.0 + 0.25 * 2.0 / 2.5));
  // Where nothing is commanded nothing is moved.
  const TaxelTable held = bring_to_common(measured_sequence({0, 2, 2, 2}, {0, 1.5, 1.75, 1.9}, {0, 1, 1.5, 1.75}), 1);
  CHECK(held.values[2] == 1.5);
}

TEST_CASE("repeats by hand: those between the first and the last asked for, and no others") {
  SequenceData sequence{"s", {}};
  for (const double v : {1.0, 2.0, 6.0, 20.0}) {
    Repeat repeat = measured_sequence({0, 2, 0}, {0.5, 2.5, 0.5}, {v, v, v}).repeats.front();
    repeat.steps[1].reference_psi += v;
    sequence.repeats.push_back(repeat);
  }
  const auto mean = [&](int first, int last) {
    const TaxelTable table =
        bring_to_common(sequence, 1, {.move_to_setpoint = false, .first_repeat = first, .last_repeat = last});
    CHECK(table.pressure_psi[1] == Approx(2.5 + table.values[1]));
    return table.values[1];
  };
  CHECK(mean(0, -1) == Approx(7.25));
  CHECK(mean(0, 0) == Approx(1.0));
  CHECK(mean(1, 2) == Approx(4.0));
  CHECK(mean(3, 3) == Approx(20.0));
  for (const auto& [first, last] : {std::pair{-1, 2}, {0, 4}, {2, 1}, {4, -1}}) {
    INFO(first << " to " << last);
    CHECK_THROWS_WITH(bring_to_common(sequence, 1, {.first_repeat = first, .last_repeat = last}),
                      Catch::Contains("does not have the repeats asked for"));
  }
  // A repeat that is left out may be another.
  sequence.repeats[3].steps.pop_back();
  CHECK(mean(1, 2) == Approx(4.0));
  CHECK_THROWS_WITH(bring_to_common(sequence, 1), Catch::Contains("have other set-points"));
  CHECK_THROWS_WITH(bring_to_common(measured_sequence({2, 2, 2}, {2, 2, 2}, {1, 1, 1}), 1),
                    Catch::Contains("never changes its pressure"));
}

TEST_CASE("external loops by hand: a sweep is full within a hundredth of the span of both ends, or within a turn") {
  const auto ending = [](double low_end, double turn) {
    return loop_refused({table_along({0, 30, 60, 30, low_end}, {{0, 2, true}, {2, 4, false}})}, turn);
  };
  CHECK(ending(0.6, 0.0).empty());
  CHECK_THAT(ending(0.61, 0.0), Catch::Contains("no sweep falls over the full pressure range"));
  CHECK(ending(0.61, 0.62).empty());
  CHECK(ending(2.0, 2.0).empty());
  CHECK_THAT(ending(2.1, 2.0), Catch::Contains("no sweep falls over the full range of inputs"));
  const auto reaching = [](double high_end) {
    return loop_refused({table_along({60, 30, 0, 30, high_end}, {{0, 2, false}, {2, 4, true}})}, 0.0);
  };
  CHECK(reaching(59.5).empty());
  CHECK_THAT(reaching(59.3), Catch::Contains("no sweep rises"));
}

TEST_CASE("external loops by hand: on the finest rise's pressures, each once, other sweeps between and beyond theirs") {
  TaxelTable fine = table_along({0, 20, 20, 40, 60, 30, 0.5}, {{0, 4, true}, {4, 6, false}});
  fine.values = {0, 1, 5, 2, 6, 4, 0.5};
  TaxelTable coarse = table_along({0, 30, 60}, {{0, 2, true}});
  coarse.values = {0, 3, 9};
  const ExternalLoop loop = external_loop(std::vector{coarse, fine}, 1);
  CHECK(loop.pressure_psi == std::vector<double>{0, 20, 40, 60});
  CHECK(loop.left_out == 0.0);
  // Of the fine rise at 20 the later of the two, at 60 the last; of the coarse one 2, 5 and 9: the means.
  REQUIRE(loop.ascending.size() == 4);
  CHECK(loop.ascending[0] == Approx(0.0));
  CHECK(loop.ascending[1] == Approx(0.5 * (5.0 + 2.0)));
  CHECK(loop.ascending[2] == Approx(0.5 * (2.0 + 5.0)));
  CHECK(loop.ascending[3] == Approx(0.5 * (6.0 + 9.0)));
  // Down from (0.5, 0.5) by 3.5 V over 29.5 psi, and by 2 V over 30 psi: at 0 beyond its end.
  CHECK(loop.descending[0] == Approx(0.5 - 0.5 * 3.5 / 29.5));
  CHECK(loop.descending[1] == Approx(0.5 + 19.5 * 3.5 / 29.5));
  CHECK(loop.descending[2] == Approx(4.0 + 10.0 * 2.0 / 30.0));
  CHECK(loop.descending[3] == Approx(6.0));
}

TEST_CASE(
    "external loops by hand: of measured inputs as few as needed are left out at each end, of commanded ones none") {
  const auto left_out = [](const std::vector<double>& strays) {
    return external_loop(std::vector{fine_loop(strays)}, 1, 0.5).left_out;
  };
  CHECK(left_out({}) == 0.0);
  CHECK(left_out({60.5, -0.5}) == 0.0);                    // within a hundredth of the span
  CHECK(left_out({70.0}) == 0.002);                        // one of 602
  CHECK(left_out({70.0, 71.0}) == 0.005);                  // three of 603
  CHECK(left_out({-10.0, 71.0}) == 0.002);                 // one at each end
  CHECK(left_out(std::vector<double>(5, 70.0)) == 0.01);   // six of 606
  CHECK(left_out(std::vector<double>(10, 70.0)) == 0.02);  // twelve of 611
  CHECK_THAT(loop_refused({fine_loop(std::vector<double>(20, 70.0))}, 0.5), Catch::Contains("no sweep rises"));
  CHECK_THAT(loop_refused({fine_loop({70.0})}, 0.0), Catch::Contains("no sweep rises over the full pressure range"));
  const ExternalLoop loop = external_loop(std::vector{fine_loop({70.0})}, 1, 0.5);
  CHECK((loop.pressure_psi.size() == 301 && loop.ascending[150] == Approx(30.0)));
}
