// The congruency test, and models of the linearised output.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <vector>

#include "analysis/identify/fit_models.h"
#include "analysis/identify/linearise.h"
#include "analysis/identify/stored/model_document.h"
#include "analysis/models/linearised.h"
#include "analysis/models/model_json.h"
#include "analysis/models/preisach.h"
#include "tests/analysis/support/dynamic_runs.h"
#include "tests/analysis/support/fit_samples.h"

using namespace tactbench::analysis;

namespace {

History along(const std::string& name, const std::vector<double>& x, const std::vector<double>& y) {
  return {name, x, y, branches_along(x), {}, {}};
}

// 0 to `top` over 0 to 10, straight.
FitData straight_loop(std::vector<History> histories, double top = 10.0, double zero = 0.0) {
  const std::vector<double> x{0, 10}, y{zero, top};
  return {std::move(histories), PatternCurve(x, y, zero, top), PatternCurve(x, y, zero, top)};
}

// Outputs of inner branches of a film u, seen through a divider of amplitude 4 above a zero of 0.5.
double seen(double u) { return 0.5 + u / (1.0 + u / 4.0); }

// Rises from `turn` and falls from `turn` of a film whose inner branches are straight, 0.5 a unit steep.
FitData congruent(bool divided) {
  const auto out = [&](double u) { return divided ? seen(u) : 0.5 + u; };
  std::vector<History> histories;
  for (const double turn : {2.0, 4.0}) {
    // From the top, u = 10, down to the turn at u = turn + 1 and up again, so that the rise has 0.5 a unit.
    std::vector<double> x{10.0, turn}, y{out(10.0), out(turn + 1.0)};
    for (const double at : {6.0, 8.0}) {
      x.push_back(at);
      y.push_back(out(turn + 1.0 + 0.5 * (at - turn)));
    }
    histories.push_back(along("up", x, y));
  }
  for (const double turn : {6.0, 8.0}) {
    std::vector<double> x{0.0, turn}, y{out(0.0), out(0.8 * turn)};
    for (const double at : {4.0, 2.0}) {
      x.push_back(at);
      y.push_back(out(0.8 * turn - 0.5 * (turn - at)));
    }
    histories.push_back(along("down", x, y));
  }
  return straight_loop(std::move(histories), out(10.0), out(0.0));
}

Congruency of_rises(const std::vector<std::pair<double, double>>& rises, double fall_turn = 7.0) {
  // From 0 to a turn at 7 and down to 0, straight, 1 a unit; from 10 down to a turn, straight, and up to 10 so steep
  // that the output at 7 is as given.
  std::vector<History> histories = {along("fall", {0, fall_turn, 0}, {0, fall_turn, 0})};
  for (const auto& [turn, slope] : rises)
    histories.push_back(along("rise", {10, turn, 10}, {10, turn, turn + slope * (10.0 - turn)}));
  return find_divider(straight_loop(histories));
}

}  // namespace

TEST_CASE("congruency: finds the divider for which inner branches between equal inputs rise and fall equally") {
  const Congruency found = find_divider(congruent(true));
  CHECK(found.pairs == 4);
  CHECK(found.divider.zero == 0.5);
  CHECK(found.divider.per_amplitude == Approx(0.25).epsilon(1e-6));
  CHECK(found.rms == Approx(0.0).margin(1e-7));
  CHECK(found.plain_rms > 0.01);
  const Congruency none = find_divider(congruent(false));
  CHECK(none.pairs == 4);
  CHECK(none.divider.per_amplitude == 0.0);
  CHECK(none.divider.zero == 0.5);
  CHECK(none.rms == none.plain_rms);
  CHECK(none.plain_rms == Approx(0.0).margin(1e-12));
}

