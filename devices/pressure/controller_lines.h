// Codec of a serial pressure controller with the protocol of Alicat: a request is the unit's letter, a command and a
// carriage return ("AS12.34\r"); an answer is the letter, then numbers and status words separated by spaces ("A +012.34
// +012.34 EXH\r"); "?" is a refusal. Bytes to values and back, in psi, no I/O. Poll, S and C as in Alicat's manuals
// (M-Series, 2023, "Quick Command Reference"); E and the words of status from memory. Not verified on hardware.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace tactbench::devices {

inline constexpr char kLineEnd = '\r';
inline constexpr std::size_t kMaxLineBytes = 256;  // a longer text is not a line

enum class ControllerAct { kPoll, kSetpoint, kExhaust, kCancel };  // cancel: ends an exhaust or a hold

struct ControllerRequest {
  ControllerAct act = ControllerAct::kPoll;
  double setpoint = 0.0;
};
[[nodiscard]] std::string encode_request(char unit, const ControllerRequest& request, int decimals);
// `line` without its end. None: for another unit, or an unknown command.
[[nodiscard]] std::optional<ControllerRequest> decode_request(std::string_view line, char unit);

struct ControllerFrame {
  double pressure = 0.0, setpoint = 0.0;
  std::vector<std::string> status;  // EXH: exhausting; HLD: valves held; POV: pressure beyond the range; ADC: defect
  [[nodiscard]] bool has(std::string_view word) const;
};
struct ControllerFields {  // places in an answer, counted from 1 after the letter
  int pressure = 1, setpoint = 2;
};
// The answer of the simulated controller, with fields 1 and 2.
[[nodiscard]] std::string encode_answer(char unit, const ControllerFrame& frame, int decimals);

struct ControllerAnswer {
  bool refused = false;
  std::optional<ControllerFrame> frame;  // none, if not refused: damaged, or from another unit
};
[[nodiscard]] ControllerAnswer decode_answer(std::string_view line, char unit, const ControllerFields& fields);

}  // namespace tactbench::devices
