#include <catch2/catch.hpp>
#include <random>

#include "analysis/identify/elam/elam.h"
#include "analysis/identify/sensor_model.h"
#include "tests/analysis/support/fit_samples.h"

using namespace synthetic;

namespace {

// The branches along each way of turning points as the model's formulas give them.
std::vector<TaxelBranch> branches_from(const ElamModel& model, const std::vector<std::vector<double>>& ways) {
  FitData data;
  for (const std::vector<double>& turns : ways) data.histories.push_back(drive("way", levels_of(turns), Plant(model)));
  return elam_branches_of(data);
}

bool same(const ModelTaxel& a, const ModelTaxel& b) {
  const ElamParameters &p = elam_of(a)->parameters, &q = elam_of(b)->parameters;
  return a.status == b.status && p.alpha_d == q.alpha_d && p.beta_d == q.beta_d && p.alpha_a0 == q.alpha_a0 &&
         p.alpha_a1 == q.alpha_a1 && p.beta_a == q.beta_a && a.fit.j == b.fit.j && a.fit.max_error == b.fit.max_error;
}

Array small_array() { return Array({.rows = 4, .columns = 4}); }

}  // namespace

TEST_CASE("identify_elam: noiseless data of the paper's taxel return the printed parameters") {
  const ElamModel truth = model_of(paper_loop(), kPrinted);
  const auto branches = branches_from(truth, {kDescendingTurns, kAscendingTurns});
  const ElamFit fit = identify_elam(truth.ascending, truth.descending, branches);
  INFO("J " << fit.j_v2);
  CHECK(fit.j_v2 < 1e-9);
  CHECK(fit.model.parameters.alpha_d == Approx(kPrinted.alpha_d).epsilon(1e-3));
  CHECK(fit.model.parameters.beta_d == Approx(kPrinted.beta_d).epsilon(1e-4));
  CHECK(fit.model.parameters.alpha_a1 == Approx(kPrinted.alpha_a1).epsilon(1e-3));
  CHECK(fit.model.parameters.alpha_a0 == Approx(kPrinted.alpha_a0).epsilon(1e-3));
  CHECK(fit.model.parameters.beta_a == Approx(kPrinted.beta_a).epsilon(1e-3));
  CHECK(fit.at_bound == 0);
  CHECK(fit.full_scale_v == 3.49);
}

TEST_CASE("fit_array: the result does not depend on the number of threads") {
  const Dataset data = run(small_array(), {});
  const SensorModel one = fit_array(data, fit_by("elam", {}, 1));
  for (const int threads : {2, 5}) {
    const SensorModel other = fit_array(data, fit_by("elam", {}, threads));
    for (std::size_t i = 0; i < one.taxels.size(); ++i) CHECK(same(one.taxels[i], other.taxels[i]));
    CHECK(same(one.mean_taxel(), other.mean_taxel()));
  }
  for (const ModelTaxel& taxel : one.array()) {
    CHECK(taxel.status == TaxelStatus::kFitted);
    CHECK(taxel.fit.mean_error < 0.005 * taxel.full_scale());
  }
  CHECK(one.pressure_psi.size() == 31);
  CHECK(one.sensor_serial == "S1");
  CHECK(one.mean_taxel().noise == Approx(data.noise_v[0] / 4.0));
}

TEST_CASE("fit_array: dead, stuck, saturated and unfit taxels are marked and left out of the mean") {
  Dataset data = run(small_array(), {});
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  const std::size_t width = 16;
  for (SequenceData& sequence : data.sequences) {
    for (Repeat& repeat : sequence.repeats) {
      for (std::size_t i = 0; i < repeat.steps.size(); ++i) {
        double* volts = &repeat.volts[i * width];
        volts[0] = 0.001 * normal(random);
        volts[1] = 2.0 + 0.001 * normal(random);
        volts[3] = 3.0 - 0.04 * repeat.steps[i].reference_psi;  // falls
        volts[4] = volts[4] + 1.5 * normal(random);             // noise beyond any model
        volts[5] = 5.0;                                         // at the converter's limit for ever
      }
    }
  }
  data.at_limit[2] = true;
  data.at_limit[5] = true;
  const SensorModel fit = fit_array(data);
  using enum TaxelStatus;
  const std::vector<TaxelStatus> marked{kDead, kStuck, kSaturated, kUnfit, kUnfit, kSaturated};
  for (std::size_t i = 0; i < width; ++i) CHECK(fit.taxels[i].status == (i < marked.size() ? marked[i] : kFitted));
  double mean = 0.0;
  for (std::size_t i = 6; i < width; ++i) mean += fit.taxels[i].ascending(30.0) / 10.0;
  CHECK(fit.mean_taxel().ascending(30.0) == Approx(mean).epsilon(1e-9));
}

TEST_CASE("fit_array: a first repeat that differs from the others is reported, and can be left out") {
  Dataset data = run(small_array(), {});
  for (double& volts : data.sequences[0].repeats[0].volts) volts -= 0.02;  // never loaded before
  const SensorModel fit = fit_array(data);
  REQUIRE(fit.repeats.size() == 2);
  CHECK(fit.repeats[0].sequence == "descending");
  CHECK(fit.repeats[0].differs);
  CHECK(fit.repeats[0].shift_v == Approx(-0.02).margin(0.002));
  CHECK_FALSE(fit.repeats[1].differs);
  FitOptions options;
  options.common.first_repeat = 1;
  CHECK(fit_array(data, options).mean_taxel().y0() > fit.mean_taxel().y0());
}

