#include "analysis/statistics/uncertainty/temperature_effect.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "analysis/identify/sensor_model.h"
#include "analysis/loop.h"
#include "analysis/statistics/figures/behaviour.h"
#include "analysis/statistics/figures/levels.h"
#include "analysis/statistics/figures/time_effects.h"

namespace tactbench::analysis {
namespace {

constexpr std::size_t kFewestLoopLevels = 5;

// An external loop's outputs less the lowest level's of the calibration, at the levels that both have: pairs of one
// taxel, or of the mean of some.
struct LoopPairs {
  std::vector<double> calibration, other;
};

struct LoopsOfTwo {
  const ExternalLoop& calibration;
  const ExternalLoop& other;
  std::size_t width;

  [[nodiscard]] LoopPairs pairs(std::span<const std::size_t> taxels) const {
    LoopPairs out;
    for (std::size_t i = 0; i < calibration.pressure_psi.size(); ++i) {
      const auto found = std::ranges::find_if(
          other.pressure_psi, [&](double pressure) { return same_level(pressure, calibration.pressure_psi[i]); });
      if (found == other.pressure_psi.end()) continue;
      const auto at = static_cast<std::size_t>(found - other.pressure_psi.begin());
      for (const auto branch : {&ExternalLoop::ascending, &ExternalLoop::descending}) {
        out.calibration.push_back(mean((calibration.*branch), i, taxels));
        out.other.push_back(mean((other.*branch), at, taxels));
      }
    }
    return out;
  }
  [[nodiscard]] double mean(const std::vector<double>& table, std::size_t row,
                            std::span<const std::size_t> taxels) const {
    return mean_of_chosen(std::span<const double>(table).subspan(row * width, width), taxels);
  }
};

// Least squares: other - calibration = zero + share (calibration - its lowest output).
std::optional<OutputChange> change_of(const LoopPairs& pairs) {
  if (pairs.calibration.size() < 2 * kFewestLoopLevels) return std::nullopt;
  const double zero = *std::ranges::min_element(pairs.calibration);
  std::vector<double> over_zero, change;
  for (std::size_t i = 0; i < pairs.calibration.size(); ++i) {
    over_zero.push_back(pairs.calibration[i] - zero);
    change.push_back(pairs.other[i] - pairs.calibration[i]);
  }
  const LineFit line = line_fit(over_zero, change);
  if (!(line.xx > 0.0)) return std::nullopt;
  return OutputChange{line.at_zero(), line.slope()};
}

struct ThermalRun {
  double temperature_c = 0.0;
  OutputChange change;                // of the mean taxel
  std::vector<OutputChange> repeats;  // the same of each repeat
  std::vector<OutputChange> taxels;   // of each fitted taxel
};

int most_repeats(const Dataset& dataset) {
  std::size_t most = 0;
  for (const SequenceData& data : dataset.sequences) most = std::max(most, data.repeats.size());
  return static_cast<int>(most);
}

// None where the run does not sweep the calibration's levels. Like is held against like: as many first repeats of both,
// for a film that is being conditioned changes from repeat to repeat.
std::optional<ThermalRun> thermal_run(const Dataset& dataset, const Dataset& calibration, const Fitted& fitted) {
  const RepeatOptions first{.first_repeat = 0,
                            .last_repeat = std::min(most_repeats(dataset), most_repeats(calibration)) - 1};
  const std::optional<ExternalLoop> theirs = loop_of(dataset, first), ours = loop_of(calibration, first);
  if (!theirs || !ours) return std::nullopt;
  const LoopsOfTwo both{*ours, *theirs, fitted.width()};
  const std::optional<OutputChange> change = change_of(both.pairs(fitted.taxels()));
  if (!change) return std::nullopt;
  ThermalRun run{mean_temperature_c(dataset), *change, {}, {}};
  for (const std::size_t taxel : fitted.taxels())
    run.taxels.push_back(change_of(both.pairs({&taxel, 1})).value_or(OutputChange{}));
  for (int r = 0; r < most_repeats(dataset); ++r) {
    const std::optional<ExternalLoop> one =
        loop_of(dataset, {.move_to_setpoint = true, .first_repeat = r, .last_repeat = r});
    if (!one) continue;
    const LoopsOfTwo pair{*ours, *one, fitted.width()};
    if (const auto own = change_of(pair.pairs(fitted.taxels()))) run.repeats.push_back(*own);
  }
  return run;
}

// The straight line of a member of the changes over temperature.
struct LineOverKelvin {
  double slope = 0.0, repeats_u = kNan, runs_u = kNan;
  double repeats_dof = 0.0, runs_dof = 0.0;
};

std::vector<double> kelvins_of(std::span<const ThermalRun> runs) {
  std::vector<double> kelvins;
  for (const ThermalRun& run : runs) kelvins.push_back(run.temperature_c);
  return kelvins;
}

LineOverKelvin line_over_kelvin(std::span<const ThermalRun> runs, double OutputChange::*member) {
  const auto n = static_cast<double>(runs.size());
  const std::vector<double> kelvins = kelvins_of(runs);
  std::vector<double> changes;
  for (const ThermalRun& run : runs) changes.push_back(run.change.*member);
  const LineFit fit = line_fit(kelvins, changes);
  LineOverKelvin line;
  line.slope = fit.slope();
  double within = 0.0, weighted = 0.0;
  for (const ThermalRun& run : runs) {
    std::vector<double> own;
    for (const OutputChange& repeat : run.repeats) own.push_back(repeat.*member);
    const double mean = mean_of(own);
    for (const double change : own) within += (change - mean) * (change - mean);
    const auto repeats = static_cast<double>(std::max<std::size_t>(1, own.size()));
    line.repeats_dof += repeats - 1.0;
    weighted += std::pow((run.temperature_c - fit.mean_x) / fit.xx, 2) / repeats;
  }
  if (line.repeats_dof > 0.0) line.repeats_u = std::sqrt(within / line.repeats_dof * weighted);
  line.runs_dof = n - 2.0;
  if (line.runs_dof > 0.0)
    line.runs_u = std::sqrt(residual_sum_of_squares(fit, kelvins, changes) / line.runs_dof / fit.xx);
  return line;
}

// Standard deviation of the taxels' own slopes. A taxel's mean need not be taken off: the kelvins add up to 0.
double deviation_of_taxels(std::span<const ThermalRun> runs, double OutputChange::*member) {
  const std::vector<double> kelvins = kelvins_of(runs);
  const double mean_t = mean_of(kelvins), tt = sum_of_squares_about(kelvins, mean_t);
  std::vector<double> slopes;
  for (std::size_t taxel = 0; taxel < runs.front().taxels.size(); ++taxel) {
    double ty = 0.0;
    for (const ThermalRun& run : runs) ty += (run.temperature_c - mean_t) * run.taxels[taxel].*member;
    slopes.push_back(ty / tt);
  }
  return slopes.size() < 2 ? 0.0 : sample_deviation(slopes);
}

void keep_lines(std::span<const ThermalRun> runs, TemperatureEffect& effect) {
  for (const auto member : {&OutputChange::zero_v, &OutputChange::share}) {
    const LineOverKelvin line = line_over_kelvin(runs, member);
    effect.per_kelvin.*member = line.slope;
    effect.deviation.*member = deviation_of_taxels(runs, member);
    effect.u.*member = std::fmax(line.repeats_u, line.runs_u);
    // Words and degrees of freedom are those of the share, which comes last.
    effect.from_repeats = !(line.runs_u > line.repeats_u) && !std::isnan(line.repeats_u);
    effect.dof = effect.from_repeats ? line.repeats_dof : line.runs_dof;
  }
}

}  // namespace

double mean_temperature_c(const Dataset& dataset) { return mean_of(dataset.temperatures_c); }

bool at_another_temperature(std::span<const double> calibration_c, std::span<const double> other_c) {
  return std::abs(mean_of(other_c) - mean_of(calibration_c)) >= kOtherTemperatureK;
}

double TemperatureEffect::width_v(double over_zero_v) const {
  const double coefficient = per_kelvin.zero_v + per_kelvin.share * over_zero_v;
  const double squares = coefficient * coefficient + u.zero_v * u.zero_v + deviation.zero_v * deviation.zero_v +
                         over_zero_v * over_zero_v * (u.share * u.share + deviation.share * deviation.share);
  return half_width_c() * std::sqrt(squares);
}

std::string TemperatureEffect::display_text() const {
  if (!assessed()) return {};
  const auto [coldest, warmest] = std::ranges::minmax(temperature_c);
  return fmt::format(
      "{} runs at {:.1f} to {:.1f} °C: output over its zero ({:+.4f} ± {:.4f}) % a kelvin, zero ({:+.3f} ± {:.3f}) mV "
      "a "
      "kelvin (standard uncertainties from the {}, {:.0f} degrees of freedom); single taxels ± {:.4f} % a kelvin; "
      "taken "
      "over {:.2f} to {:.2f} °C, the readings of this run, and the thermometer's step of {:.3f} °C{}. Made within a "
      "day, "
      "and mounted once as far as the runs show; {}",
      temperature_c.size(), coldest, warmest, 100.0 * per_kelvin.share, 100.0 * u.share, 1e3 * per_kelvin.zero_v,
      1e3 * u.zero_v, from_repeats ? "scatter of the repeats" : "scatter of the runs about the line", dof,
      100.0 * deviation.share, low_c, high_c, resolution_c,
      thermometer_u_c > 0.0 ? fmt::format(", its own calibration with u = {:.3f} K", thermometer_u_c)
                            : std::string("; the thermometer's own calibration is not stated"),
      temperature_c.size() == 2
          ? "what else changed between two runs, such as conditioning or rest, cannot be distinguished from the "
            "temperature and "
            "is contained"
          : "what changed between the runs beside the temperature is contained in the scatter about the line");
}

TemperatureEffect temperature_effect_of(const Dataset& measured, std::span<const Dataset> others,
                                        const SensorModel& fit, double resolution_c, double thermometer_u_c) {
  TemperatureEffect effect;
  if (others.empty()) return effect;
  if (measured.temperatures_c.empty()) {
    effect.not_assessed = "the run has no temperature readings";
    return effect;
  }
  const Fitted fitted(fit);
  const Dataset calibration = as_modelled(measured, fit);
  const auto own = thermal_run(calibration, calibration, fitted);
  if (!own) {
    effect.not_assessed = "this run has no full loop of at least five levels";
    return effect;
  }
  std::vector<ThermalRun> runs = {*own};
  bool without_readings = false;
  for (const Dataset& other : others) {
    check_same_sensor(other, fit);
    without_readings = without_readings || other.temperatures_c.empty();
    // A hold or a ramp of its own pace is no loop to compare with.
    if (other.temperatures_c.empty() || !held_frames_of(other).empty()) continue;
    if (auto run = thermal_run(as_modelled(other, fit), calibration, fitted)) runs.push_back(std::move(*run));
  }
  for (const ThermalRun& run : runs) {
    effect.temperature_c.push_back(run.temperature_c);
    effect.change.push_back(run.change);
  }
  const auto [coldest, warmest] = std::ranges::minmax(effect.temperature_c);
  if (warmest - coldest < kOtherTemperatureK) {
    if (without_readings)
      effect.not_assessed = "the further runs have no temperature readings";
    else if (runs.size() > 1)
      effect.not_assessed = fmt::format("the runs given are at one temperature: {:.1f} to {:.1f} °C, {:g} K are needed",
                                        coldest, warmest, kOtherTemperatureK);
    else
      effect.not_assessed = "no further run sweeps five levels of this run's loop at another temperature";
    return effect;
  }
  keep_lines(runs, effect);
  if (!(effect.dof > 0.0)) {
    effect.not_assessed =
        "two runs of one repeat each: what changes from repeat to repeat is not known, nor what a kelvin changes "
        "beside it";
    return effect;
  }
  const auto [low, high] = std::ranges::minmax(measured.temperatures_c);
  effect.low_c = low;
  effect.high_c = high;
  effect.resolution_c = resolution_c;
  effect.thermometer_u_c = thermometer_u_c;
  effect.not_assessed.clear();
  return effect;
}

}  // namespace tactbench::analysis
