#include "analysis/statistics/uncertainty/instruments.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>
#include <optional>

#include "analysis/identify/sensor_model.h"
#include "analysis/json_io.h"
#include "analysis/loop.h"
#include "analysis/statistics/figures/behaviour.h"
#include "analysis/statistics/figures/levels.h"
#include "analysis/statistics/figures/time_effects.h"

namespace tactbench::analysis {
namespace {

using DeviceJson = nlohmann::ordered_json;

constexpr double kUsualIntervalDays = 365.25;
constexpr std::string_view kPlaceholder = "FILL-IN";

std::string member_text(const DeviceJson& json, const char* name) {
  const bool there = json.is_object() && json.contains(name) && json[name].is_string();
  return there ? json[name].get<std::string>() : std::string();
}

double member_number(const DeviceJson& json, const char* name) {
  const bool there = json.is_object() && json.contains(name) && json[name].is_number();
  return there ? json[name].get<double>() : 0.0;  // JSON has no number that is not finite
}

// The stated part of a typed text; problems go to `remarks`.
class StatedFields {
 public:
  StatedFields(const char* who, std::vector<std::string>& remarks) : who_(who), remarks_(remarks) {}

  std::string text(const char* field, const std::string& typed) {
    if (!is_placeholder(typed)) return typed;
    remarks_.push_back(fmt::format("{}: {} is not filled in", field, who_));
    return {};
  }

  std::string date(const char* field, const std::string& typed) {
    std::string stated = text(field, typed);
    if (stated.empty() || is_date(stated)) return stated;
    remarks_.push_back(fmt::format("{}: not a date: {}", field, stated));
    return {};
  }

