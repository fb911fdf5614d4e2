#include "analysis/statistics/reference_uncertainty.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "analysis/json_io.h"

namespace tactbench::analysis {
namespace {

using ReferenceJson = nlohmann::json;

double positive_number(const ReferenceJson& json, const char* key) {
  if (!json.contains(key) || !json[key].is_number()) return 0.0;
  const double value = json[key].get<double>();
  return std::isfinite(value) && value > 0.0 ? value : 0.0;
}

std::string text_in(const ReferenceJson& json, const char* key) {
  return json.contains(key) && json[key].is_string() ? json[key].get<std::string>() : std::string();
}

std::vector<double> numbers_in(const ReferenceJson& json, const char* key) {
  std::vector<double> numbers;
  if (!json.contains(key) || !json[key].is_array()) return numbers;
  for (const ReferenceJson& item : json[key]) {
    if (!item.is_number() || !std::isfinite(item.get<double>())) return {};
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

// One step of the converter that reads the transducer, in psi: the module's volts a count times the span's psi a volt.
double converter_step(const db::RunRecord& run, const ReferenceJson& calibration) {
  if (!calibration.contains("psi_high") || !calibration.contains("volts_high")) return 0.0;
  double volts_per_count = 0.0;
  for (const db::DeviceRecord& device : run.devices) {
    const ReferenceJson json = try_json(device.calibration_json);
    if (!json.is_object() || !json.contains("input_volts")) continue;
    const ReferenceJson& scale = json["input_volts"];
    const double counts = scale.value("raw_high", 0.0) - scale.value("raw_low", 0.0);
    // A module of inputs alone stands behind the other and is the one that reads.
    if (counts > 0.0) volts_per_count = (scale.value("high", 0.0) - scale.value("low", 0.0)) / counts;
  }
  const double volts = calibration.value("volts_high", 0.0) - calibration.value("volts_low", 0.0);
  const double psi = calibration.value("psi_high", 0.0) - calibration.value("psi_low", 0.0);
  const double step = volts > 0.0 ? volts_per_count * psi / volts : 0.0;
  return std::isfinite(step) && step > 0.0 ? step : 0.0;
}

void say_what_is_missing(ReferenceUncertainty& reference) {
  if (reference.reading_psi.empty())
    reference.certificate_missing =
        reference.independent
            ? "the bench file gives no uncertainty of the reference: state its certificate's in [reference] "
              "expanded_uncertainty_psi"
            : "there is no independent reference: the regulator's feedback stands in, whose uncertainty is not known";
  if (!(reference.drift_psi > 0.0))
    reference.drift_missing = "the bench file gives no limit for it: [reference] drift_psi";
  else if (reference.overdue)
    reference.drift_missing = fmt::format("the reference was due on {}: the stated limit of {:g} psi holds until then",
                                          reference.due, reference.drift_psi);
  if (!(reference.resolution_psi > 0.0))
    reference.resolution_missing = "neither [reference] resolution_psi nor the converter's step is kept with the run";
}

}  // namespace

double ReferenceUncertainty::certificate_u(double pressure_psi) const {
  if (reading_psi.empty()) return 0.0;
  const auto above = std::ranges::upper_bound(reading_psi, pressure_psi);
  if (above == reading_psi.begin()) return expanded_psi.front() / coverage_factor;
  if (above == reading_psi.end()) return expanded_psi.back() / coverage_factor;
  const auto i = static_cast<std::size_t>(above - reading_psi.begin());
  const double share = (pressure_psi - reading_psi[i - 1]) / (reading_psi[i] - reading_psi[i - 1]);
  return (expanded_psi[i - 1] + share * (expanded_psi[i] - expanded_psi[i - 1])) / coverage_factor;
}

double ReferenceUncertainty::largest_certificate_u() const {
  return expanded_psi.empty() ? 0.0 : *std::ranges::max_element(expanded_psi) / coverage_factor;
}

ReferenceUncertainty reference_uncertainty(const db::RunRecord& run) {
  ReferenceUncertainty reference;
  try {
    for (const db::DeviceRecord& device : run.devices) {
      if (device.role.find("reference") == std::string::npos || device.role.find("pressure") == std::string::npos)
        continue;
      const ReferenceJson json = try_json(device.calibration_json);
      if (!json.is_object()) continue;
      reference.independent = json.value("independent", true);
      reference.certificate = text_in(json, "certificate");
      reference.due = text_in(json, "due");
      read_certificate(json, reference);
      reference.drift_psi = positive_number(json, "drift_psi");
      reference.resolution_psi = positive_number(json, "resolution_psi");
      if (!(reference.resolution_psi > 0.0)) reference.resolution_psi = converter_step(run, json);
      break;
    }
  } catch (const ReferenceJson::exception&) {
    reference = ReferenceUncertainty();  // a calibration of another shape: nothing is known
  }
  // ISO dates compare as text.
  reference.overdue =
      reference.due.size() == 10 && run.started_utc.size() >= 10 && run.started_utc.substr(0, 10) > reference.due;
  say_what_is_missing(reference);
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
