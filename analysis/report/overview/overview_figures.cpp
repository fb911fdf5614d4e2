#include "analysis/report/overview/overview_figures.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string_view>

#include "analysis/documents/evaluation_json.h"
#include "analysis/json_fields.h"
#include "analysis/report/data/data.h"
#include "analysis/report/overview/overview.h"
#include "analysis/statistics/figures/levels.h"

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
         const auto attempts = std::ranges::count(i.history.events, std::string("attempt"), &HistoryEvent::kind);
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
       {"overall", verdict_word(input.judgement.overall)},
       {"not_judged", input.judgement.not_judged ? in_words(*input.judgement.not_judged, PressureUnit::kPsi) : ""},
       {"pressure_psi", number_list(input.behaviour.pressure_psi)},
       {"mean_loop", loops},
       {"gain", number_list(input.behaviour.gain)}});
}

doc::Phrase overall_phrase(const ReportInput& input, const char* without_limits) {
  const Judgement& judgement = input.judgement;
  if (!judgement.overall) return without_limits;
  doc::Phrase out(*judgement.overall);
  if (judgement.not_judged)
    out.add("\nnot judged: " + in_words(*judgement.not_judged, input.unit));
  else if (const auto now = worst_of(judgement.figures); judgement.overall != now)
    out.add("\nstored; now " + verdict_word(now));
  for (const Remark& remark : judgement.remarks) out.add("\n" + in_words(remark, input.unit));
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

}  // namespace tactbench::analysis
