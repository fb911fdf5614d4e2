// A pressure controller on a serial line (controller_lines.h): it regulates by itself, and its own transducer is the
// feedback. It has no watchdog: if the line fails, it keeps its set-point. Not verified on hardware.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "devices/pressure/controller_lines.h"
#include "devices/pressure/options.h"
#include "devices/pressure/pressure_source.h"
#include "devices/wire/byte_stream.h"

namespace tactbench::devices {

// Faults in addition to those of Actuator and ByteStream (device "regulator"): TB-CONTROLLER-TIMEOUT, -PROTOCOL (the
// answer is damaged), -REFUSED, -READBACK (it does not hold the set-point that was sent), -STATUS (its transducer is
// out of range or defective). All except the last disarm it.
class SerialController final : public PressureSource {
 public:
  // `open` opens the line at the first exchange and after a loss.
  SerialController(std::function<std::unique_ptr<ByteStream>()> open, RegulatorOptions regulator,
                   SerialControllerOptions options, Clock& clock);
  void arm() override;
  void disarm() noexcept override { armed_ = false; }
  [[nodiscard]] bool armed() const override { return armed_; }
  // Returns the set-point in steps of its last decimal. One exchange, two after a vent.
  std::uint16_t command(Psi pressure) override;
  void keep_alive() override;
  [[nodiscard]] PressureReading feedback() override;
  [[nodiscard]] Nanoseconds last_fed() const override { return last_fed_; }
  // Commands 0 psi, then opens the exhaust valve if it has one; at most two attempts of two exchanges.
  [[nodiscard]] bool vent() noexcept override;
  [[nodiscard]] Identity identity() const override;
  [[nodiscard]] std::uint64_t exchanges() const override { return exchanges_; }

 private:
  ControllerFrame ask(const ControllerRequest& request);
  ControllerFrame exchange(const ControllerRequest& request);
  std::string read_line(const std::string& asked);
  void set(Psi pressure);
  void check_holds(const ControllerFrame& frame);
  void refresh();
  std::function<std::unique_ptr<ByteStream>()> open_;
  RegulatorOptions regulator_;
  SerialControllerOptions options_;
  Clock& clock_;
  std::unique_ptr<ByteStream> stream_;
  ControllerFrame frame_;
  Nanoseconds frame_time_{-1}, last_fed_{-1};
  Psi setpoint_{0.0};
  bool armed_ = false;
  std::uint64_t exchanges_ = 0;
};

}  // namespace tactbench::devices