TEST_CASE("congruency: the misfit is the RMS difference of rises and falls, and needs three pairs") {
  // Between 4 and 7 the fall is 3, between 1 and 7 6, between 3 and 7 4: rises that are 1, 2 and 2 more.
  const Congruency found = of_rises({{4.0, 4.0 / 3.0}, {1.0, 8.0 / 6.0}, {3.0, 6.0 / 4.0}});
  CHECK(found.pairs == 3);
  CHECK(found.plain_rms == Approx(std::sqrt(9.0 / 3.0)));
  // Two pairs are too few, and so are turns that do not lie below the fall's.
  const Congruency few = of_rises({{4.0, 2.0}, {1.0, 2.0}, {7.0, 2.0}, {8.0, 2.0}});
  CHECK(few.pairs == 2);
  CHECK(few.plain_rms == 0.0);
  CHECK(few.divider.per_amplitude == 0.0);
  // Turns within a hundredth of the ends are none inside.
  CHECK(of_rises({{0.1, 1.5}, {1.0, 1.5}, {3.0, 1.5}}).pairs == 2);
  CHECK(of_rises({{0.125, 1.5}, {1.0, 1.5}, {3.0, 1.5}}).pairs == 3);
  CHECK(of_rises({{1.0, 1.5}, {2.0, 1.5}, {3.0, 1.5}}, 9.9375).pairs == 0);
  CHECK(of_rises({{1.0, 1.5}, {2.0, 1.5}, {3.0, 1.5}}, 9.875).pairs == 3);
}

TEST_CASE("congruency: only branches from within 1 % of an end that reach the other's turning point count") {
  const auto pairs = [](const History& rise) {
    std::vector<History> histories = {along("fall", {0, 7, 0}, {0, 7, 0})};
    for (int n = 0; n < 3; ++n) histories.push_back(rise);
    return find_divider(straight_loop(histories)).pairs;
  };
  CHECK(pairs(along("rise", {10, 4, 10}, {10, 4, 10})) == 3);
  CHECK(pairs(along("rise", {9.9375, 4, 10}, {10, 4, 10})) == 3);
  CHECK(pairs(along("rise", {9.875, 4, 10}, {10, 4, 10})) == 0);
  CHECK(pairs(along("rise", {10, 4, 7}, {10, 4, 7})) == 3);
  CHECK(pairs(along("rise", {10, 4, 6.9375}, {10, 4, 7})) == 0);
  // A fall that follows a fall has no turn between.
  History none = along("rise", {10, 4, 10}, {10, 4, 10});
  none.branches[0].ascending = true;
  CHECK(pairs(none) == 0);
}

TEST_CASE("linearised: histories and both patterns are converted by the divider") {
  const Divider divider{0.5, 0.25};
  FitData data = straight_loop({along("a", {0, 10}, {0.5, seen(3.0)})}, seen(10.0), 0.5);
  data.descending =
      PatternCurve(std::vector<double>{0, 5, 10}, std::vector<double>{0.5, seen(8.0), seen(10.0)}, 0.5, seen(10.0));
  const FitData own = linearised(data, divider);
  CHECK(own.histories[0].y[0] == Approx(0.0).margin(1e-12));
  CHECK(own.histories[0].y[1] == Approx(3.0));
  CHECK(own.ascending.y()[1] == Approx(10.0));
  CHECK(own.descending.y()[1] == Approx(8.0));
  CHECK(own.descending.x()[1] == 5.0);
}

// When a model of the linearised output is taken: the errors on branches that were held out, sample by sample, by
// models whose output is one number.
using namespace synthetic;

namespace {

// One constant for outputs that reach higher than `above`, another for others.
class ConstantOutputs final : public Identifier {
 public:
  ConstantOutputs(double above, double higher, double other) : above_(above), higher_(higher), other_(other) {}
  [[nodiscard]] ModelFit fit(const FitData& data) const override {
    ModelFit fit;
    const double output = data.ascending.y().back() > above_ ? higher_ : other_;
    fit.model = std::make_shared<PreisachModel>(0.0, 60.0, output, std::vector<double>{0.0});
    return fit;
  }

 private:
  double above_, higher_, other_;
};

class NeverFits final : public Identifier {
 public:
  [[nodiscard]] ModelFit fit(const FitData& /*data*/) const override { throw std::invalid_argument("not these"); }
};

const LinearisedModel& plant() {
  static const LinearisedModel model({0.02, 1.0 / 3.3}, std::make_unique<PreisachModel>(film_of(29, 30)));
  return model;
}

double above_plain(const FitData& data) { return 1.01 * data.ascending.y().back(); }

// Outputs of branches from inside the range, without their first.
std::vector<double> held_outputs(const FitData& data) {
  std::vector<double> outputs;
  for (const History& history : data.histories)
    for (const Branch& branch : history.branches) {
      const double from = history.x[static_cast<std::size_t>(branch.first)];
      if (branch.ascending ? from <= 0.6 : from >= 59.4) continue;
      outputs.insert(outputs.end(), history.y.begin() + branch.first + 1, history.y.begin() + branch.last + 1);
    }
  return outputs;
}

double amplitude_taken(const FitData& data, bool cross, const PrepareInner& inner) {
  return dynamic_cast<const LinearisedModel&>(*prepare_linearised(data, false, cross, inner)->fit(data).model)
      .divider()
      .per_amplitude;
}

}  // namespace

