#include "analysis/statistics/uncertainty/reference_uncertainty.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "analysis/json_io.h"
#include "analysis/pressure_unit.h"
#include "analysis/statistics/numbers/moments.h"

namespace tactbench::analysis {
namespace {

using ReferenceJson = nlohmann::json;

double positive_number(const ReferenceJson& json, const char* key) {
  if (!json.contains(key) || !json[key].is_number()) return 0.0;
  return std::max(0.0, json[key].get<double>());  // JSON has no number that is not finite
}

std::vector<double> numbers_in(const ReferenceJson& json, const char* key) {
  std::vector<double> numbers;
  if (!json.contains(key) || !json[key].is_array()) return numbers;
  for (const ReferenceJson& item : json[key]) {
    if (!item.is_number()) return {};
    numbers.push_back(item.get<double>());
  }
  return numbers;
}

void read_certificate(const ReferenceJson& calibration, ReferenceUncertainty& reference) {
  if (!calibration.contains("correction") || !calibration["correction"].is_object()) {
    if (const double expanded = positive_number(calibration, "expanded_uncertainty_psi"); expanded > 0.0) {
      reference.reading_psi = {0.0};  // one figure for all readings, k = 2
      reference.expanded_psi = {expanded};
    }
    return;
  }
  const ReferenceJson& correction = calibration["correction"];
  reference.reading_psi = numbers_in(correction, "reading_psi");
  reference.expanded_psi = numbers_in(correction, "expanded_uncertainty_psi");
  if (const double k = positive_number(correction, "coverage_factor"); k > 0.0) reference.coverage_factor = k;
  const bool rises = std::ranges::is_sorted(reference.reading_psi, std::less_equal<>());
  const bool usable = std::ranges::all_of(reference.expanded_psi, [](double u) { return u > 0.0; });
  if (reference.reading_psi.size() == reference.expanded_psi.size() && rises && usable) return;
  reference.reading_psi.clear();
  reference.expanded_psi.clear();
}

// A correction holds from its first corrected reading to its last, and a certificate between the ends that it states.
void find_range(const ReferenceJson& calibration, const db::RunRecord& run, ReferenceUncertainty& reference) {
  const std::vector<double> stated = numbers_in(calibration, "certificate_range_psi");
  if (stated.size() == 2) reference.low_psi = stated[0], reference.high_psi = stated[1];
  TraceabilityGap beyond;
  if (calibration.contains("correction") && calibration["correction"].is_object()) {
    const std::vector<double> readings = numbers_in(calibration["correction"], "reading_psi");
    const std::vector<double> corrections = numbers_in(calibration["correction"], "correction_psi");
    if (!readings.empty() && readings.size() == corrections.size()) {
      reference.low_psi = std::max(reference.low_psi, readings.front() + corrections.front());
      reference.high_psi = std::min(reference.high_psi, readings.back() + corrections.back());
      beyond.corrected = true;
      beyond.first_reading_psi = readings.front();
      beyond.last_reading_psi = readings.back();
    }
  }
  beyond.below = !reference.holds_at(run.lowest_psi);
  beyond.above = !reference.holds_at(run.highest_psi);
  if (!(run.highest_psi > run.lowest_psi) || !(beyond.below || beyond.above)) return;
  beyond.run_low_psi = run.lowest_psi;
  beyond.run_high_psi = run.highest_psi;
  beyond.low_psi = reference.low_psi;
  beyond.high_psi = reference.high_psi;
  reference.beyond = beyond;
}

// One step of the converter that reads the transducer, in psi: the module's volts a count times the span's psi a volt.
double converter_step(const db::RunRecord& run, const ReferenceJson& calibration) {
  if (!calibration.contains("psi_high") || !calibration.contains("volts_high")) return 0.0;
  double volts_per_count = 0.0;
  for (const db::DeviceRecord& device : run.devices) {
    const ReferenceJson json = try_json(device.calibration_json);
    if (!json.is_object() || !json.contains("input_volts")) continue;
    const ReferenceJson& scale = json["input_volts"];
    const double counts = scale.value("raw_high", 0.0) - scale.value("raw_low", 0.0);
    // A separate input module comes after the output module; it is the one that reads.
    if (counts > 0.0) volts_per_count = (scale.value("high", 0.0) - scale.value("low", 0.0)) / counts;
  }
  const double volts = calibration.value("volts_high", 0.0) - calibration.value("volts_low", 0.0);
  const double psi = calibration.value("psi_high", 0.0) - calibration.value("psi_low", 0.0);
  const double step = volts > 0.0 ? volts_per_count * psi / volts : 0.0;
  return std::isfinite(step) && step > 0.0 ? step : 0.0;
}

// The rest of the chain between pressure and number.
void read_limits(const ReferenceJson& calibration, ReferenceUncertainty& reference) {
  const double volts = calibration.value("volts_high", 0.0) - calibration.value("volts_low", 0.0);
  const double psi = calibration.value("psi_high", 0.0) - calibration.value("psi_low", 0.0);
  const double psi_per_volt = volts > 0.0 && psi > 0.0 ? psi / volts : 0.0;
  constexpr std::array<std::pair<const char*, ReferencePart>, kReferenceParts> kKeys = {
      {{"input_limit_v", ReferencePart::kVoltageInput},
       {"hysteresis_psi", ReferencePart::kHysteresis},
       {"zero_psi", ReferencePart::kZero},
       {"temperature_psi", ReferencePart::kTemperature}}};
  for (const auto& [key, part] : kKeys) {
    ReferenceLimit& limit = reference.limits[static_cast<std::size_t>(part)];
    limit.half_width_psi =
        positive_number(calibration, key) * (part == ReferencePart::kVoltageInput ? psi_per_volt : 1.0);
    limit.part = chain_part(reference.covers, limit.half_width_psi, !reference.reading_psi.empty(),
                            fmt::format("[reference] {}", key));
  }
}

void set_missing_reasons(ReferenceUncertainty& reference) {
  if (reference.reading_psi.empty())
    reference.certificate_missing =
        reference.independent
            ? "the bench file gives no uncertainty of the reference: state its certificate's in [reference] "
              "expanded_uncertainty_psi"
            : "there is no independent reference: the regulator's feedback is used, whose uncertainty is not known";
  if (!(reference.drift_psi > 0.0))
    reference.drift_missing = fmt::format(
        "the bench file gives no limit for it: [reference] drift_psi{}",
        reference.overdue ? fmt::format("; the reference was overdue since {}", reference.calibration.due) : "");
  if (reference.reading_psi.empty())
    for (ReferenceLimit& limit : reference.limits)
      if (!(limit.half_width_psi > 0.0)) limit.part = {reference.certificate_missing, {}};
  if (!(reference.resolution_psi > 0.0))
    reference.resolution_missing = "neither [reference] resolution_psi nor the converter's step is kept with the run";
}

// Once the limit has run out it grows with the time since the calibration: an overdue reference never makes U smaller.
void set_drift(ReferenceUncertainty& reference, const std::string& utc) {
  const InstrumentCalibration& calibration = reference.calibration;
  const double growth = drift_growth(calibration, utc);
  reference.drift_psi = growth * reference.drift_stated_psi;
  if (!(reference.drift_psi > 0.0)) return;
  const std::string until = calibration.due.empty() ? std::string("due date not stated")
                            : reference.overdue     ? fmt::format("overdue since {}", calibration.due)
                                                    : fmt::format("until the due date, {}", calibration.due);
  reference.drift_basis =
      growth > 1.0 ? fmt::format(
                         "stated limit of {} times {:.3f}, the time since the calibration over the interval "
                         "that it is stated for ({}); {}",
                         both_units(reference.drift_stated_psi), growth,
                         calibration.calibrated_on.empty() || calibration.due.empty()
                             ? "taken as a year: calibration date and due date are not both stated"
                             : fmt::format("{} to {}", calibration.calibrated_on, calibration.due),
                         until)
                   : fmt::format("stated limit of {}, whole; {}", both_units(reference.drift_stated_psi), until);
}

}  // namespace

bool ReferenceUncertainty::holds_at(double pressure_psi) const {
  const double spare = std::isinf(high_psi) ? 0.0 : 0.01 * std::max(std::abs(low_psi), std::abs(high_psi));
  return pressure_psi >= low_psi - spare && pressure_psi <= high_psi + spare;
}

std::optional<TraceabilityGap> ReferenceUncertainty::untraced() const {
  return overdue ? TraceabilityGap{.overdue_since = calibration.due} : beyond;
}

double ReferenceUncertainty::certificate_u(double pressure_psi) const {
  if (reading_psi.empty()) return 0.0;
  const Between at = place_among(reading_psi, pressure_psi);
  return std::lerp(expanded_psi[at.low], expanded_psi[at.high], at.share) / coverage_factor;
}

double ReferenceUncertainty::largest_certificate_u() const {
  return expanded_psi.empty() ? 0.0 : *std::ranges::max_element(expanded_psi) / coverage_factor;
}

std::vector<ReferenceRow> ReferenceUncertainty::rows(double certificate_u_psi, double drift_limit_psi) const {
  std::vector<ReferenceRow> rows;
  const auto limit_of = [&](std::size_t source, double half_width_psi) {
    rows.push_back({source, half_width_psi, std::numbers::sqrt3, half_width_psi / std::numbers::sqrt3});  // 4.3.7
  };
  if (certificate_missing.empty())
    rows.push_back({0, coverage_factor * certificate_u_psi, coverage_factor, certificate_u_psi});  // 4.3.3
  if (drift_missing.empty()) limit_of(1, drift_limit_psi);
  if (resolution_missing.empty()) limit_of(2, 0.5 * resolution_psi);
  for (std::size_t part = 0; part < kReferenceParts; ++part)
    if (limits[part].half_width_psi > 0.0) limit_of(3 + part, limits[part].half_width_psi);
  return rows;
}

double ReferenceUncertainty::combined_u(double pressure_psi) const {
  std::vector<VarianceShare> shares;
  for (const ReferenceRow& row : rows(certificate_u(pressure_psi), drift_psi)) shares.push_back({row.u_psi});
  return combined_uncertainty(shares);
}

ReferenceUncertainty reference_uncertainty(const db::RunRecord& run, std::span<const InstrumentNote> notes) {
  ReferenceUncertainty reference;
  try {
    for (const db::DeviceRecord& device : run.devices) {
      if (device.role.find("reference") == std::string::npos || device.role.find("pressure") == std::string::npos)
        continue;
      const ReferenceJson json = try_json(device.calibration_json);
      if (!json.is_object()) continue;
      reference.calibration = calibration_of(device, notes);
      reference.independent = json.value("independent", true);
      read_certificate(json, reference);
      find_range(json, run, reference);
      reference.covers = covers_of(device);
      read_limits(json, reference);
      reference.drift_stated_psi = positive_number(json, "drift_psi");
      reference.resolution_psi = positive_number(json, "resolution_psi");
      if (!(reference.resolution_psi > 0.0)) reference.resolution_psi = converter_step(run, json);
      break;
    }
  } catch (const ReferenceJson::exception&) {
    reference = ReferenceUncertainty();  // a calibration of another shape: nothing is known
  }
  reference.overdue = due_state(reference.calibration, run.started_utc) == DueState::kOverdue;
  set_drift(reference, run.started_utc);
  set_missing_reasons(reference);
  return reference;
}

double scanner_step_v(const db::RunRecord& run) {
  for (const db::DeviceRecord& device : run.devices) {
    if (device.role != "tactile scanner") continue;
    const ReferenceJson json = try_json(device.calibration_json);
    if (json.is_object()) return positive_number(json, "volts_per_count");
  }
  return 0.0;
}

}  // namespace tactbench::analysis
