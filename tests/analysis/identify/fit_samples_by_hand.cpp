// What every identification is given, by hand: parts, scored samples, refusals; figures of a fit.
#include "analysis/identify/fit_samples.h"

#include <catch2/catch.hpp>
#include <limits>
#include <string>

#include "analysis/identify/sensor_model.h"
#include "tests/analysis/identify/refusals.h"

using namespace tactbench::analysis;

namespace {

FitData up_and_down() {
  const std::vector<double> x{0.0, 30.0, 60.0}, up{0.0, 1.0, 3.0}, down{0.0, 2.0, 3.0};
  FitData data;
  data.ascending = PatternCurve(x, up, 0.0, 3.0);
  data.descending = PatternCurve(x, down, 0.0, 3.0);
  data.histories = {{"loop", {-1.0, 30.0, 61.0, 30.0, 0.0}, {0.0, 1.0, 3.0, 2.0, 0.0}, {{0, 2, true}, {2, 4, false}}},
                    {"back", {60.0, 40.0, 20.0}, {3.0, 2.4, 1.5}, {{0, 2, false}}}};
  return data;
}

std::string samples_refused(const FitData& data, bool one_way = false) {
  return why_invalid([&] { return FitSamples(data, one_way); });
}

}  // namespace

TEST_CASE(
    "samples of a fit by hand: inputs within the loop, branches with their beginnings, all but first ones scored") {
  const FitSamples samples(up_and_down());
  CHECK((samples.x_low == 0.0 && samples.x_high == 60.0));
  CHECK(samples.x == std::vector<double>{0.0, 30.0, 60.0, 30.0, 0.0, 60.0, 40.0, 20.0});
  REQUIRE(samples.parts.size() == 3);
  const auto part = [&](std::size_t i) {
    const FitSamples::Part& own = samples.parts[i];
    return std::vector<std::size_t>{own.ascending ? 1U : 0U, own.opens_history ? 1U : 0U, own.from_top ? 1U : 0U,
                                    own.first, own.last};
  };
  CHECK(part(0) == std::vector<std::size_t>{1, 1, 0, 0, 2});
  CHECK(part(1) == std::vector<std::size_t>{0, 0, 0, 2, 4});
  CHECK(part(2) == std::vector<std::size_t>{0, 1, 1, 5, 7});
  CHECK(samples.scored == std::vector<std::size_t>{1, 2, 3, 4, 6, 7});
  CHECK(samples.fitted == samples.scored);
  CHECK(samples.outputs(up_and_down()) == std::vector<double>{0.0, 1.0, 3.0, 2.0, 0.0, 3.0, 2.4, 1.5});
}

TEST_CASE("samples of a fit by hand: what cannot be fitted is refused, each for its reason") {
  CHECK(samples_refused(up_and_down()).empty());
  const auto spoilt = [](const auto& change) {
    FitData data = up_and_down();
    change(data);
    return samples_refused(data);
  };
  const double none = std::numeric_limits<double>::quiet_NaN(), endless = std::numeric_limits<double>::infinity();
  for (const double bad : {none, endless, -endless}) {
    CHECK_THAT(spoilt([&](FitData& d) { d.histories[0].x[3] = bad; }), Catch::Contains("\"loop\""));
    CHECK_THAT(spoilt([&](FitData& d) { d.histories[1].y[2] = bad; }), Catch::Contains("\"back\""));
  }
  CHECK(spoilt([&](FitData& d) { d.histories[1].y[2] = std::numeric_limits<double>::max(); }).empty());
  CHECK_FALSE(spoilt([](FitData& d) { d.histories[0].y.pop_back(); }).empty());
  for (const auto& [first, last] : {std::pair{1, 4}, {3, 3}, {4, 2}, {2, 5}}) {
    INFO(first << " to " << last);
    CHECK_THAT(spoilt([&, from = first, to = last](FitData& d) {
                 d.histories[0].branches[1] = {from, to, false};
               }),
               Catch::Contains("\"loop\""));
  }
  CHECK(spoilt([](FitData& d) { d.histories[0].branches[1] = {3, 4, false}; }).empty());  // samples between two
  CHECK_FALSE(spoilt([](FitData& d) { d.ascending = {}; }).empty());
  CHECK_FALSE(spoilt([](FitData& d) { d.descending = {}; }).empty());
  const std::vector<double> x{0.0, 60.0}, y{0.0, 3.0};
  const auto other_curve = [&](std::vector<double> at, std::vector<double> out) {
    return spoilt([&](FitData& d) { d.descending = PatternCurve(at, out, out.front(), out.back()); });
  };
  CHECK(other_curve(x, y).empty());
  for (const auto& [at, out] : {std::pair{std::vector{1.0, 60.0}, y},
                                {std::vector{0.0, 59.0}, y},
                                {x, std::vector{0.1, 3.0}},
                                {x, std::vector{0.0, 2.9}}})
    CHECK_FALSE(other_curve(at, out).empty());
}

