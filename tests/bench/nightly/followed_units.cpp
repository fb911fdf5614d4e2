// Trends of figures in kPa and bar: which names are of pressures, what is multiplied, what stays.
#include "bench/nightly/subject_trend.h"

#include <catch2/catch.hpp>

using namespace tactbench;
using namespace tactbench::bench;
using analysis::PressureUnit;

namespace {

constexpr double kKpaOfPsi = 6.894757293168361;

SubjectTrend one_figure(const std::string& name) {
  SubjectTrend followed;
  followed.subject = "rig/psi";
  TrendFigure figure;
  figure.name = name;
  figure.values = {1.0, 2.0};
  figure.chart.band = analysis::ControlBand{1.5, 0.25, 1.0, 2.0, 8};
  figure.chart.level = 1.75;
  figure.chart.slope = 0.125;
  followed.figures = {figure};
  return followed;
}

}  // namespace

TEST_CASE("trend units: values, band, average, slope and name of a pressure are converted") {
  const TrendFigure kpa = in_unit(one_figure("mean_error_psi"), PressureUnit::kKilopascal).figures[0];
  CHECK(kpa.name == "mean_error_kpa");
  CHECK(kpa.values[1] == Approx(2.0 * kKpaOfPsi));
  CHECK(kpa.chart.band->mean == Approx(1.5 * kKpaOfPsi));
  CHECK(kpa.chart.band->low == Approx(kKpaOfPsi));
  CHECK(kpa.chart.band->high == Approx(2.0 * kKpaOfPsi));
  CHECK(kpa.chart.band->deviation == Approx(0.25 * kKpaOfPsi));
  CHECK(kpa.chart.level == Approx(1.75 * kKpaOfPsi));
  CHECK(*kpa.chart.slope == Approx(0.125 * kKpaOfPsi));
  CHECK(in_unit(one_figure("mean_error_psi"), PressureUnit::kKilopascal).subject == "rig/psi");
  SubjectTrend logarithmic = one_figure("max_error_psi");
  logarithmic.figures[0].chart.logarithmic = true;
  CHECK(in_unit(logarithmic, PressureUnit::kKilopascal).figures[0].chart.band->deviation == 0.25);
}

TEST_CASE("trend units: pressure rates and reciprocals of pressure are converted, other names are not") {
  const TrendFigure rate = in_unit(one_figure("hold_drift_psi_per_min"), PressureUnit::kBar).figures[0];
  CHECK(rate.name == "hold_drift_bar_per_min");
  CHECK(rate.values[0] == Approx(0.01 * kKpaOfPsi));
  const TrendFigure share = in_unit(one_figure("elam_alpha_a1_per_psi"), PressureUnit::kKilopascal).figures[0];
  CHECK(share.name == "elam_alpha_a1_per_kpa");
  CHECK(share.values[1] == Approx(2.0 / kKpaOfPsi));
  for (const char* other : {"dead_taxels", "psilon", "epsi_v", "full_scale_v"}) {
    const TrendFigure same = in_unit(one_figure(other), PressureUnit::kKilopascal).figures[0];
    CHECK((same.name == other && same.values[1] == 2.0 && same.chart.level == 1.75));
  }
  const TrendFigure psi = in_unit(one_figure("mean_error_psi"), PressureUnit::kPsi).figures[0];
  CHECK((psi.name == "mean_error_psi" && psi.values[1] == 2.0));
}
