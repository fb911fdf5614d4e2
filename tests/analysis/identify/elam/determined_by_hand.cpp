// Which member is taken of those that samples leave open, on straight patterns where it can be worked out by hand.
#include <catch2/catch.hpp>
#include <cmath>
#include <tuple>
#include <vector>

#include "analysis/identify/elam/elam_determined.h"

using namespace tactbench::analysis;

namespace {

const PatternCurve kStraight(std::vector<double>{0, 10}, std::vector<double>{0, 10}, 0.0, 10.0);

// Both pieces of a curve are straight. All samples lie on the piece that ends at 8 psi and 8 V (falling) or at 10 psi
// and 10 V (rising, from 2 psi and 2 V), 1 psi from that end, where the split in the middle of the pattern gives a
// slope of 1: they determine that piece's slope (1 - beta) / (1 - alpha) alone. The model has a slope of 1.1 and meets
// them.
struct OneSlope {
  bool ascending;
  int samples;
  ElamModel model{kStraight, kStraight, {}, {}};
  std::vector<CurveSamples> curves;
  OneSlope(bool up, int n) : ascending(up), samples(n) {
    // From 2 psi on, phi(8 psi) = 0.4.
    model.parameters = {0.4, 1.0 - 1.1 * 0.6, 0.01, 0.32, 1.0 - 1.1 * 0.6};
    const double turn = up ? 2.0 : 8.0, end = up ? 10.0 : 8.0;
    curves = {{turn, turn, {end - 1.0}, {end - 1.1}, {static_cast<double>(n)}}};
  }
  unsigned settle(double constant) { return settle_undetermined(model, curves, constant, ascending); }
  // J of the split in the middle, above the J of the model.
  [[nodiscard]] double gained() const { return samples * 0.1 * 0.1; }
};

}  // namespace

TEST_CASE("determined by hand: the middle is taken while J there is above the best by chance alone") {
  // 6 a parameter of J over degrees of freedom: 2 of 14 and 26 samples falling, 3 of 21 rising.
  for (const auto& [ascending, samples, share] :
       {std::tuple(false, 14, 12.0 / 12.0), std::tuple(false, 26, 12.0 / 24.0), std::tuple(true, 21, 18.0 / 18.0)}) {
    CAPTURE(ascending, samples);
    OneSlope chance(ascending, samples);
    CHECK(chance.settle(1.01 * chance.gained() / share) == (ascending ? 0b11100U : 0b11U));
    const ElamParameters& middle = chance.model.parameters;
    CHECK((ascending ? middle.beta_a : middle.beta_d) == Approx(0.5));
    CHECK((ascending ? middle.alpha_a0 : middle.alpha_d) == Approx(0.5));
    CHECK((ascending ? middle.alpha_a1 : 0.0) == Approx(0.0).margin(1e-12));

    OneSlope more(ascending, samples);
    const ElamParameters before = more.model.parameters;
    CHECK(more.settle(0.99 * more.gained() / share) == (ascending ? 0b11100U : 0b11U));
    const ElamParameters& near = more.model.parameters;
    if (ascending) {
      const double phi = near.alpha_a0 + 8.0 * near.alpha_a1;
      CHECK((1.0 - near.beta_a) / (1.0 - phi) == Approx(1.1).epsilon(1e-3));
      CHECK(near.beta_a > before.beta_a);
    } else {
      // The foot of the perpendicular from the middle on the line of one slope.
      const double way = (0.1 * 1.0 + 0.16 * 1.1) / (1.0 + 1.1 * 1.1);
      CHECK(near.alpha_d == Approx(0.4 + way).epsilon(1e-5));
      CHECK(near.beta_d == Approx(0.34 + 1.1 * way).epsilon(1e-5));
    }
  }
}

TEST_CASE("determined by hand: where J is 0 along a whole edge, the place next to the middle is taken") {
  // With beta 0 the piece below the split is flat, wherever the split lies above 2 psi: alpha is open, beta is not.
  ElamModel model{kStraight, kStraight, {0.9, 0.0, 0.0, 0.5, 0.5}, {}};
  const std::vector<CurveSamples> curves{{8, 8, {2}, {0}, {1}}};
  CHECK(settle_undetermined(model, curves, 0.0, false) == 0b1U);
  CHECK(model.parameters.alpha_d == Approx(0.5));
  CHECK(model.parameters.beta_d == 0.0);
}