TEST_CASE("samples of a fit by hand: both directions are needed, or one where that is enough") {
  FitData data = up_and_down();
  data.histories.erase(data.histories.begin());
  CHECK_FALSE(samples_refused(data).empty());
  CHECK(samples_refused(data, true).empty());
  data.histories[0] = {"up", {0.0, 30.0}, {0.0, 1.0}, {{0, 1, true}}};
  CHECK_FALSE(samples_refused(data).empty());
  CHECK(samples_refused(data, true).empty());
  data.histories[0].branches.clear();
  CHECK_FALSE(samples_refused(data, true).empty());
}

TEST_CASE("samples of a fit by hand: outputs are taken of the same inputs and branches alone") {
  const FitSamples samples(up_and_down());
  const auto refused = [&](const auto& change) {
    FitData data = up_and_down();
    change(data);
    return why_invalid([&] { (void)samples.outputs(data); });
  };
  CHECK(refused([](FitData& d) { d.histories[0].y[1] = 7.0; }).empty());
  CHECK_FALSE(refused([](FitData& d) { d.histories.pop_back(); }).empty());
  CHECK_FALSE(refused([](FitData& d) { d.histories[1].x[2] = 20.5; }).empty());
  CHECK_FALSE(refused([](FitData& d) { d.histories[1].x.push_back(10.0); }).empty());
  CHECK_FALSE(refused([](FitData& d) { d.histories[0].branches[0].last = 1; }).empty());
  CHECK_FALSE(refused([](FitData& d) { d.histories[0].branches[1].first = 3; }).empty());
  CHECK_FALSE(refused([](FitData& d) { d.histories[1].branches[0].ascending = true; }).empty());
  const std::vector<double> wider{0.0, 30.0, 61.0}, lower{-1.0, 30.0, 60.0}, y{0.0, 1.0, 3.0};
  for (const std::vector<double>& x : {wider, lower})
    CHECK_FALSE(refused([&](FitData& d) {
                  d.ascending = PatternCurve(x, y, 0.0, 3.0);
                  d.descending = d.ascending;
                }).empty());
  const auto missing = Catch::Contains("\"back\"");
  CHECK_THAT(refused([](FitData& d) { d.histories[1].y.pop_back(); }), missing);
  CHECK_THAT(refused([](FitData& d) { d.histories[1].y[0] = std::numeric_limits<double>::quiet_NaN(); }), missing);
}

TEST_CASE("figures of a fit by hand: sum of squares, mean and largest error of any number of samples") {
  const FitData data = up_and_down();
  const std::vector<double> errors = {0.1, -0.2, 0.3, -0.4, 0.5, -0.6, 0.7, -0.8, 0.9};
  for (std::size_t n = 1; n <= errors.size(); ++n) {
    INFO(n);
    ModelFit fit;
    score(fit, data, std::span(errors).first(n));
    const auto count = static_cast<double>(n);
    CHECK(fit.j == Approx(0.01 * count * (count + 1.0) * (2.0 * count + 1.0) / 6.0));
    CHECK(fit.mean_error == Approx(0.1 * (count + 1.0) / 2.0));
    CHECK(fit.max_error == Approx(0.1 * count));
    CHECK((fit.samples == static_cast<int>(n) && fit.full_scale == 3.0));
  }
}
