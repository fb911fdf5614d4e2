// Taxels of a table whose inputs differ are fitted each by its own, and their mean where they are one.
#include <catch2/catch.hpp>
#include <cmath>

#include "analysis/identify/histories.h"
#include "analysis/identify/sensor_model.h"

using namespace tactbench::analysis;

namespace {

// A loop with one inner turn at `turn`: up x^2 / 100, down further above it by what was turned from.
TableSeries inner_loop(int taxel, double turn, double gain) {
  TableSeries series{"a", taxel, {}, {}};
  const std::vector<double> turns{0, 10, turn, 10, 0};
  double x = 0.0;
  for (std::size_t i = 0; i < turns.size(); ++i)
    for (bool first = true; first || x != turns[i]; first = false) {
      if (x != turns[i]) x += turns[i] > x ? 1.0 : -1.0;
      const bool up = i == 0 || turns[i] > turns[i - 1];
      series.input.push_back(x);
      series.output.push_back(gain * (x + (up ? 0.0 : 0.1 * x * (10.0 - x) / 10.0)));
    }
  return series;
}

}  // namespace

TEST_CASE("fits of a table: taxels of one external loop whose inner inputs differ are each fitted to its own") {
  HistoriesOptions options;
  options.turn = 0.5;
  options.noise = 0.0;
  const auto fitted = [&](const std::string& model, double other_turn) {
    const Histories histories = histories_of({inner_loop(0, 4.0, 1.0), inner_loop(1, other_turn, 2.0)}, "t", options);
    return fit_models(model, histories, {}, {}, 1);
  };
  for (const std::string model : {"poly", "preisach", "mpi", "monotone"}) {
    CAPTURE(model);
    const SensorModel unlike = fitted(model, 6.0), alike = fitted(model, 4.0);
    REQUIRE(unlike.taxels.size() == 2);  // no mean of inputs that differ
    REQUIRE(alike.taxels.size() == 3);
    for (const std::size_t i : {0U, 1U}) {
      CHECK(unlike.taxels[i].reason.empty());
      CHECK(unlike.taxels[i].fitted());
      CHECK(alike.taxels[i].fitted());
    }
    CHECK(alike.taxels[2].taxel == kMeanTaxel);
    CHECK(alike.taxels[2].fit.full_scale == Approx(15.0));
    // The first taxel's fit does not depend on the second's.
    CHECK(unlike.taxels[0].fit.j == Approx(alike.taxels[0].fit.j).epsilon(1e-9).margin(1e-12));
    CHECK(unlike.taxels[1].fit.samples == alike.taxels[1].fit.samples - 4);
  }
}
