// The samples of a search: J is merged exactly, and long data are thinned independently of their period.
#include "analysis/identify/elam/elam_samples.h"

#include <catch2/catch.hpp>

#include "tests/analysis/support/synthetic.h"

using namespace synthetic;

TEST_CASE("ELAM samples: those at one point of one curve are merged without changing J") {
  const ElamModel model = model_of(paper_loop(), kPrinted);
  std::vector<TaxelBranch> branches{{false, {60, 40, 20, 0}, {3.49, 3.1, 2.4, 0.1}},
                                    {false, {60, 20, 40, 0}, {3.48, 2.2, 3.3, 0.0}},  // external: the same curve
                                    {false, {50, 40, 20, 0}, {3.40, 3.0, 2.1, 0.2}},
                                    {true, {0, 20, 60}, {0.0, 1.0, 3.4}}};
  const ElamSamples samples = collect_samples(model, branches);
  REQUIRE(samples.descending.size() == 2);
  REQUIRE(samples.ascending.size() == 1);
  CHECK(samples.descending[0].x == std::vector<double>{0, 20, 40});
  CHECK(samples.descending[0].weight == std::vector<double>{2, 2, 2});
  CHECK(samples.descending[1].weight == std::vector<double>{1, 1, 1});
  double plain = 0.0, distinguished_cost = samples.descending_constant;
  for (const TaxelBranch& branch : branches) {
    if (branch.ascending) continue;
    for (std::size_t i = 1; i < branch.volts.size(); ++i) plain += std::pow(2.0 - branch.volts[i], 2);
  }
  for (const CurveSamples& curve : samples.descending)
    for (std::size_t i = 0; i < curve.x.size(); ++i)
      distinguished_cost += curve.weight[i] * std::pow(2.0 - curve.y[i], 2);
  CHECK(distinguished_cost == Approx(plain).epsilon(1e-12));
}

TEST_CASE("thinning: keeps the requested share of samples, for any period of the data") {
  std::vector<CurveSamples> curves;
  for (int c = 0; c < 1000; ++c) {
    CurveSamples& curve = curves.emplace_back();
    for (int i = 0; i < 100; ++i) {
      curve.x.push_back(i);
      curve.y.push_back(c);
      curve.weight.push_back(1.0 + i);
    }
  }
  std::vector<CurveSamples> whole = curves;
  thin(whole, 100000);
  CHECK(whole.size() == 1000);
  CHECK(whole.back().x.size() == 100);
  thin(curves, 5000);
  std::size_t count = 0;
  double sum = 0.0, least = 100.0;
  for (const CurveSamples& curve : curves) {
    REQUIRE(curve.weight.size() == curve.x.size());
    count += curve.x.size();
    least = std::min(least, static_cast<double>(curve.x.size()));
    for (std::size_t i = 0; i < curve.x.size(); ++i) {
      sum += curve.x[i];
      CHECK(curve.weight[i] == 1.0 + curve.x[i]);
    }
  }
  CHECK(std::abs(static_cast<double>(count) - 5000.0) < 5.0);
  CHECK(least >= 4.0);  // 5 of each 100
  CHECK(sum / static_cast<double>(count) == Approx(49.5).margin(0.5));
}
