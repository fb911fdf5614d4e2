// The hash of a report's models: every number of them counts.
#include <catch2/catch.hpp>
#include <functional>
#include <memory>
#include <set>
#include <string>

#include "analysis/report/report_facts.h"
#include "tests/analysis/support/specimen_taxels.h"

using namespace tactbench;
using namespace tactbench::analysis;

namespace {

ModelTaxel small_taxel(double of) {
  const std::vector<double> x = {0.0, 30.0, 60.0}, up = {0.0, 0.5 * of, 2.0 * of}, down = {0.0, 1.5 * of, 2.0 * of};
  ModelTaxel taxel = by_hand::elam_taxel(PatternCurve(x, up, 0.0, 2.0 * of), PatternCurve(x, down, 0.0, 2.0 * of),
                                         {0.5, 0.25, -0.125, 0.75, 0.0625});
  taxel.fit.at_bound = 5;
  taxel.fit.j = 0.1;
  taxel.fit.mean_error = 0.2;
  taxel.fit.max_error = 0.3;
  taxel.noise = 0.001;
  return taxel;
}

SensorModel small_model() {
  SensorModel fit;
  fit.model = "elam";
  fit.rows = 1;
  fit.columns = 2;
  fit.pressure_psi = {0.0, 30.0, 60.0};
  fit.taxels = {small_taxel(1.0), by_hand::left_out(TaxelStatus::kDead)};
  by_hand::finish(fit, small_taxel(0.5));
  return fit;
}

}  // namespace

TEST_CASE("model hash: depends on every parameter, pattern, status and dynamic value, and not on a rerun") {
  const SensorModel fit = small_model();
  const std::string hash = model_sha256(fit);
  CHECK(hash.size() == 64);
  CHECK(model_sha256(small_model()) == hash);
  std::set<std::string> hashes = {hash};
  const auto changed = [&](const std::function<void(SensorModel&)>& change) {
    SensorModel other = fit;
    change(other);
    hashes.insert(model_sha256(other));
  };
  for (double ElamParameters::*parameter :
       {&ElamParameters::alpha_d, &ElamParameters::beta_d, &ElamParameters::alpha_a1, &ElamParameters::alpha_a0,
        &ElamParameters::beta_a})
    for (const std::size_t taxel : {0U, 2U})
      changed([&](SensorModel& other) {
        ElamModel elam = *elam_of(other.taxels[taxel]);
        elam.parameters.*parameter += 1e-9;
        other.taxels[taxel].fit.model = std::make_shared<ElamHysteresis>(std::move(elam));
      });
  CHECK(hashes.size() == 11);
  changed([](SensorModel& other) { other.taxels[1].status = TaxelStatus::kStuck; });
  changed([](SensorModel& other) { other.pressure_psi[1] += 1e-9; });
  const std::vector<double> x = {0.0, 30.0, 60.0}, y = {0.0, 0.75, 2.0};
  changed([&](SensorModel& other) { other.taxels[0].ascending = PatternCurve(x, y, 0.0, 2.0); });
  changed([&](SensorModel& other) { other.taxels[0].descending = PatternCurve(x, y, 0.0, 2.0); });
  changed([](SensorModel& other) { std::swap(other.taxels[0], other.taxels[1]); });
  CHECK(hashes.size() == 16);
  // Of models without dynamics a taxel's dynamic numbers are none; with them each counts.
  changed([](SensorModel& other) { other.taxels[0].creep_scale = 2.0; });
  CHECK(hashes.size() == 16);
  const auto dynamic = [&](const std::function<void(SensorModel&)>& change) {
    changed([&](SensorModel& other) {
      other.dynamics.emplace();
      other.dynamics->residual_shape = {1.0, 2.0};
      change(other);
    });
  };
  dynamic([](SensorModel&) {});
  dynamic([](SensorModel& other) { other.taxels[0].creep_scale = 2.0; });
  dynamic([](SensorModel& other) { other.taxels[0].lag_share = 0.5; });
  dynamic([](SensorModel& other) { other.taxels[0].residual_psi = 0.5; });
  dynamic([](SensorModel& other) { other.dynamics->shared.creep_s[1] = 7.0; });
  dynamic([](SensorModel& other) { other.dynamics->shared.creep_share[1] = 0.5; });
  dynamic([](SensorModel& other) { other.dynamics->shared.creep_half = 7.0; });
  dynamic([](SensorModel& other) { other.dynamics->shared.lag_s = 7.0; });
  dynamic([](SensorModel& other) { other.dynamics->shared.lag_share = 0.5; });
  dynamic([](SensorModel& other) { other.dynamics->residual_shape[1] = 7.0; });
  CHECK(hashes.size() == 26);
}
