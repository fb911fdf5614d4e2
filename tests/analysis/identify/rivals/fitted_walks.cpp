// A fit's errors are those of its own model along the data, also where branches begin at, near or beside the ends.
#include <catch2/catch.hpp>
#include <cmath>
#include <string>
#include <vector>

#include "analysis/identify/identifier.h"
#include "tests/analysis/support/fit_samples.h"

using namespace synthetic;

namespace {

// Over 0 to 10; outputs bend, and lie higher on the way down.
FitData bent_samples(const std::vector<double>& x, std::vector<Branch> branches) {
  const std::vector<double> ends{0, 5, 10}, up{0, 2, 6}, down{0, 4, 6};
  std::vector<double> y{0.06 * x.front() * x.front()};
  for (std::size_t i = 1; i < x.size(); ++i)
    y.push_back(0.06 * x[i] * x[i] +
                (x[i] < x[i - 1] ? 0.1 * x[i] * (10.0 - x[i]) : 0.02 * static_cast<double>(i % 3)));
  return {{{"bent", x, y, std::move(branches), {}, {}}},
          PatternCurve(ends, up, 0.0, 6.0),
          PatternCurve(ends, down, 0.0, 6.0)};
}
FitData bent_samples(const std::vector<double>& x) { return bent_samples(x, branches_along(x)); }

void check_errors(const std::string& model, const FitData& data, bool free_run) {
  IdentifyOptions options;
  options.free_run = free_run;
  options.cells = 5;
  const ModelFit fit = identify(model, data, options);
  CAPTURE(model, free_run);
  double squares = 0.0, sum = 0.0, most = 0.0;
  int samples = 0;
  for (const History& history : data.histories) {
    const std::vector<double> there = predict_history(*fit.model, history, free_run);
    for (const Branch& branch : history.branches)
      for (int i = branch.first + 1; i <= branch.last; ++i, ++samples) {
        const double off = std::abs(there[static_cast<std::size_t>(i)] - history.y[static_cast<std::size_t>(i)]);
        squares += off * off;
        sum += off;
        most = std::max(most, off);
      }
  }
  CHECK(fit.samples == samples);
  CHECK(fit.j == Approx(squares).epsilon(1e-9).margin(1e-12));
  CHECK(fit.mean_error == Approx(sum / samples).epsilon(1e-9).margin(1e-12));
  CHECK(fit.max_error == Approx(most).epsilon(1e-9).margin(1e-12));
}

}  // namespace

TEST_CASE("a fit's errors are those of its model along branches of every kind") {
  const std::vector<std::vector<double>> ways{
      {0, 2, 4, 6, 8, 10, 8, 6, 4, 2, 0},                   // external ones alone
      {0, 3, 6, 10, 8, 4, 7, 10, 6, 3, 5, 8, 2, 0},         // inner ones
      {0, 3, 7, 10, 7, 3, 0.05, 3, 7, 9.95, 6, 2, 0},       // all but from the ends
      {0, 3, 7, 10, 9.95, 10, 7, 3, 0.05, 0, 4, 8, 10, 0},  // short ways at the ends, against their direction
      {0, 0.05, 0, 3, 7, 10, 6, 2, 0},
      {0, 3, 7, 9.95, 9.98, 9.9, 10, 6, 2, 0.02, 0.06, 0},
  };
  for (const auto& way : ways)
    for (const char* model : {"poly", "preisach", "mpi", "monotone"})
      for (const bool free_run : {false, true}) {
        CAPTURE(way);
        check_errors(model, bent_samples(way), free_run);
      }
}

TEST_CASE("a fit's errors are those of its model where a rise begins at the highest input") {
  const std::vector<double> way{0, 4, 10, 10, 7, 3, 0};
  const FitData data = bent_samples(way, {{0, 2, true}, {2, 3, true}, {3, 6, false}});
  for (const char* model : {"poly", "preisach", "mpi", "monotone"}) check_errors(model, data, false);
}
