// Fitted models of every kind: figures, verdicts, frames and storage for every model that can be inverted.
#include "analysis/identify/sensor_model.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "tests/analysis/support/synthetic.h"

using namespace synthetic;

namespace {

Dataset array_run(unsigned seed) {
  ArrayOptions options;
  options.rows = 1;
  options.columns = 2;
  RunOptions how;
  how.seed = seed;
  return run(Array(options), how);
}

FitOptions by(const std::string& model) {
  FitOptions options;
  options.model = model;
  options.identify.starts = 2;
  return options;
}

}  // namespace

TEST_CASE("every model has figures on a held-out run") {
  const Dataset fitted = array_run(1), held_out = array_run(2);
  double monotone = 0.0;
  for (const std::string model : {"monotone", "elam", "gpi", "mpi", "preisach", "poly"}) {
    INFO(model);
    const SensorModel fit = fit_array(fitted, by(model));
    REQUIRE(fit.fitted().size() == 2);
    const Evaluation e = evaluate(held_out, fit);
    CHECK(e.excluded_taxels == 0);
    CHECK((std::isfinite(e.mean_error_psi) && e.mean_error_psi > 0.0));
    CHECK(e.traces.size() == held_out.sequences.size());
    if (model == "monotone") monotone = e.mean_error_psi;
    if (model == "elam" || model == "gpi") CHECK(e.mean_error_psi < monotone);
  }
}
