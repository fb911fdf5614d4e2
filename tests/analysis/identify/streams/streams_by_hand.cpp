// Streams of any model by hand, on a film of two intervals: uncertainties, rest, unknown starts, and what they leave.
#include <catch2/catch.hpp>
#include <cmath>
#include <memory>
#include <vector>

#include "analysis/identify/compensators.h"
#include "analysis/identify/residuals.h"
#include "analysis/models/monotone.h"
#include "analysis/models/preisach.h"

using namespace tactbench::analysis;

namespace {

// Up 0, 1, 3 at 0, 30, 60; down 3, 2, 0 at 60, 30, 0. From 2 at 45: down 1.5 at 30, 1 at 15, 0 at 0.
std::shared_ptr<const PreisachModel> loop_film() {
  return std::make_shared<PreisachModel>(0.0, 60.0, 0.0, std::vector<double>{1, 1, 1});
}
// 0 to 2 straight, both ways.
std::shared_ptr<const PreisachModel> straight_film() {
  return std::make_shared<PreisachModel>(0.0, 60.0, 0.0, std::vector<double>{1, 0, 1});
}

ModelTaxel streamed_taxel(std::shared_ptr<const HysteresisModel> film, double full_scale) {
  ModelTaxel taxel;
  taxel.status = TaxelStatus::kFitted;
  taxel.fit.model = std::move(film);
  taxel.fit.full_scale = full_scale;
  const std::vector<double> x{0.0, 60.0}, y{0.0, full_scale};
  taxel.ascending = taxel.descending = PatternCurve(x, y, 0.0, full_scale);
  return taxel;
}

SensorModel model_of_taxels(const std::string& name, std::vector<ModelTaxel> taxels) {
  SensorModel model;
  model.model = name;
  model.taxels = std::move(taxels);
  return model;
}

History scored(const std::string& name, const std::vector<double>& outputs, double off) {
  History history;
  history.name = name;
  for (const double y : outputs) {
    history.x.push_back(30.0 * y + off);
    history.y.push_back(y);
  }
  history.branches = branches_along(history.x);
  return history;
}

}  // namespace

TEST_CASE("compensation by hand: the uncertainty is the wider of both sides, flat and out of range at their limits") {
  const auto film = loop_film();
  CompensatorSetup setup;
  setup.noise = 0.01;
  // Four noises are 40 mV: at 45 psi going up 0.6 psi ahead, 1.2 psi back once it may have turned.
  for (const auto& [flat_psi, flat] : {std::pair{1.15, true}, {1.25, false}}) {
    setup.options.flat_share = flat_psi / 60.0;
    const auto compensator = make_compensator(*film, setup);
    compensator->step(2.0, 0.0);
    const Compensated now = compensator->step(2.0, 0.0);
    CHECK(now.pressure_psi == Approx(45.0));
    CHECK(now.uncertainty_psi == Approx(0.3));
    CHECK(now.flat == flat);
    CHECK_FALSE(now.out_of_range);
    CHECK_FALSE(now.unknown);
  }
  for (const auto& [output, out] : {std::pair{3.149, false}, {3.151, true}, {-0.149, false}, {-0.151, true}}) {
    CAPTURE(output);
    CHECK(make_compensator(*film, setup)->step(output, 0.0).out_of_range == out);
  }
}

TEST_CASE("compensation by hand: an unknown start lies midway, half the distance is its doubt beside what is left") {
  ModelTaxel taxel = streamed_taxel(loop_film(), 3.0);
  taxel.residual_psi = 2.0;  // everywhere, of a straight loop
  const SensorModel none = model_of_taxels("preisach", {});
  const auto quiet = compensator_of(none, taxel);
  quiet->start(Start::kUnknown);
  Compensated now = quiet->step(1.0, 0.0);  // 30 psi rising, 15 falling from the top
  CHECK(now.unknown);
  CHECK(now.pressure_psi == Approx(22.5));
  CHECK(now.uncertainty_psi == Approx(std::hypot(7.5, 2.0)));
  now = quiet->step(3.0, 0.0);
  CHECK_FALSE(now.unknown);
  CHECK(now.pressure_psi == Approx(60.0));
  CHECK(now.uncertainty_psi == Approx(2.0));
  CHECK(quiet->step(2.0, 0.0).pressure_psi == Approx(30.0));
  quiet->start(Start::kAtRest);
  CHECK(quiet->step(1.0, 0.0).pressure_psi == Approx(30.0));
}

TEST_CASE("compensation by hand: at rest within the dead band and a hundredth of the span, of adjusted outputs") {
  ModelTaxel taxel = streamed_taxel(loop_film(), 3.0);
  taxel.zero = 0.5;
  taxel.gain = 2.0;
  const SensorModel none = model_of_taxels("preisach", {});
  const auto rests = [&](double noise, double noisier, double above) {
    taxel.noise = noise;
    return compensator_of(none, taxel, noisier)->at_rest(0.5 + 2.0 * above);
  };
  CHECK(rests(0.0, 1.0, 0.0299));
  CHECK_FALSE(rests(0.0, 1.0, 0.0301));
  // Of 20 mV on twice the model's outputs.
  CHECK(rests(0.02, 1.0, 0.0549));
  CHECK_FALSE(rests(0.02, 1.0, 0.0551));
  CHECK(rests(0.02, 2.0, 0.1099));
  CHECK_FALSE(rests(0.02, 2.0, 0.1101));
  CHECK(rests(0.0, 1.0, -1.0));
}

