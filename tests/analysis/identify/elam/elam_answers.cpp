// Pieces of identification by hand: parameters by direction, samples at one place, crossings of minor loops.
#include <catch2/catch.hpp>
#include <cmath>

#include "analysis/error.h"
#include "analysis/identify/congruency.h"
#include "analysis/identify/elam/elam_samples.h"
#include "analysis/identify/elam/identify.h"
#include "analysis/identify/sensor_model.h"
#include "tests/analysis/support/sensor_models.h"

using namespace tactbench::analysis;

namespace {

// A straight line from (0, 0.5) to (60, 6.5) whose inner curves are that line, too.
ElamModel line_model() {
  const std::vector<double> ends{0.0, 60.0}, volts{0.5, 6.5};
  const PatternCurve line(ends, volts, 0.5, 6.5);
  return {line, line, {}, {}};
}

// Up to each of three turns and down again, then a way up from 20 psi; `drop`: what the ways down lose to 20 psi,
// `gain`: what the way up gains to 30, 40 and 50 psi.
FitData crossing_loops(const std::vector<double>& drop, const std::vector<double>& gain, double first = 0.0,
                       double last = 60.0) {
  FitData data;
  const std::vector<double> ends{0.0, 60.0}, volts{0.0, 6.0};
  data.ascending = data.descending = PatternCurve(ends, volts, 0.0, 6.0);
  History h{"h", {first, 30, 20, first, 40, 20, first, 50, 20, first, last, 20, 30, 40, 50, 60}, {}, {}, {}, {}};
  h.y = {
      0, 3, 3 - drop[0], 0, 4, 4 - drop[1], 0, 5, 5 - drop[2], 0, 6, 2.5, 2.5 + gain[0], 2.5 + gain[1], 2.5 + gain[2],
      6};
  h.branches = branches_along(h.x);
  data.histories = {h};
  return data;
}

}  // namespace

TEST_CASE("parameters by direction: the split of the shortest and of the longest rise, and back") {
  ElamParameters p{0.1, 0.2, 0.005, 0.3, 0.4};
  const std::array<double, 3> down = direction_of(p, false, 60), up = direction_of(p, true, 60);
  CHECK((down[0] == 0.1 && down[1] == 0.2));
  CHECK((up[0] == 0.3 && up[1] == Approx(0.6) && up[2] == 0.4));
  const double rise[] = {0.9, 0.3, 0.7}, fall[] = {0.8, 0.6};
  set_direction(p, true, 60, rise);
  CHECK((p.alpha_a0 == 0.9 && p.alpha_a1 == Approx(-0.01) && p.beta_a == 0.7 && p.alpha_d == 0.1));
  set_direction(p, false, 60, fall);
  CHECK((p.alpha_d == 0.8 && p.beta_d == 0.6 && p.beta_a == 0.7));
}

TEST_CASE("samples at one place by hand: their mean, their weight, and what no model can take off") {
  // At 40 psi 4, 5 and 9 V of one curve: mean 6, squares 14; at 20 psi 1 and 2: 0.5.
  const std::vector<TaxelBranch> branches{{false, {60, 40, 20}, {9, 4, 1}},
                                          {false, {59.9, 20, 40}, {9, 2, 5}},
                                          {false, {60, 40}, {9, 9}},
                                          {true, {30, 50}, {1, 2}},
                                          {true, {30, 50}, {1.5, 4}}};
  const ElamSamples samples = collect_samples(line_model(), branches);
  REQUIRE(samples.descending.size() == 1);
  CHECK(samples.descending[0].x == std::vector<double>{20, 40});
  CHECK(samples.descending[0].y == std::vector<double>{1.5, 6});
  CHECK(samples.descending[0].weight == std::vector<double>{2, 3});
  CHECK(samples.descending_constant == Approx(14.5));
  CHECK((samples.descending[0].x_turn == 60.0 && samples.descending[0].y_turn == 6.5));
  REQUIRE(samples.ascending.size() == 2);  // two turns at one pressure, of other outputs
  CHECK(samples.ascending_constant == 0.0);
}

