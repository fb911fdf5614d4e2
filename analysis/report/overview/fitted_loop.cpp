#include "analysis/report/overview/fitted_loop.h"

#include <algorithm>
#include <iterator>

#include "analysis/identify/stored/model_document.h"
#include "analysis/statistics/numbers/moments.h"

namespace tactbench::analysis {

namespace {

constexpr std::size_t kMostPoints = 6000;  // of a curve

// Histories one after the other, with a gap between them; of very many samples every n-th.
class Curves {
 public:
  Curves(const Histories& histories, const TaxelHistories& taxel, PressureUnit unit)
      : shown_(taxel.fit.empty() ? taxel.score : taxel.fit),
        factor_(histories.input_unit == "psi" ? unit.of(1.0) : 1.0),
        sign_(histories.falling ? -1.0 : 1.0) {
    std::size_t samples = 0;
    for (const History& history : shown_) samples += history.x.size();
    step_ = 1 + samples / kMostPoints;
  }
  [[nodiscard]] const std::vector<History>& histories() const { return shown_; }
  void add(Curve& curve, const History& history, const std::vector<double>& y, double factor) const {
    if (!curve.x.empty()) {
      curve.x.push_back(curve.x.back());
      curve.y.push_back(kNan);
    }
    for (std::size_t i = 0; i < y.size(); i += step_) {
      curve.x.push_back(factor_ * history.x[i]);
      curve.y.push_back(sign_ * factor * y[i]);
    }
  }

 private:
  const std::vector<History>& shown_;
  double factor_, sign_;
  std::size_t step_ = 1;
};

const ModelTaxel* fitted_taxel(const SensorModel& model, int number) {
  const auto taxel = std::ranges::find(model.taxels, number, &ModelTaxel::taxel);
  return taxel == model.taxels.end() || taxel->fit.model == nullptr ? nullptr : &*taxel;
}

// The last: the mean stands at the end. Where that has no model, the last that has one.
const TaxelHistories& shown_taxel(const Histories& histories, const std::vector<const SensorModel*>& models) {
  for (auto taxel = histories.taxels.rbegin(); taxel != histories.taxels.rend() && !models.empty(); ++taxel)
    if (fitted_taxel(*models.front(), taxel->taxel) != nullptr) return *taxel;
  return histories.taxels.back();
}

std::string of_taxel(const TaxelHistories& taxel, const Histories& histories) {
  return taxel.taxel == kMeanTaxel     ? "mean taxel"
         : histories.taxels.size() > 1 ? fmt::format("taxel {}", taxel.taxel)
                                       : histories.source;
}

Axis input_axis(const Histories& histories, PressureUnit unit) {
  if (histories.input_unit == "psi") return {fmt::format("gauge pressure in {}", unit.symbol())};
  return {histories.input_unit.empty() ? "input" : "input in " + histories.input_unit};
}

}  // namespace

Chart fitted_loop(const Histories& histories, const std::vector<const SensorModel*>& models, PressureUnit unit) {
  const TaxelHistories& taxel = shown_taxel(histories, models);
  const Curves curves(histories, taxel, unit);
  Chart chart{.title = "Measured loop and model, " + of_taxel(taxel, histories),
              .width = 676.0,
              .height = 360.0,
              .x = input_axis(histories, unit),
              .y = {histories.output_unit.empty() ? "output" : "output in " + histories.output_unit}};
  Curve measured{"measured", {}, {}, kStrokes[0], true};
  for (const History& history : curves.histories()) curves.add(measured, history, history.y, 1.0);
  chart.curves.push_back(std::move(measured));
  for (const SensorModel* model : models) {
    const ModelTaxel* own = fitted_taxel(*model, taxel.taxel);
    if (own == nullptr || chart.curves.size() == std::size(kStrokes)) continue;
    Curve curve{label_of(*model), {}, {}, kStrokes[chart.curves.size()]};
    for (const History& history : curves.histories()) curves.add(curve, history, own->predicted(history, false), 1.0);
    chart.curves.push_back(std::move(curve));
  }
  return chart;
}

Chart fitted_errors(const Histories& histories, const SensorModel& model, PressureUnit unit) {
  const TaxelHistories& taxel = shown_taxel(histories, {&model});
  const Curves curves(histories, taxel, unit);
  Chart chart{.title = fmt::format("What {} leaves, {}", label_of(model), of_taxel(taxel, histories)),
              .width = 676.0,
              .height = 200.0,
              .x = input_axis(histories, unit),
              .y = {"error in % FS"}};
  Curve left{"", {}, {}, kBlue, true};
  const ModelTaxel* own = fitted_taxel(model, taxel.taxel);
  for (const History& history : curves.histories()) {
    if (own == nullptr) break;
    std::vector<double> errors = own->predicted(history, false);
    for (std::size_t i = 0; i < errors.size(); ++i) errors[i] = history.y[i] - errors[i];
    curves.add(left, history, errors, 100.0 / own->fit.full_scale);
  }
  chart.curves.push_back(std::move(left));
  return chart;
}

}  // namespace tactbench::analysis