TEST_CASE("residual by hand: twice what a Preisach stream leaves, of a run the last repeat of each sequence") {
  const std::vector<double> way{0, 0.5, 1, 1.5, 2, 1.5, 1, 0.5, 0};
  Histories histories;
  TaxelHistories own;
  own.score = {scored("a", way, 9.0), scored("a", way, 0.5), scored("b", way, 1.0)};
  histories.taxels = {own, own, own};
  histories.taxels[2].score.clear();
  ModelTaxel unfit = streamed_taxel(straight_film(), 2.0);
  unfit.status = TaxelStatus::kUnfit;
  const auto residual = [&](std::int64_t run, const std::vector<std::string>& sequences) {
    histories.run = run;
    SensorModel model = model_of_taxels(
        "preisach", {streamed_taxel(straight_film(), 2.0), unfit, streamed_taxel(straight_film(), 2.0)});
    find_residuals(histories, sequences, 1, model);
    CHECK(model.taxels[1].residual_psi == 0.0);
    CHECK(model.taxels[2].residual_psi == 0.0);
    return model.taxels[0].residual_psi;
  };
  CHECK(residual(4, {}) == Approx(2.0 * std::sqrt((0.25 + 1.0) / 2.0)));
  CHECK(residual(4, {"a"}) == Approx(1.0));
  CHECK(residual(4, {"b"}) == Approx(2.0));
  // Of a table all of them.
  CHECK(residual(0, {}) == Approx(2.0 * std::sqrt((81.0 + 0.25 + 1.0) / 3.0)));
}

TEST_CASE("residual by hand: of other models the opinion of Preisach's on random reversals is added, of all taxels") {
  const std::vector<double> x{0, 60}, y{0, 2};
  const auto straight = std::make_shared<MonotoneModel>(PatternCurve(x, y, 0.0, 2.0));
  const std::vector<double> way{0, 0.5, 1, 1.5, 2, 1.5, 1, 0.5, 0};
  // At each of the 15 intervals' ends, so that no loop fits as well as a straight line.
  std::vector<double> fine;
  for (int i = -15; i <= 15; ++i) fine.push_back((15 - std::abs(i)) * 2.0 / 15.0);
  // Measured `off` psi beside the model; the film that Preisach is fitted to has nine tenths of the output.
  const auto residuals = [&](const std::vector<double>& offs, double film, const std::vector<int>& numbers) {
    Histories histories;
    SensorModel model = model_of_taxels("monotone", {});
    for (std::size_t t = 0; t < offs.size(); ++t) {
      TaxelHistories own;
      own.taxel = numbers[t];
      own.score = {scored("a", way, offs[t])};
      own.fit = {scored("a", fine, 0.0)};
      for (double& output : own.fit[0].y) output *= film;
      histories.taxels.push_back(own);
      model.taxels.push_back(streamed_taxel(straight, 2.0));
      model.taxels.back().taxel = numbers[t];
    }
    find_residuals(histories, {}, 1, model);
    std::vector<double> squares;
    for (const ModelTaxel& taxel : model.taxels) squares.push_back(taxel.residual_psi * taxel.residual_psi);
    return squares;
  };
  CHECK(residuals({0.5}, 1.0, {0})[0] == Approx(4.0 * 0.25).epsilon(0.05));
  // An error of a tenth of each input on the way: as one number, whatever the fitted samples leave.
  const double opinion = residuals({0.5}, 0.9, {0})[0] - 4.0 * 0.25;
  CHECK((opinion > 0.01 * 20.0 * 20.0 && opinion < 0.01 * 50.0 * 50.0));
  CHECK(residuals({2.0}, 0.9, {0})[0] == Approx(4.0 * 4.0 + opinion).epsilon(1e-9));
  CHECK(residuals({0.5}, 0.8, {0})[0] == Approx(1.0 + 4.0 * opinion).epsilon(0.05));
  // The opinions' sum over the fits' sum is the array's.
  const std::vector<double> two = residuals({0.5, 1.0}, 0.9, {0, 1});
  const double more = 2.0 * opinion / (0.25 + 1.0);
  CHECK(two[0] == Approx(0.25 * (4.0 + more)).epsilon(1e-9));
  CHECK(two[1] == Approx(1.0 * (4.0 + more)).epsilon(1e-9));
  // The mean taxel has no opinion beside others', but the same ratio.
  const std::vector<double> with_mean = residuals({0.5, 1.0}, 0.9, {0, kMeanTaxel});
  CHECK(with_mean[0] == Approx(0.25 * 4.0 + opinion).epsilon(1e-9));
  CHECK(with_mean[1] == Approx(1.0 * (4.0 + opinion / 0.25)).epsilon(1e-9));
  // Of more than 32 taxels every second or third is asked: here of the even ones, which err by 0.5.
  std::vector<double> many;
  std::vector<int> numbers;
  for (int t = 0; t < 34; ++t) {
    many.push_back(t % 2 == 0 ? 0.5 : 4.0);
    numbers.push_back(t);
  }
  const std::vector<double> asked = residuals(many, 0.9, numbers);
  CHECK(asked[0] == Approx(0.25 * (4.0 + opinion / 0.25)).epsilon(1e-9));
  CHECK(asked[1] == Approx(16.0 * (4.0 + opinion / 0.25)).epsilon(1e-9));
}