 private:
  const char* who_;
  std::vector<std::string>& remarks_;
};

std::optional<StatedU> stated_u(const DeviceJson& json) {
  if (json.is_object() && json.contains("correction") && json["correction"].is_object()) {
    const DeviceJson& correction = json["correction"];
    double largest = 0.0;
    if (correction.contains("expanded_uncertainty_psi") && correction["expanded_uncertainty_psi"].is_array())
      for (const DeviceJson& item : correction["expanded_uncertainty_psi"])
        if (item.is_number()) largest = std::max(largest, item.get<double>());
    const double k = member_number(correction, "coverage_factor");
    if (largest > 0.0) return StatedU{largest, k > 0.0 ? k : 2.0, "psi", true};
  }
  for (const auto& [name, unit] :
       {std::pair("expanded_uncertainty_psi", "psi"), std::pair("expanded_uncertainty_n", "N"),
        std::pair("expanded_uncertainty_mm", "mm"), std::pair("expanded_uncertainty_c", "K")})
    if (const double expanded = member_number(json, name); expanded > 0.0) return StatedU{expanded, 2.0, unit, false};
  return {};
}

// True: they say the same, or one of them nothing.
bool agree_on(const char* field, const std::string& run, const std::string& laboratory, const char* counts,
              std::vector<std::string>& remarks) {
  if (run.empty() || laboratory.empty() || run == laboratory) return true;
  remarks.push_back(
      fmt::format("contradiction: {} {} by the run, {} by the laboratory file; {}", field, run, laboratory, counts));
  return false;
}

void add_note(InstrumentCalibration& calibration, const InstrumentNote& note) {
  constexpr const char* kRunCounts = "that of the run counts";
  StatedFields typed("the laboratory file", calibration.remarks);
  const std::string certificate = typed.text("certificate", note.certificate);
  const std::string calibrated_on = typed.date("calibrated", note.calibrated_on), due = typed.date("due", note.due);
  const bool one_certificate =
      agree_on("certificate", calibration.certificate, certificate, kRunCounts, calibration.remarks);
  const bool one_date =
      agree_on("calibrated", calibration.calibrated_on, calibrated_on, kRunCounts, calibration.remarks);
  (void)agree_on("due", calibration.due, due, "the earlier one counts", calibration.remarks);
  calibration.note = note.note;
  if (calibration.due.empty() || (!due.empty() && due < calibration.due)) calibration.due = due;
  if (!one_certificate || !one_date) return;  // it speaks of another calibration
  if (calibration.certificate.empty()) calibration.certificate = certificate;
  if (calibration.calibrated_on.empty()) calibration.calibrated_on = calibrated_on;
  calibration.calibrated_by = note.calibrated_by;
}

}  // namespace

std::string display_text(const StatedU& stated, PressureUnit unit) {
  const std::string value = stated.unit == "psi" && unit != PressureUnit(PressureUnit::kPsi)
                                ? fmt::format("{:.3g} {}", unit.of(stated.expanded), unit.symbol())
                                : fmt::format("{:g} {}", stated.expanded, stated.unit);
  return fmt::format("U {}{} (k = {:g}){}", stated.of_correction ? "at most " : "", value, stated.factor,
                     stated.of_correction ? ", of its correction" : "");
}

InstrumentCalibration calibration_of(const db::DeviceRecord& device, std::span<const InstrumentNote> notes) {
  const DeviceJson json = try_ordered_json(device.calibration_json);
  InstrumentCalibration calibration;
  StatedFields stated("the bench file", calibration.remarks);
  calibration.role = device.role;
  calibration.model = stated.text("model", device.model);
  calibration.serial = stated.text("serial", device.serial);
  calibration.certificate = stated.text("certificate", member_text(json, "certificate"));
  calibration.calibrated_on = stated.date("calibrated", member_text(json, "calibrated"));
  calibration.due = stated.date("due", member_text(json, "due"));
  calibration.stated_u = stated_u(json);
  const auto note = std::ranges::find(notes, device.serial, &InstrumentNote::serial);
  if (note != notes.end() && !calibration.serial.empty()) add_note(calibration, *note);
  return calibration;
}

DueState due_state(const InstrumentCalibration& calibration, std::string_view utc) {
  const auto due = day_of(calibration.due), day = day_of(utc);
  if (!due) return DueState::kNotStated;
  return day && *day > *due ? DueState::kOverdue : DueState::kInDate;
}

double drift_growth(const InstrumentCalibration& calibration, std::string_view utc) {
  const auto calibrated = day_of(calibration.calibrated_on), due = day_of(calibration.due), day = day_of(utc);
  if (!day || (!calibrated && !due)) return 1.0;
  const auto days = [](auto from, auto to) { return static_cast<double>((to - from).count()); };
  double interval = calibrated && due ? days(*calibrated, *due) : kUsualIntervalDays;
  if (!(interval > 0.0)) interval = kUsualIntervalDays;
  const double since = due ? interval + days(*due, *day) : days(*calibrated, *day);
  return std::max(1.0, since / interval);
}

std::optional<std::chrono::sys_days> day_of(std::string_view text) {
  if (text.size() < 10 || (text.size() > 10 && text[10] != 'T') || text[4] != '-' || text[7] != '-')
    return std::nullopt;
  std::array<int, 3> numbers{};  // year, month, day
  for (std::size_t i = 0; i < 10; ++i) {
    if (i == 4 || i == 7) continue;
    if (text[i] < '0' || text[i] > '9') return std::nullopt;
    int& number = numbers[i < 4 ? 0 : i < 7 ? 1 : 2];
    number = 10 * number + (text[i] - '0');
  }
  const std::chrono::year_month_day date{std::chrono::year(numbers[0]),
                                         std::chrono::month(static_cast<unsigned>(numbers[1])),
                                         std::chrono::day(static_cast<unsigned>(numbers[2]))};
  if (!date.ok()) return std::nullopt;
  return std::chrono::sys_days(date);
}

bool is_date(std::string_view text) { return text.size() == 10 && day_of(text).has_value(); }

bool is_placeholder(std::string_view text) { return text.find(kPlaceholder) != std::string_view::npos; }

std::string without_placeholders(const std::string& calibration_json) {
  if (!is_placeholder(calibration_json)) return calibration_json;
  DeviceJson json = try_ordered_json(calibration_json);
  if (!json.is_object()) return {};
  DeviceJson kept = DeviceJson::object();
  for (const auto& [name, value] : json.items())
    if (!is_placeholder(printable_json(value))) kept[name] = value;
  return printable_json(kept);
}

std::string scanner_serial_of(const db::RunRecord& run, const std::optional<db::SensorRecord>& sensor) {
  for (const db::DeviceRecord& device : run.devices)
    if (device.role.find("scanner") != std::string::npos && !device.serial.empty()) return device.serial;
  if (!run.scanner_serial.empty() || !sensor) return run.scanner_serial;
  return sensor->scanner_serial;
}

std::string display_text(const TraceabilityGap& untraced, PressureUnit unit) {
  if (!untraced.overdue_since.empty()) return "reference overdue since " + untraced.overdue_since;
  const auto at = [&](double psi) { return unit.short_text(psi); };
  const std::string covering = untraced.corrected
                                   ? fmt::format("correction (readings of {})",
                                                 unit.short_span(untraced.first_reading_psi, untraced.last_reading_psi))
                                   : std::string("certificate");
  return fmt::format("levels {}{}{} are not traceable: the run goes from {}, the reference's {} covers {}",
                     untraced.below ? "below " + at(untraced.low_psi) : "",
                     untraced.below && untraced.above ? " and " : "",
                     untraced.above ? "above " + at(untraced.high_psi) : "",
                     unit.short_span(untraced.run_low_psi, untraced.run_high_psi), covering,
                     unit.short_span(untraced.low_psi, untraced.high_psi));
}

namespace {

using InstrumentJson = nlohmann::json;

double limit_in(const InstrumentJson& json, const std::string& key) {
  if (!json.is_object() || !json.contains(key) || !json[key].is_number()) return 0.0;
  return std::max(0.0, json[key].get<double>());  // JSON has no number that is not finite
}

}  // namespace

CertificateCovers covers_of(const db::DeviceRecord& device) {
  const InstrumentJson json = try_json(device.calibration_json);
  if (!json.is_object() || !json.contains("certificate_covers") || !json["certificate_covers"].is_string())
    return CertificateCovers::kNotStated;
  const std::string word = json["certificate_covers"].get<std::string>();
  return word == "chain"        ? CertificateCovers::kChain
         : word == "transducer" ? CertificateCovers::kTransducer
                                : CertificateCovers::kNotStated;
}

const char* display_text(CertificateCovers covers) {
  return covers == CertificateCovers::kChain        ? "the whole chain"
         : covers == CertificateCovers::kTransducer ? "the transducer alone"
                                                    : "not stated";
}

ChainPart chain_part(CertificateCovers covers, double half_width, bool known, std::string_view key) {
  if (half_width > 0.0) return {};
  if (!known) return {"no U of a certificate is stated, which could contain it", {}};
  if (covers == CertificateCovers::kChain) return {{}, "contained in the certificate, which covers the whole chain"};
  if (covers == CertificateCovers::kTransducer)
    return {fmt::format("the bench file gives no limit for it: {}", key), {}};
  return {"not recorded what the certificate covers, the whole chain or the transducer alone", {}};
}

double InstrumentUncertainty::u() const {
  double squares = 0.0;
  for (const InstrumentRow& row : rows)
    if (row.assessed()) squares += row.u() * row.u();
  return std::sqrt(squares);
}

bool InstrumentUncertainty::complete() const {
  return !rows.empty() && std::ranges::all_of(rows, [](const InstrumentRow& row) { return row.part.missing.empty(); });
}

InstrumentUncertainty instrument_uncertainty(const db::RunRecord& run, std::string_view role,
                                             std::span<const InstrumentNote> notes) {
  InstrumentUncertainty out;
  const auto device =
      std::ranges::find_if(run.devices, [&](const db::DeviceRecord& record) { return record.role.starts_with(role); });
  if (device == run.devices.end()) return out;
  const bool force = role.starts_with("force");
  const std::string ending = force ? "_n" : "_c", table = force ? "[force]" : "[[environment.sensor]]";
  const InstrumentJson json = try_json(device->calibration_json);
  out.unit = force ? "N" : "K";
  out.covers = covers_of(*device);
  const double expanded = limit_in(json, "expanded_uncertainty" + ending);
  const double drift = limit_in(json, "drift" + ending), input = limit_in(json, "input_limit" + ending);
  const auto not_stated = [&](const char* key) {
    return ChainPart{fmt::format("the bench file gives no limit for it: {} {}{}", table, key, ending), {}};
  };
  out.rows.push_back(
      {"certificate", "normal", expanded, 2.0, expanded > 0.0 ? ChainPart() : not_stated("expanded_uncertainty")});
  out.rows.push_back({"drift", "rectangular", drift * drift_growth(calibration_of(*device, notes), run.started_utc),
                      std::numbers::sqrt3, drift > 0.0 ? ChainPart() : not_stated("drift")});
  out.rows.push_back({"input that reads it", "rectangular", input, std::numbers::sqrt3,
                      chain_part(out.covers, input, expanded > 0.0, table + " input_limit" + ending)});
  return out;
}

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
