// Control bands and slopes against published and exactly computed values, and the promised rate of false alarms.
#include "analysis/statistics/control/control_band.h"

#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "analysis/statistics/numbers/student.h"

using namespace tactbench::analysis;

TEST_CASE("Student quantiles are those of the tables") {
  CHECK(student_quantile(0.975, 10.0) == Approx(2.228139).epsilon(1e-6));
  CHECK(student_quantile(0.995, 1.0) == Approx(63.65674).epsilon(1e-6));
  CHECK(student_quantile(0.025, 4.0) == Approx(-2.776445).epsilon(1e-6));
  CHECK(student_quantile(0.975, std::numeric_limits<double>::infinity()) == Approx(1.959964).epsilon(1e-6));
  CHECK(std::isnan(student_quantile(1.0, 4.0)));
  CHECK(std::isnan(student_quantile(0.5, 0.0)));
  CHECK(student_two_sided(-2.228139, 10.0) == Approx(0.05).epsilon(1e-6));
  CHECK(student_two_sided(1.959964, std::numeric_limits<double>::infinity()) == Approx(0.05).epsilon(1e-6));
  CHECK(student_two_sided(std::numeric_limits<double>::infinity(), 3.0) == 0.0);
  CHECK(std::isnan(student_two_sided(1.0, 0.0)));
  // Of one degree of freedom, Cauchy's distribution: 1/2 beyond 1, and the quantile at 3/4 is 1.
  CHECK(student_two_sided(1.0, 1.0) == Approx(0.5));
  CHECK(student_quantile(0.75, 1.0) == Approx(1.0));
  // Of a half and 1e300 degrees of freedom there are some, too, and none of -1 or of no t.
  CHECK(student_two_sided(0.0, 0.5) == 1.0);
  CHECK(student_quantile(0.5, 0.5) == Approx(0.0).margin(1e-12));
  CHECK(std::isnan(student_two_sided(1.0, -1.0)));
  CHECK(std::isnan(student_two_sided(std::nan(""), 3.0)));
  CHECK(std::isnan(student_quantile(0.0, 4.0)));
}

TEST_CASE("a control band is the prediction interval of a normal sample") {
  const auto band = control_band(std::array{1.0, 2.0, 3.0, 4.0, 5.0}, 0.05);
  REQUIRE(band);
  CHECK(band->mean == 3.0);
  CHECK(band->deviation == Approx(1.5811388));
  CHECK(band->high == Approx(3.0 + 2.776445 * 1.5811388 * std::sqrt(1.2)));
  CHECK(control_band(std::array{1.0, 2.0, 3.0}, 0.01)->high == Approx(2.0 + 9.924843 * std::sqrt(4.0 / 3.0)));
  CHECK((band->holds(band->low) && !band->holds(band->low - 1e-6)));
  CHECK_FALSE(control_band(std::array{1.0, 2.0}, 0.05));
  CHECK_FALSE(control_band(std::array{1.0, 2.0, std::nan("")}, 0.05));
  const auto alike = control_band(std::array{7.0, 7.0, 7.0}, 0.05);
  REQUIRE(alike);
  CHECK((alike->holds(7.0 + 1e-9) && !alike->holds(7.0 + 1e-7)));
}

TEST_CASE("values from the baseline's distribution fall outside at the stated rate") {
  std::mt19937 random(11);
  std::normal_distribution<double> normal(3.0, 0.2);
  int outside = 0;
  constexpr int kTrials = 20000;
  for (int i = 0; i < kTrials; ++i) {
    std::array<double, 8> values{};
    for (double& value : values) value = normal(random);
    outside += control_band(values, 0.02)->holds(normal(random)) ? 0 : 1;
  }
  CHECK(outside / double(kTrials) == Approx(0.02).margin(0.004));  // four standard errors
}

TEST_CASE("the Theil-Sen slope is the median of the slopes between any two values") {
  CHECK(theil_sen_slope(std::array{1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0}) == 1.0);
  CHECK(theil_sen_slope(std::array{4.0, 3.0, 2.0, 1.0}) == -1.0);
  CHECK(*theil_sen_slope(std::array{1.0, 4.0, 2.0, 3.0}) == Approx(7.0 / 12.0));  // -2, -0.5, 0.5, 2/3, 1, 3
  CHECK(theil_sen_slope(std::vector<double>(9, 4.0)) == 0.0);
  CHECK_FALSE(theil_sen_slope(std::array{1.0, 2.0, 3.0}));
  CHECK_FALSE(theil_sen_slope(std::array{1.0, 2.0, 3.0, std::nan("")}));
}
