// A sensor whose outputs begin at another voltage: each model fits and predicts the same, that much higher.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <string>

#include "analysis/identify/identifier.h"
#include "tests/analysis/support/fit_samples.h"

using namespace synthetic;

TEST_CASE("an offset of all outputs moves what each model predicts by itself, and changes no error") {
  const FitData data = paper_both(0.03, 0.02);
  for (const double offset : {0.7, -1.9}) {
    const auto moved = [&](std::vector<double> y) {
      for (double& value : y) value += offset;
      return y;
    };
    const auto pattern = [&](const PatternCurve& p) {
      const std::vector<double> x(p.x().begin(), p.x().end()), y = moved({p.y().begin(), p.y().end()});
      return PatternCurve(x, y, y.front(), y.back());
    };
    FitData higher{data.histories, pattern(data.ascending), pattern(data.descending)};
    for (History& history : higher.histories) history.y = moved(history.y);
    for (const char* name : {"elam", "gpi", "mpi", "poly", "preisach", "monotone"}) {
      CAPTURE(name, offset);
      const ModelFit own = identify(name, data, {.starts = 1}), other = identify(name, higher, {.starts = 1});
      CHECK(other.j == Approx(own.j).epsilon(1e-5));
      CHECK(other.full_scale == Approx(own.full_scale));
      CHECK(other.mean_error == Approx(own.mean_error).epsilon(1e-4));
      const std::vector<double> expected = moved(predict(*own.model, data.histories[0].x));
      const std::vector<double> found = predict(*other.model, data.histories[0].x);
      double off = 0.0;
      for (std::size_t i = 0; i < found.size(); ++i) off = std::max(off, std::abs(found[i] - expected[i]));
      CHECK(off < 1e-4);
      if (std::string(name) != "poly") continue;
      // a0 to a6, b0 to b6: polynomials from the lower end of the loop to the upper one.
      for (const std::size_t first : {0U, 7U}) {
        const std::vector<ModelParameter> p = other.model->parameters();
        double top = 0.0;
        for (std::size_t i = 0; i <= 6; ++i) top += p[first + i].value * std::pow(60.0, 6.0 - static_cast<double>(i));
        CHECK(p[first + 6].value == Approx(higher.ascending.y().front()));
        CHECK(top == Approx(higher.ascending.y().back()));
      }
    }
  }
}
