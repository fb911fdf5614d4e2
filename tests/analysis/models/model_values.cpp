// Outputs, inverses and parameters of the models by hand, on loops with few numbers.
#include <catch2/catch.hpp>
#include <cmath>
#include <memory>
#include <vector>

#include "analysis/models/linearised.h"
#include "tests/analysis/support/models.h"

using namespace synthetic;

namespace {

// Outputs along inputs, and back along these outputs.
void check_way(const HysteresisModel& model, const std::vector<std::pair<double, double>>& way) {
  const auto direct = model.state(), inverse = model.state();
  for (const auto& [x, y] : way) {
    CAPTURE(x, y);
    CHECK(direct->output_at(x) == Approx(y).margin(1e-12));
    const double back = inverse->input_at(y);
    CHECK(back == Approx(x).margin(1e-9));
    direct->go(x);
    inverse->go(back);
    CHECK(direct->output_at(x) == Approx(y).margin(1e-12));
  }
}

// Cells of two intervals: (0,0) 1, (1,0) 1, (1,1) 1. Up 0, 1, 3 at 0, 30, 60; down 3, 2, 0.
PreisachModel small_preisach(double low = 0.0, double y_low = 0.0) { return {low, low + 60.0, y_low, {1, 1, 1}}; }

}  // namespace

TEST_CASE("Preisach: Everett's function over three cells matches hand-computed values") {
  const PreisachModel model = small_preisach();
  const std::vector<std::vector<double>> answers = {
      // high, low, rise: wholly in the first interval, over both, wholly in the second.
      {30, 0, 1},    {15, 0, 0.5},  {30, 15, 0.5}, {20, 10, 1.0 / 3.0}, {60, 0, 3}, {45, 0, 2}, {60, 30, 1},
      {60, 45, 0.5}, {45, 30, 0.5}, {60, 15, 2},   {45, 15, 1.0 + 0.0}, {0, 0, 0},  {10, 20, 0}};
  for (const std::vector<double>& own : answers) {
    CAPTURE(own[0], own[1]);
    CHECK(model.everett(own[0], own[1]) == Approx(own[2]).margin(1e-12));
    CHECK(small_preisach(-20.0, 5.0).everett(own[0] - 20.0, own[1] - 20.0) == Approx(own[2]).margin(1e-12));
  }
  CHECK(model.intervals() == 2);
}

TEST_CASE("Preisach: an inner loop closes, and a larger extreme wipes it out") {
  check_way(small_preisach(), {{15, 0.5}, {30, 1}, {45, 2}, {60, 3}, {45, 2.5}, {30, 2}, {15, 1}, {0, 0}, {30, 1}});
  // Down to 30 from 60: 2. Up to 45: 2.5, down again: 2, as before; on to 15: 1.
  check_way(small_preisach(), {{60, 3}, {30, 2}, {45, 2.5}, {30, 2}, {15, 1}, {30, 1.5}, {60, 3}, {30, 2}});
  // From 45: the rise of 2 comes back by 1 to 15, and goes on to 3.
  check_way(small_preisach(), {{45, 2}, {15, 1}, {45, 2}, {60, 3}});
  check_way(small_preisach(-20.0, 5.0), {{10, 6}, {40, 8}, {10, 7}, {-20, 5}});
}

TEST_CASE("monotone model: meets its knots, interpolates between them, and is constant beyond its ends") {
  const std::vector<double> x{0, 10, 30, 60}, y{0.0, 1.0, 3.0, 9.0};
  const MonotoneModel model(PatternCurve(x, y, 0.0, 9.0));
  check_way(model, {{0, 0}, {5, 0.5}, {10, 1}, {20, 2}, {30, 3}, {45, 6}, {60, 9}, {20, 2}});
  CHECK(model.state()->output_at(70.0) == 9.0);
  CHECK(model.state()->output_at(-1.0) == 0.0);
  CHECK(model.state()->input_at(9.5) == 60.0);
  CHECK(model.state()->input_at(-0.5) == 0.0);
  const PatternCurve curve(x, y, 0.0, 9.0);
  for (const auto& [at, slope] :
       {std::pair{-5.0, 0.1}, {0.0, 0.1}, {10.0, 0.1}, {25.0, 0.1}, {30.0, 0.2}, {59.0, 0.2}, {70.0, 0.2}})
    CHECK(curve.slope(at) == Approx(slope));
}