TEST_CASE("identify_elam: duplicate pressures, missing or short branches and an offset origin are fitted") {
  // From (12 psi, 0.7 V) on: held levels, turns that only go half way, no branch from 50 psi.
  Loop loop = paper_loop();
  for (double& x : loop.x) x += 12.0;
  for (double& y : loop.up) y += 0.7;
  for (double& y : loop.down) y += 0.7;
  ElamParameters p = kPrinted;
  p.beta_d = 0.97;
  const ElamModel truth = model_of(loop, p);
  std::vector<TaxelBranch> branches =
      branches_from(truth, {{12, 72, 12, 52, 31, 45, 12}, {12, 72, 22, 72, 12, 42, 30, 66, 33, 72, 12}});
  for (TaxelBranch& branch : branches) {
    const std::size_t middle = branch.volts.size() / 2;
    for (int k = 0; k < 3; ++k) {
      branch.volts.insert(branch.volts.begin() + static_cast<std::ptrdiff_t>(middle), branch.volts[middle]);
      branch.pressure_psi.insert(branch.pressure_psi.begin() + static_cast<std::ptrdiff_t>(middle),
                                 branch.pressure_psi[middle]);
    }
  }
  const ElamFit fit = identify_elam(truth.ascending, truth.descending, branches);
  CHECK(fit.j_v2 < 1e-9);
  CHECK(fit.model.parameters.alpha_d == Approx(p.alpha_d).epsilon(1e-3));
  CHECK(fit.model.parameters.beta_d == Approx(p.beta_d).epsilon(1e-4));
  CHECK(fit.model.parameters.alpha_a1 == Approx(p.alpha_a1).epsilon(1e-2));
  CHECK(fit.model.parameters.beta_a == Approx(p.beta_a).epsilon(1e-2));
}

TEST_CASE("fit_array: fits at the measured pressures and on the set-point grid agree") {
  const Dataset data = run(small_array(), {});
  FitOptions options;
  options.common.move_to_setpoint = false;
  const SensorModel measured = fit_array(data, options), grid = fit_array(data);
  for (std::size_t i = 0; i < grid.array().size(); ++i) {
    REQUIRE(measured.taxels[i].status == TaxelStatus::kFitted);
    CHECK(measured.taxels[i].fit.mean_error < 0.008 * measured.taxels[i].full_scale());
    CHECK(measured.taxels[i].ascending(30.0) == Approx(grid.taxels[i].ascending(30.0)).epsilon(0.01));
  }
}

// Outputs are moved to the set-point by the measured reference: a regulator's own hysteresis is not the sensor's.
TEST_CASE("fit_array: a regulator hysteresis of 0.5 % does not change the fit") {
  const Array array({.rows = 2, .columns = 4, .sensor_seed = 31, .play_share = 0.0});
  const RunOptions with{.regulator_psi = 0.3};  // short of the set-point by it on every way up and on every way down
  Dataset blind = run(array, with);             // as if nobody had measured where the pressure was
  for (SequenceData& sequence : blind.sequences)
    for (Repeat& repeat : sequence.repeats)
      for (Sample& sample : repeat.steps) sample.reference_psi = sample.setpoint_psi;
  const SensorModel still = fit_array(run(array, {.regulator_psi = 0.0})), moved = fit_array(run(array, with)),
                    off = fit_array(blind);
  const auto loop_error = [&](const SensorModel& fit, std::size_t i) {
    const ModelTaxel &model = fit.taxels[i], &own = still.taxels[i];
    double most = 0.0;
    for (int x = 0; x <= 60; x += 2)
      most = std::max(
          {most, std::abs(model.ascending(x) - own.ascending(x)), std::abs(model.descending(x) - own.descending(x))});
    return most / own.yu();
  };
  for (std::size_t i = 0; i < still.array().size(); ++i) {
    const ModelTaxel &first = still.taxels[i], &second = moved.taxels[i];
    const ModelFit &a = first.fit, &b = second.fit;
    const ElamParameters &p = elam_of(first)->parameters, &q = elam_of(second)->parameters;
    INFO("taxel " << i << ": J " << a.j << " and " << b.j << ", loops " << loop_error(moved, i) << " and "
                  << loop_error(off, i) << " apart");
    CHECK(loop_error(moved, i) < 0.002);
    CHECK(loop_error(off, i) > 0.006);
    CHECK(std::abs(b.mean_error / second.full_scale() - a.mean_error / first.full_scale()) < 2e-4);
    CHECK(std::abs(b.j - a.j) < 660 * std::pow(0.002 * first.full_scale(), 2));  // 0.2 % a sample
    CHECK(std::abs(q.alpha_d - p.alpha_d) < 0.01);
    CHECK(std::abs(q.beta_d - p.beta_d) < 0.002);
    CHECK(std::abs(q.alpha_a0 - p.alpha_a0) < 0.05);
    CHECK(std::abs(q.alpha_a0 + 60 * q.alpha_a1 - p.alpha_a0 - 60 * p.alpha_a1) < 0.04);
    CHECK(std::abs(q.beta_a - p.beta_a) < 0.05);
  }
}
