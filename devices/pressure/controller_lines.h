// Codec of a serial pressure controller in the manner of Alicat's: a request is the unit's letter, a command and a
// carriage return ("AS12.34\r"); an answer is the letter and numbers between spaces, behind them words of status
// ("A +012.34 +012.34 EXH\r"); "?" refuses. Pure bytes <-> values, in psi. Poll, S and C as in Alicat's manuals
// (M-Series, 2023, "Quick Command Reference"); E and the words of status from memory. Not verified on hardware.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace tactbench::devices {

inline constexpr char kLineEnd = '\r';
inline constexpr std::size_t kMaxLineBytes = 256;  // more is no line

enum class ControllerAct { kPoll, kSetpoint, kExhaust, kCancel };  // cancel: ends an exhaust or a hold

struct ControllerRequest {
  ControllerAct act = ControllerAct::kPoll;
  double setpoint = 0.0;
};
[[nodiscard]] std::string encode_request(char unit, const ControllerRequest& request, int decimals);
// `line` without its end. None: another unit's, or no command known here.
[[nodiscard]] std::optional<ControllerRequest> decode_request(std::string_view line, char unit);

struct ControllerFrame {
  double pressure = 0.0, setpoint = 0.0;
  std::vector<std::string> status;  // EXH: exhausting; HLD: valves held; POV: pressure beyond the range; ADC: defect
  [[nodiscard]] bool has(std::string_view word) const;
};
struct ControllerFields {  // places in an answer, counted from 1 behind the letter
  int pressure = 1, setpoint = 2;
};
// As the simulated end answers, in the fields 1 and 2.
[[nodiscard]] std::string encode_answer(char unit, const ControllerFrame& frame, int decimals);

struct ControllerAnswer {
  bool refused = false;
  std::optional<ControllerFrame> frame;  // none, and not refused: damaged, or another unit's
};
[[nodiscard]] ControllerAnswer decode_answer(std::string_view line, char unit, const ControllerFields& fields);

}  // namespace tactbench::devices
