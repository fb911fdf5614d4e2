#include "analysis/report/overview/overview_figures.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <nlohmann/json.hpp>
#include <string_view>

#include "analysis/counted.h"
#include "analysis/documents/run_json.h"
#include "analysis/identify/stored/model_document.h"
#include "analysis/json_fields.h"
#include "analysis/report/data/data.h"
#include "analysis/report/overview/overview.h"
#include "analysis/report/page/chart.h"
#include "analysis/statistics/figures/levels.h"
#include "analysis/statistics/numbers/moments.h"

namespace tactbench::analysis {

namespace {

double when(bool there, double value) { return there ? value : kNan; }

bool evaluated(const ReportInput& input) { return !input.evaluation.levels.empty(); }

}  // namespace

const std::vector<OverviewFigure>& overview_figures() {
  static const std::vector<OverviewFigure> figures = {
      {"excluded taxels", "excluded_taxels",
       [](const ReportInput& i) {
         return when(!i.health.high_v.empty(),
                     static_cast<double>(std::ranges::count_if(i.health.findings, &TaxelHealth::excluded)));
       },
       0, 1.0, "unfit_taxels"},
      {"noise of the median taxel, mV", "median_noise_v",
       [](const ReportInput& i) { return when(!i.health.noise_v.empty(), i.health.median_noise_v); }, 3, 1e3, ""},
      {"full scale, V", "full_scale_v",
       [](const ReportInput& i) { return when(!i.behaviour.loops.empty(), i.behaviour.full_scale_v); }, 3, 1.0, ""},
      {"indication: hysteresis, maximum, % FS", "hysteresis_max_fs",
       [](const ReportInput& i) { return i.behaviour.loops.empty() ? kNan : i.behaviour.loops.front().hysteresis_max; },
       2, 100.0, ""},
      {"indication: hysteresis, mean, % FS", "hysteresis_mean_fs",
       [](const ReportInput& i) {
         return i.behaviour.loops.empty() ? kNan : i.behaviour.loops.front().hysteresis_mean;
       },
       2, 100.0, ""},
      {"relative sensitivity, standard deviation over the taxels, %", "gain_std",
       [](const ReportInput& i) {
         double sum = 0.0;
         int n = 0;
         for (const double gain : i.behaviour.gain) {
           if (!std::isfinite(gain)) continue;
           sum += (gain - 1.0) * (gain - 1.0);
           ++n;
         }
         return n > 1 ? std::sqrt(sum / (n - 1)) : kNan;
       },
       1, 100.0, ""},
      {"corrected: mean absolute error", "mean_error_psi",
       [](const ReportInput& i) { return when(evaluated(i), i.evaluation.mean_error_psi); }, 3, 1.0,
       "mean_compensation_error"},
      {"corrected: mean absolute error of the worst taxel", "worst_taxel_mean_error_psi",
       [](const ReportInput& i) { return when(evaluated(i), i.evaluation.worst_taxel_mean_error_psi); }, 3, 1.0,
       "worst_taxel_error"},
      {"indication: hysteresis of the mean taxel over the levels, % FS", "raw_distance_fs",
       [](const ReportInput& i) { return when(evaluated(i), i.evaluation.raw_distance); }, 2, 100.0, ""},
      {"corrected: hysteresis of the mean of all pressures, % FS", "comp_distance_of_mean_fs",
       [](const ReportInput& i) { return when(evaluated(i), i.evaluation.comp_distance_of_mean); }, 2, 100.0,
       "distance_of_mean"},
      {"corrected: hysteresis, mean over taxels, % FS", "comp_distance_fs",
       [](const ReportInput& i) { return when(evaluated(i), i.evaluation.comp_distance); }, 2, 100.0, ""},
      {"branches void and attempts after faults", "retries",
       [](const ReportInput& i) {
         const auto attempts = std::ranges::count(i.history.events, std::string("attempt"), &RunLogEvent::kind);
         return when(i.history.loaded, static_cast<double>(attempts) + static_cast<double>(i.history.voids.size()));
       },
       0, 1.0, ""},
  };
  return figures;
}

bool is_pressure(const OverviewFigure& figure) { return std::string_view(figure.key).ends_with("_psi"); }

std::string name_of(const OverviewFigure& figure, PressureUnit unit) {
  return is_pressure(figure) ? fmt::format("{}, {}", figure.name, unit.symbol()) : figure.name;
}

doc::Quantity shown_figure(const OverviewFigure& figure, double value) {
  return is_pressure(figure) ? doc::bare_pressure(value, figure.digits)
                             : doc::number(figure.factor * value, figure.digits);
}

double plotted_figure(const OverviewFigure& figure, double value, PressureUnit unit) {
  return is_pressure(figure) ? unit.of(value) : figure.factor * value;
}

double limit_of(const OverviewFigure& figure, const ReportInput& input) {
  for (const JudgedFigure& judged : input.judgement.figures)
    if (to_string(judged.criterion) == std::string_view(figure.criterion)) return judged.limit;
  return kNan;
}

std::string content_of_run(const ReportInput& input) {
  nlohmann::ordered_json figures, verdicts = nlohmann::ordered_json::array();
  for (const OverviewFigure& figure : overview_figures()) figures[figure.key] = figure.value(input);
  for (const JudgedFigure& figure : input.judgement.figures) verdicts.push_back(figure_json(figure));
  nlohmann::ordered_json loops = nlohmann::ordered_json::array();
  for (const RawLoop& loop : input.behaviour.loops)
    if (loop.taxel < 0) loops.push_back({{"up_v", number_list(loop.up_v)}, {"down_v", number_list(loop.down_v)}});
  return json_text(
      {{"sensor", input.run.sensor_serial},
       {"scanner", scanner_serial_of(input.run, input.sensor)},
       JSON_FIELDS(input.run, origin, content_sha256),
       {"figures", figures},
       {"verdicts", verdicts},
       {"overall", verdict_text(input.judgement.overall)},
       {"not_judged", input.judgement.not_judged ? display_text(*input.judgement.not_judged, PressureUnit::kPsi) : ""},
       {"pressure_psi", number_list(input.behaviour.pressure_psi)},
       {"mean_loop", loops},
       {"gain", number_list(input.behaviour.gain)}});
}

doc::Phrase overall_phrase(const ReportInput& input, const char* without_limits) {
  const Judgement& judgement = input.judgement;
  if (!judgement.overall) return without_limits;
  doc::Phrase out(*judgement.overall);
  if (judgement.not_judged)
    out.add("\nnot judged: " + display_text(*judgement.not_judged, input.unit));
  else if (const auto now = worst_of(judgement.figures); judgement.overall != now)
    out.add("\nstored; now " + verdict_text(now));
  for (const Remark& remark : judgement.remarks) out.add("\n" + display_text(remark, input.unit));
  return out;
}

std::string sensor_and_run(const ReportInput& input) {
  return fmt::format("{}, run {}", input.run.sensor_serial.empty() ? "not stated" : input.run.sensor_serial,
                     input.run.run);
}

std::vector<double> modified_z_scores(const std::vector<double>& values) {
  std::vector<double> scores(values.size(), kNan);
  const double median = median_of(values);
  std::vector<double> off;
  for (const double value : values)
    if (std::isfinite(value)) off.push_back(std::abs(value - median));
  const double mad = median_of(off);
  if (off.size() < 5 || !(mad > 0.0)) return scores;
  for (std::size_t i = 0; i < values.size(); ++i)
    if (std::isfinite(values[i])) scores[i] = 0.6745 * (values[i] - median) / mad;
  return scores;
}

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

// The last one, because the mean is at the end; if it has no model, the last one with a model.
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

// The mean loops of several runs in one chart.

namespace {

constexpr std::size_t kMostNamedLoops = std::size(kStrokes);

}  // namespace

doc::Document loops_overlaid(const std::vector<const ReportInput*>& runs) {
  const PressureUnit unit = runs.front()->unit;
  const bool named = runs.size() <= kMostNamedLoops;
  Chart chart{.title = "Mean loops before correction of all runs",
              .width = 676.0,
              .height = 240.0,
              .x = {fmt::format("gauge pressure in {}", unit.symbol())},
              .y = {"output in V"},
              .labels_at_ends = named};
  for (const ReportInput* run : runs) {
    const Behaviour& b = run->behaviour;
    if (b.loops.empty()) continue;
    const RawLoop& loop = b.loops.front();
    Curve curve{named ? sensor_and_run(*run) : "", {}, {}, named ? kStrokes[chart.curves.size()] : kBlack};
    const std::size_t n = b.pressure_psi.size();
    for (std::size_t i = 0; i < 2 * n; ++i) {  // first downward, then upward, which ends at the right
      const std::size_t at = i < n ? n - 1 - i : i - n;
      curve.x.push_back(unit.of(b.pressure_psi[at]));
      curve.y.push_back(i < n ? loop.down_v[at] : loop.up_v[at]);
    }
    chart.curves.push_back(std::move(curve));
  }
  doc::Document out;
  out.add(doc::Heading{2, "Mean loops", "loops"});
  if (chart.curves.empty())
    out.add(doc::Paragraph{{"not available"}});
  else
    out.add(doc::Drawing{chart_svg(chart),
                         chart.title,
                         {"Loops of the mean taxels before correction, ", counted(chart.curves.size(), "run"), "."}});
  return out;
}

}  // namespace tactbench::analysis
