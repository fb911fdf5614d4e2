// What a model leaves by level, by hand, and when a recording begins at rest.
#include <catch2/catch.hpp>
#include <cmath>
#include <tuple>

#include "analysis/compensate/residual_bins.h"
#include "analysis/identify/residuals.h"
#include "analysis/identify/streams/recording_stream.h"
#include "tests/analysis/support/sensor_models.h"

using namespace tactbench::analysis;

namespace {

// Up 0.5 V in the lower half and 2.5 V in the upper; down 2.9 V in the lowest quarter and 0.1 V above it.
ModelTaxel steep_and_flat(double noise) {
  const std::vector<double> x{0.0, 15.0, 30.0, 60.0}, up{0.0, 0.25, 0.5, 3.0}, down{0.0, 2.9, 2.9 + 0.1 / 3.0, 3.0};
  ModelTaxel taxel =
      by_hand::elam_taxel(PatternCurve(x, up, 0.0, 3.0), PatternCurve(x, down, 0.0, 3.0), {0.5, 0.5, 0.0, 0.5, 0.5});
  taxel.noise = noise;
  return taxel;
}

}  // namespace

TEST_CASE("residual by level by hand: the mean slope over the level's own, from a half to twelve") {
  ModelTaxel taxel = steep_and_flat(0.0);
  CHECK(residual_by_level(taxel).empty());
  taxel.residual_psi = 0.5;
  const std::vector<double> psi = residual_by_level(taxel);
  REQUIRE(psi.size() == 40);
  // Over the whole range a level would rise by 0.15 V. Rising: 0.05 V in each of ten levels, then 0.25 V.
  for (std::size_t k = 0; k < 10; ++k) CHECK(psi[k] == Approx(0.5 * 3.0));
  for (std::size_t k = 10; k < 20; ++k) CHECK(psi[k] == Approx(0.5 * 0.6));
  // Falling: 0.58 V are nearly four times as steep, 0.0067 V more than twelve times as flat.
  for (std::size_t k = 20; k < 25; ++k) CHECK(psi[k] == Approx(0.5 * 0.5));
  for (std::size_t k = 25; k < 40; ++k) CHECK(psi[k] == Approx(0.5 * 12.0));
  taxel.residual_psi = -1.0;
  CHECK(residual_by_level(taxel).empty());
  taxel.residual_psi = 0.5;
  taxel.ascending = {};
  CHECK(residual_by_level(taxel).empty());
}

TEST_CASE("residual by level by hand: each level from its lower end, the last to the top, both ways") {
  const std::vector<double> psi{1, 2, 3, 4, 5, 6, 7, 8};
  const ResidualBins bins{-10.0, 30.0, psi};
  for (const auto& [x, up, down] : {std::tuple{-20.0, 1.0, 5.0},
                                    {-10.0, 1.0, 5.0},
                                    {-0.1, 1.0, 5.0},
                                    {0.0, 2.0, 6.0},
                                    {10.0, 3.0, 7.0},
                                    {20.0, 4.0, 8.0},
                                    {30.0, 4.0, 8.0},
                                    {50.0, 4.0, 8.0}}) {
    INFO(x);
    CHECK(bins.at(x, true) == up);
    CHECK(bins.at(x, false) == down);
  }
  CHECK(ResidualBins{}.at(1.0, true) == 0.0);
}

TEST_CASE("a recording begins at rest within a hundredth of the span, or six noises, of the lowest output") {
  SensorModel model;
  const ModelTaxel quiet = steep_and_flat(0.0), noisy = steep_and_flat(0.01);
  const RecordingStream still(model, quiet), moved(model, noisy);
  for (const double output : {-1.0, 0.0, 0.0299}) CHECK(still.at_rest(output));
  CHECK_FALSE(still.at_rest(0.0301));
  CHECK(moved.at_rest(0.0599));
  CHECK_FALSE(moved.at_rest(0.0601));
  ModelTaxel adjusted = quiet;  // since the fit: twice the output, from 0.5 V on
  adjusted.zero = 0.5;
  adjusted.gain = 2.0;
  const RecordingStream later(model, adjusted);
  CHECK(later.at_rest(0.559));
  CHECK_FALSE(later.at_rest(0.561));
  // Twice as noisy a recording has twice the band.
  const RecordingStream rough(model, noisy, 2.0);
  CHECK(rough.at_rest(0.119));
  CHECK_FALSE(rough.at_rest(0.121));
}
