#include "devices/pressure/controller_lines.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>

namespace tactbench::devices {
namespace {

std::optional<double> controller_number(std::string_view text) {
  if (text.starts_with('+')) text.remove_prefix(1);  // from_chars() takes no plus
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value)) return std::nullopt;
  return value;
}

std::vector<std::string_view> controller_words(std::string_view line) {
  std::vector<std::string_view> words;
  for (std::size_t at = line.find_first_not_of(' '); at != std::string_view::npos;) {
    const std::size_t end = std::min(line.find(' ', at), line.size());
    words.push_back(line.substr(at, end - at));
    at = line.find_first_not_of(' ', end);
  }
  return words;
}

}  // namespace

std::string encode_request(char unit, const ControllerRequest& request, int decimals) {
  switch (request.act) {
    case ControllerAct::kSetpoint:
      return fmt::format("{}S{:.{}f}{}", unit, request.setpoint, decimals, kLineEnd);
    case ControllerAct::kExhaust:
      return fmt::format("{}E{}", unit, kLineEnd);
    case ControllerAct::kCancel:
      return fmt::format("{}C{}", unit, kLineEnd);
    default:
      return fmt::format("{}{}", unit, kLineEnd);
  }
}

std::optional<ControllerRequest> decode_request(std::string_view line, char unit) {
  if (!line.starts_with(unit)) return std::nullopt;
  line.remove_prefix(1);
  if (line.empty()) return ControllerRequest{};
  if (line == "E") return ControllerRequest{ControllerAct::kExhaust};
  if (line == "C") return ControllerRequest{ControllerAct::kCancel};
  if (line.front() != 'S') return std::nullopt;
  const std::optional<double> setpoint =
      controller_number(line.substr(std::min(line.find_first_not_of(' ', 1), line.size())));
  if (!setpoint) return std::nullopt;
  return ControllerRequest{ControllerAct::kSetpoint, *setpoint};
}

bool ControllerFrame::has(std::string_view word) const { return std::ranges::find(status, word) != status.end(); }

std::string encode_answer(char unit, const ControllerFrame& frame, int decimals) {
  // A sign, three digits, the decimals.
  const auto number = [&](double value) { return fmt::format("{:+0{}.{}f}", value, decimals + 5, decimals); };
  std::string line = fmt::format("{} {} {}", unit, number(frame.pressure), number(frame.setpoint));
  for (const std::string& word : frame.status) line += " " + word;
  return line + kLineEnd;
}

ControllerAnswer decode_answer(std::string_view line, char unit, const ControllerFields& fields) {
  const std::vector<std::string_view> words = controller_words(line);
  if (!words.empty() && words.back() == "?") return {true, std::nullopt};
  const auto last = static_cast<std::size_t>(std::max(fields.pressure, fields.setpoint));
  if (words.size() <= last || words.front() != std::string_view(&unit, 1)) return {};
  const std::optional<double> pressure = controller_number(words[static_cast<std::size_t>(fields.pressure)]);
  const std::optional<double> setpoint = controller_number(words[static_cast<std::size_t>(fields.setpoint)]);
  if (!pressure || !setpoint) return {};
  return {false,
          ControllerFrame{*pressure, *setpoint, {words.begin() + static_cast<std::ptrdiff_t>(last) + 1, words.end()}}};
}

}  // namespace tactbench::devices
