// GPI's fits are no worse than another search's, and name what the data leave open. Sanitizers would take minutes.
#include <catch2/catch.hpp>
#include <cmath>

#include "analysis/identify/fit_models.h"
#include "analysis/identify/rivals/gpi_search.h"
#include "tests/analysis/identify/rivals/gpi_walked.h"
#include "tests/analysis/support/gpi_reference.h"
#include "tests/analysis/support/specimen_taxels.h"

using namespace synthetic;

namespace {

// The right envelope e times as bent, its ends where they were.
GpiParameters more_bent(GpiParameters p, double x_span) {
  const double bend = std::exp(1.0) * p.b1;
  const double b0 = p.b0 * std::expm1(-p.b1 * x_span) / std::expm1(-bend * x_span);
  p.b3 += b0 - p.b0;
  p.b0 = b0;
  p.b1 = bend;
  return p;
}

GpiParameters parameters_of(const ModelFit& fit) {
  const std::vector<ModelParameter> p = fit.model->parameters();
  return {p.at(0).value, p.at(1).value, p.at(2).value, p.at(3).value, p.at(4).value, p.at(5).value,
          p.at(6).value, p.at(7).value, p.at(8).value, p.at(9).value, p.at(10).value};
}

}  // namespace

TEST_CASE("GPI: fits of two taxels are no worse than an independent search, and name what is undetermined") {
  const std::vector<FitData> taxels = specimen_taxels(7112, 2, 0.0005);
  const auto prepared = prepare("gpi", taxels.front());
  for (const FitData& data : taxels) {
    const ModelFit fit = prepared->fit(data);
    CHECK(fit.j <= GpiReference(data).least(16, 1) * (1.0 + 1e-6));
    // The first one's right envelope is as straight as the search lets it be, and its bend may as well be e times that.
    if (&data != &taxels.front()) {
      CHECK(fit.undetermined.empty());
      continue;
    }
    CHECK(fit.undetermined == std::vector<std::string>{"b1"});
    const GpiParameters found = parameters_of(fit);
    CHECK(found.b1 == Approx(1e-3 / 60.0));
    const double j = walked_j(found, data), samples = static_cast<double>(FitSamples(data).fitted.size());
    CHECK(j == Approx(fit.j));
    CHECK(walked_j(more_bent(found, 60.0), data) - j < j / (samples - 8.0));
  }
}
