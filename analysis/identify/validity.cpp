#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "analysis/identify/sensor_model.h"

namespace tactbench::analysis {
namespace {

// As kInputSlack.
constexpr double kTimeSlack = 0.1;  // of a hold or a rate

void widen(std::optional<Range>& range, double value) {
  if (!range) range = Range{value, value};
  range->widen(value);
}

std::string text_of(const Range& range, double factor) {
  return range.low == range.high ? fmt::format("{:.4g}", factor * range.low)
                                 : fmt::format("{:.4g} to {:.4g}", factor * range.low, factor * range.high);
}

}  // namespace

bool Range::contains(double value, double slack) const { return value >= low - slack && value <= high + slack; }

void Range::widen(double value) {
  low = std::min(low, value);
  high = std::max(high, value);
}

Validity validity_of(const std::vector<History>& histories, const std::vector<double>& temperatures_c) {
  Validity validity;
  for (const History& history : histories) {
    for (const double x : history.x) widen(validity.input, x);
    for (std::size_t i = 1; i < history.time_s.size(); ++i) {
      widen(validity.hold_s, history.held_s[i]);
      const double passed = history.time_s[i] - history.time_s[i - 1];
      if (passed > 0.0) widen(validity.rate, std::abs(history.x[i] - history.x[i - 1]) / passed);
    }
  }
  for (const double temperature : temperatures_c) widen(validity.temperature_c, temperature);
  return validity;
}

std::vector<std::string> outside_validity(const SensorModel& model, const Histories& used,
                                          const std::vector<std::string>& sequences, PressureUnit shown) {
  std::vector<std::string> outside;
  const auto serial = [&](const char* what, const std::string& own, const std::string& other) {
    if (!own.empty() && !other.empty() && own != other)
      outside.push_back(fmt::format("{} {} (fitted on {})", what, other, own));
  };
  serial("sensor", model.sensor_serial, used.sensor_serial);
  serial("scanner", model.scanner_serial, used.scanner_serial);
  const auto compare = [&](const char* what, const std::optional<Range>& box, const std::optional<Range>& seen,
                           double slack_low, double slack_high, const std::string& unit, double factor = 1.0) {
    if (!box || !seen || (seen->low >= box->low - slack_low && seen->high <= box->high + slack_high)) return;
    outside.push_back(fmt::format("{} {}{} (fitted at {})", what, text_of(*seen, factor), unit, text_of(*box, factor)));
  };
  const auto first = std::ranges::find_if(used.taxels, [](const auto& t) { return t.usable(); });
  const Validity seen = validity_of(named(first->score, sequences), used.temperatures_c);
  const Validity& box = model.validity;
  const double input_slack = box.input ? kInputSlack * (box.input->high - box.input->low) : 0.0;
  const bool in_psi = used.input_unit == "psi";
  const double factor = in_psi ? shown.of(1.0) : 1.0;
  const std::string input_unit = used.input_unit.empty() ? "" : " " + (in_psi ? shown.symbol() : used.input_unit);
  compare("input", box.input, seen.input, input_slack, input_slack, input_unit, factor);
  compare("hold", box.hold_s, seen.hold_s, box.hold_s ? kTimeSlack * box.hold_s->low : 0.0,
          box.hold_s ? kTimeSlack * box.hold_s->high : 0.0, " s");
  // Slower is what a hold is: its own line.
  compare("rate", box.rate, seen.rate, HUGE_VAL, box.rate ? kTimeSlack * box.rate->high : 0.0, input_unit + "/s",
          factor);
  compare("temperature", box.temperature_c, seen.temperature_c, kTemperatureSlack, kTemperatureSlack, " degC");
  return outside;
}

}  // namespace tactbench::analysis