TEST_CASE("crossings of minor loops by hand: what a fall loses between two turns is what a rise gains") {
  // 1.5, 1.9 and 2.4 V lost from 30, 40 and 50 psi to 20; 1.2, 2.0 and 2.2 gained: 0.3, -0.1 and 0.2 V off.
  const Congruency found = find_divider(crossing_loops({1.5, 1.9, 2.4}, {1.2, 2.0, 2.2}));
  CHECK(found.pairs == 3);
  CHECK(found.plain_rms == Approx(std::sqrt((0.09 + 0.01 + 0.04) / 3)));
  CHECK(found.rms <= found.plain_rms);
  CHECK(found.divider.zero == 0.0);
  // Alike: no divider.
  const Congruency alike = find_divider(crossing_loops({1.2, 2.0, 2.2}, {1.2, 2.0, 2.2}));
  CHECK(alike.plain_rms == Approx(0.0).margin(1e-12));
  CHECK(alike.divider.per_amplitude == 0.0);
  // Ways that do not come from an end are of no first order.
  CHECK(find_divider(crossing_loops({1, 1, 1}, {1, 1, 1}, 0.59)).pairs == 3);
  CHECK(find_divider(crossing_loops({1, 1, 1}, {1, 1, 1}, 0.61)).pairs == 0);
  CHECK(find_divider(crossing_loops({1, 1, 1}, {1, 1, 1}, 0.0, 59.41)).pairs == 3);
  CHECK(find_divider(crossing_loops({1, 1, 1}, {1, 1, 1}, 0.0, 59.39)).pairs == 0);
}

TEST_CASE("a divider by hand: loops that are congruent once it is undone tell its amplitude") {
  // u = 1.2, 2.0, 2.2 gained by a rise from u = 2.5, lost by falls from 3, 4 and 5, each read as u / (1 + u / 8).
  FitData data = crossing_loops({1.2, 2.0, 2.2}, {1.2, 2.0, 2.2});
  for (double& y : data.histories[0].y) y = y / (1.0 + y / 8.0);
  const std::vector<double> ends{0.0, 60.0}, volts{0.0, 6.0 / (1.0 + 6.0 / 8.0)};
  data.ascending = data.descending = PatternCurve(ends, volts, 0.0, volts[1]);
  const Congruency found = find_divider(data);
  CHECK(found.pairs == 3);
  CHECK(found.divider.per_amplitude == Approx(1.0 / 8.0).epsilon(1e-4));
  CHECK(found.plain_rms > 0.07);
  CHECK(found.rms < 1e-5);
  const FitData undone = linearised(data, {0.0, 1.0 / 8.0});
  CHECK(undone.histories[0].y[4] == Approx(4.0));
  CHECK(undone.ascending(60) == Approx(6.0));
  CHECK(undone.descending(0) == 0.0);
}

TEST_CASE("a sensor's model by hand: outputs of adjusted and falling taxels, who is fitted, whose is the mean") {
  SensorModel model;
  model.source = "run 3";
  const ElamModel line = line_model();
  ModelTaxel taxel = by_hand::elam_taxel(line.ascending, line.descending);
  CHECK(taxel.full_scale() == 6.5);
  CHECK(ModelTaxel().full_scale() == 0.0);
  const ExternalBranch plain(taxel, true);
  CHECK(plain.output(30) == Approx(3.5));
  CHECK(plain.input(3.5) == Approx(30.0));
  CHECK(ExternalBranch(taxel, false).input(99) == Approx(60.0));
  taxel.zero = 1.0;
  taxel.gain = 2.0;
  const ExternalBranch moved(taxel, false);
  CHECK(moved.output(30) == Approx(8.0));
  CHECK(moved.input(8.0) == Approx(30.0));
  CHECK((taxel.to_model(8.0) == 3.5 && taxel.from_model(3.5) == 8.0));
  CHECK((model.to_model(taxel, 8.0) == 3.5 && model.from_model(taxel, 3.5) == 8.0));
  const History history{"h", {0, 30, 60}, {2, 8, 14}, {{0, 2, true}}, {}, {}};
  CHECK(taxel.predicted(history, false)[1] == Approx(8.0));
  const std::vector<double> inputs{0, 30, 60}, up{0.5, 3, 6.5}, down{0.5, 4, 6.5};
  set_loop(taxel, inputs, up, down);
  CHECK((taxel.ascending(30) == 7.0 && taxel.descending(30) == 9.0 && taxel.y0() == 2.0 && taxel.yu() == 14.0));
  set_loop(taxel, inputs);
  CHECK((taxel.ascending(30) == Approx(8.0) && taxel.descending(30) == Approx(8.0)));
  model.falling = true;
  CHECK((model.to_model(taxel, -8.0) == 3.5 && model.from_model(taxel, 3.5) == -8.0));
  model.taxels = {taxel, by_hand::left_out(TaxelStatus::kDead), taxel};
  CHECK(model.array().size() == 3);  // none of them is the mean
  by_hand::finish(model, taxel);
  CHECK(model.array().size() == 3);
  CHECK(model.fitted() == std::vector<std::size_t>{0, 2});
  CHECK(model.taxel(1).status == TaxelStatus::kDead);
  CHECK(&model.taxel(kMeanTaxel) == &model.mean_taxel());
  CHECK(model.full_scale_v() == 14.0);
  CHECK_THROWS_WITH(model.taxel(9), "the model of run 3 has no taxel 9; it has 4 of them");
  CHECK(SensorModel().array().empty());
}