TEST_CASE("linearised: the divider is used if it reduces the errors on held-out branches", "[linearise]") {
  const FitData data = two_sequences(plant());
  REQUIRE(find_divider(data).divider.per_amplitude > 0.0);
  const double zero = data.ascending.y().front(), above = above_plain(data);
  // With the divider all samples are `zero`, without it `even`, where both err by as much in sum.
  double sum = 0.0;
  const std::vector<double> outputs = held_outputs(data);
  for (const double y : outputs) {
    REQUIRE(y >= zero);
    sum += y;
  }
  const double even = 2.0 * sum / static_cast<double>(outputs.size()) - zero;
  REQUIRE(even > *std::ranges::max_element(outputs));
  const auto with = [&](double plain) {
    return [above, plain](const FitData&) { return std::make_unique<ConstantOutputs>(above, 0.0, plain); };
  };
  CHECK(amplitude_taken(data, true, with(even * (1.0 + 1e-6))) > 0.0);
  CHECK(amplitude_taken(data, true, with(even * (1.0 - 1e-6))) == 0.0);
  // No less: it stays off.
  CHECK(amplitude_taken(data, true, with(zero)) == 0.0);
  CHECK(amplitude_taken(data, false, with(zero)) > 0.0);
}

TEST_CASE("linearised: if no branches can be held out the congruency test alone decides on the divider",
          "[linearise]") {
  const FitData data = two_sequences(plant());
  const double above = above_plain(data);
  int prepared = 0;
  // Without the divider all would be less.
  const auto good = [&] { return std::make_unique<ConstantOutputs>(above, 0.0, 1.5); };
  CHECK(amplitude_taken(data, true, [&](const FitData&) { return good(); }) == 0.0);
  CHECK(amplitude_taken(data, true, [&](const FitData&) -> std::unique_ptr<Identifier> {
          if (prepared++ == 0) return good();
          return std::make_unique<NeverFits>();
        }) > 0.0);
  CHECK(prepared == 6);
  prepared = 0;
  CHECK(amplitude_taken(data, true, [&](const FitData&) -> std::unique_ptr<Identifier> {
          if (prepared++ == 3) throw std::invalid_argument("not these");
          return good();
        }) > 0.0);
  CHECK(prepared == 4);
}

TEST_CASE("linearised: errors are those of the whole model on the measured outputs", "[linearise]") {
  const FitData data = two_sequences(plant());
  const double above = above_plain(data), zero = data.ascending.y().front();
  const auto fit = prepare_linearised(data, false, false, [&](const FitData&) {
                     return std::make_unique<ConstantOutputs>(above, 0.0, 9.0);
                   })->fit(data);
  double squares = 0.0, sum = 0.0, most = 0.0;
  int samples = 0;
  for (const History& history : data.histories)
    for (const Branch& branch : history.branches)
      for (int i = branch.first + 1; i <= branch.last; ++i, ++samples) {
        const double off = std::abs(history.y[static_cast<std::size_t>(i)] - zero);
        squares += off * off;
        sum += off;
        most = std::max(most, off);
      }
  CHECK(fit.samples == samples);
  CHECK(fit.j == Approx(squares));
  CHECK(fit.mean_error == Approx(sum / samples));
  CHECK(fit.max_error == Approx(most));
  CHECK(fit.full_scale == Approx(data.ascending.y().back() - zero));
}

