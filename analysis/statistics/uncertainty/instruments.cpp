#include "analysis/statistics/uncertainty/instruments.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "analysis/json_io.h"

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

}  // namespace tactbench::analysis