TEST_CASE("POLY: branches run from one turning point to the next and converge at the ends") {
  // Up and down straight: 0 to 60 is 0 to 3, whatever the branch.
  PolyParameters p;
  p.a[5] = p.b[5] = 0.05;
  const PolyModel straight(p, 0.0, 60.0, 0.0, 3.0);
  check_way(straight, {{20, 1}, {40, 2}, {10, 0.5}, {60, 3}, {0, 0}});
  // Up as the square of the share, down as twice the share less its square.
  PolyParameters q;
  q.a[4] = 1.0;
  q.b[4] = -1.0;
  q.b[5] = 120.0;
  const PolyModel bent(q, 0.0, 60.0, 0.0, 4.0);
  // 30: a quarter of 4. From there down to 15, half of the way: 3/4 of 1. Up to 37.5, half of the way to 60: a quarter
  // of what is missing to 4.
  check_way(bent, {{30, 1}, {15, 0.75}, {37.5, 0.75 + 0.25 * 3.25}, {60, 4}, {30, 3}, {45, 3.25}});
  const auto measured = bent.state();
  measured->go(30.0);
  measured->measured(2.0);
  CHECK(measured->output_at(45.0) == Approx(2.0 + 0.25 * 2.0));
  CHECK(measured->output_at(15.0) == Approx(0.75 * 2.0));
  CHECK(measured->input_at(2.5) == Approx(45.0));
  CHECK(measured->input_at(1.5) == Approx(15.0));
}

TEST_CASE("GPI: outputs of equal envelopes match hand-computed values, and thresholds widen the loop") {
  // With a1 = b1 = ln 2 / 10 the envelopes come half way nearer to 1 each 10: 1 - 2^(-x / 10), left and right alike.
  // The thresholds are 0 and four times 10, which no output reaches: the first operator is the envelope itself.
  const double halving = std::log(2.0) / 10.0;
  GpiParameters p{.a0 = 1,
                  .a1 = halving,
                  .a2 = 0,
                  .a3 = 1,
                  .b0 = 1,
                  .b1 = halving,
                  .b2 = 0,
                  .b3 = 1,
                  .alpha = 10,
                  .rho = 2,
                  .tau = 0};
  check_way(GpiModel(p, 0.0, 60.0, 0.5), {{10, 1.5}, {20, 2.0}, {30, 2.25}, {10, 1.5}, {0, 0.5}});
  // A threshold of a tenth: the second operator comes 0.1 later and stays 0.1 above on the way down; e^(-tau 0.1) =
  // 1/2, 1/4 and so on of the third to fifth.
  p.alpha = 0.1;
  p.tau = 10.0 * std::log(2.0);
  const GpiModel loop(p, 0.0, 60.0, 0.0);
  const auto up = [](double v) {
    return 2.0 * (v + 0.5 * std::max(0.0, v - 0.1) + 0.25 * std::max(0.0, v - 0.2) + 0.125 * std::max(0.0, v - 0.3) +
                  0.0625 * std::max(0.0, v - 0.4));
  };
  // At 10 the envelope is 0.5, at 20 0.75; back at 10 the operators stand at 0.5, 0.6, 0.55, 0.45, 0.35.
  check_way(
      loop,
      {{10, up(0.5)}, {20, up(0.75)}, {10, 2.0 * (0.5 + 0.5 * 0.6 + 0.25 * 0.55 + 0.125 * 0.45 + 0.0625 * 0.35)}});
  CHECK(loop.state()->output_at(5.0) == Approx(up(1.0 - std::sqrt(0.5))));
}

TEST_CASE("divider: converts output to linear output and back, up to its end and beyond") {
  // c = 1/4 a volt: u = v / (1 - v / 4), so that 2 V are 4 and 3 V 12, on a zero of half a volt.
  const Divider divider{0.5, 0.25};
  for (const auto& [output, linear] : {std::pair{0.5, 0.0}, {2.5, 4.0}, {3.5, 12.0}, {-0.5, -0.8}}) {
    CAPTURE(output);
    CHECK(divider.linear(output) == Approx(linear).margin(1e-12));
    CHECK(divider.output(linear) == Approx(output));
  }
  // The end is 0.995 of 4 V: 3.98 / 0.005 = 796; further volts count once.
  CHECK(divider.linear_end() == Approx(796.0));
  CHECK(divider.linear(4.48) == Approx(796.0));
  CHECK(divider.linear(4.68) == Approx(796.2));
  CHECK(divider.output(796.2) == Approx(4.68));
  CHECK(Divider{0.5, 0.0}.linear(2.5) == 2.0);
  CHECK(Divider{0.5, 0.0}.output(2.0) == 2.5);
  // A model behind it: 1 and 3 of the small loop are 1 / 1.25 and 3 / 1.75 above the zero.
  const LinearisedModel model(divider, std::make_shared<PreisachModel>(small_preisach()));
  check_way(model, {{30, 0.5 + 0.8}, {60, 0.5 + 3.0 / 1.75}, {30, 0.5 + 2.0 / 1.5}, {0, 0.5}});
}