TEST_CASE("linearised: without a divider, outputs that start above 0 are fitted by the plain model", "[linearise]") {
  FitData data = two_sequences(film_of(31, 30));
  for (History& history : data.histories)
    for (double& y : history.y) y += 0.5;
  const auto raised = [](const PatternCurve& curve) {
    std::vector<double> y(curve.y().begin(), curve.y().end());
    for (double& at : y) at += 0.5;
    return PatternCurve(curve.x(), y, y.front(), y.back());
  };
  data.ascending = raised(data.ascending);
  data.descending = raised(data.descending);
  REQUIRE(find_divider(data).divider.per_amplitude == 0.0);
  for (const bool cross : {false, true}) {
    const ModelFit fit = prepare_linearised(data, false, cross, [&](const FitData&) {
                           return std::make_unique<ConstantOutputs>(100.0, 0.0, 2.0);
                         })->fit(data);
    const auto& model = dynamic_cast<const LinearisedModel&>(*fit.model);
    CHECK(model.divider().zero == 0.0);
    CHECK(predict(model, std::vector<double>{0.0, 30.0}) == std::vector<double>{2.0, 2.0});
    CHECK(fit.samples == 0);  // as the plain model's fit tells them
  }
}

// Which taxels get their readout divider undone, and how such models are kept.

namespace {

const LinearisedModel& linearised_in(const ModelFit& fit) { return dynamic_cast<const LinearisedModel&>(*fit.model); }

// A model of a table's one taxel, with what its document holds.
SensorModel sensor_of(const std::string& name, const ModelFit& fit, const FitData& data) {
  SensorModel sensor;
  sensor.model = name;
  sensor.options.linearise = true;
  sensor.rows = sensor.columns = 1;
  sensor.pressure_psi.assign(data.ascending.x().begin(), data.ascending.x().end());
  ModelTaxel& taxel = sensor.taxels.emplace_back();
  taxel.status = TaxelStatus::kFitted;
  taxel.fit = fit;
  taxel.loop_low = data.ascending.y().front();
  set_loop(taxel, data.ascending.x(), data.ascending.y(), data.descending.y());
  return sensor;
}

}  // namespace

TEST_CASE("linearised: finds a plant's divider within 1 %, and without one equals the plain model bit for bit",
          "[linearise]") {
  const IdentifyOptions options{.linearise = true};
  for (const unsigned seed : {31U, 32U, 33U}) {
    for (const double amplitude : {2.7, 3.9}) {
      const LinearisedModel film({0.02, 1.0 / amplitude}, std::make_unique<PreisachModel>(film_of(seed, 30)));
      const ModelFit fit = identify("preisach", two_sequences(film), options);
      CHECK(1.0 / linearised_in(fit).divider().per_amplitude == Approx(amplitude).epsilon(0.01));
    }
    const FitData bare = two_sequences(film_of(seed, 30));
    for (const char* const name : {"elam", "preisach", "poly"}) {
      const ModelFit fit = identify(name, bare, options), plain = identify(name, bare);
      const LinearisedModel& model = linearised_in(fit);
      CHECK(model.divider().per_amplitude == 0.0);
      CHECK(model.parameters().front().name == "c");
      CHECK_FALSE(model.parameters().front().at_bound());
      CHECK(model_json(model.inner()) == model_json(*plain.model));
      CHECK(fit.j == plain.j);
      const std::vector<double> way = random_way(300, 2.5, seed);
      CHECK(predict(model, way) == predict(*plain.model, way));
    }
  }
}

TEST_CASE("linearised: documents store and read back the divider, documents of plain models have no divider",
          "[linearise]") {
  const FitData data = two_sequences(plant());
  for (const std::string& name : model_names()) {
    const SensorModel sensor = sensor_of(name, identify(name, data, {.linearise = true}), data);
    CHECK(label_of(sensor) == std::string(name) + ", linearised");
    const std::string text = to_text(sensor);
    CHECK_THAT(text, Catch::Contains("\"linearise\": true"));
    const SensorModel again = document_from_text(text, "m.json");
    CHECK(to_text(again) == text);
    CHECK(again.options.linearise);
    REQUIRE(linearised_of(again.taxels.front()) != nullptr);
    CHECK(linearised_of(again.taxels.front())->divider().per_amplitude ==
          linearised_of(sensor.taxels.front())->divider().per_amplitude);
    SensorModel plain = sensor_of(name, identify(name, data), data);
    plain.options.linearise = false;
    CHECK_THAT(to_text(plain), !Catch::Contains("linearise"));
    CHECK(linearised_of(plain.taxels.front()) == nullptr);
  }
}

// A sensor whose outputs begin at another voltage: each model fits and predicts the same, that much higher.

TEST_CASE("identification: an output offset shifts each model's prediction and leaves its errors unchanged") {
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
