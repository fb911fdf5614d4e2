#include "devices/pressure/simulated_controller.h"

#include <poll.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <array>
#include <span>
#include <utility>

#include "devices/device.h"

namespace tactbench::devices {
namespace {

constexpr double kFullScaleVolts = 10.0;
constexpr double kBeyondFullScale = 1.02;  // of full scale: set-points above are refused

}  // namespace

SimulatedController::SimulatedController(const SerialControllerOptions& options, Psi full_scale, ChamberPort& chamber,
                                         FaultInjector inject)
    : options_(options),
      full_scale_(full_scale),
      chamber_(chamber),
      inject_(std::move(inject)),
      stop_(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)) {
  if (stop_ < 0) {
    throw Fault("TB-SIM-LISTEN", "simulated controller",
                "starting the simulated controller: no event descriptor is left", "Raise the limit of open files.");
  }
  start();
}

SimulatedController::~SimulatedController() {
  stop();
  ::close(stop_);
}

void SimulatedController::start() {
  work_.emplace();
  thread_ = work_->thread([this] { serve(); });
}

void SimulatedController::stop() {
  std::uint64_t count = 1;
  [[maybe_unused]] ssize_t done = ::write(stop_, &count, sizeof count);
  thread_.join();
  done = ::read(stop_, &count, sizeof count);
}

void SimulatedController::unplug() {
  stop();
  end_.hang_up();
  start();
}

void SimulatedController::plug_in() {
  stop();
  line_.clear();
  late_.clear();
  end_.plug_in();
  start();
}

void SimulatedController::serve() {
  for (;;) {
    pollfd descriptors[] = {{stop_, POLLIN, 0}, {end_.descriptor(), POLLIN, 0}};
    if (work_->wait(descriptors) < 0) continue;
    if (descriptors[0].revents != 0) return;
    if (descriptors[1].revents == 0) continue;
    std::array<std::uint8_t, 256> bytes{};
    const std::size_t got = end_.receive(bytes);
    for (const std::uint8_t byte : std::span(bytes).first(got)) {
      if (byte == kLineEnd) {
        answer(std::exchange(line_, {}));
      } else if (line_.size() < kMaxLineBytes) {
        line_ += static_cast<char>(byte);
      }
    }
  }
}

bool SimulatedController::carry_out(const ControllerRequest& request) {
  switch (request.act) {
    case ControllerAct::kSetpoint: {
      if (!(request.setpoint >= 0.0 && request.setpoint <= kBeyondFullScale * full_scale_.value())) return false;
      setpoint_ = request.setpoint;
      const Volts volts(kFullScaleVolts * setpoint_ / full_scale_.value());
      chamber_.drive(volts, Nanoseconds::max(), volts);
      return true;
    }
    case ControllerAct::kExhaust:
    case ControllerAct::kCancel:
      if (!options_.exhausts) return false;
      exhausting_ = request.act == ControllerAct::kExhaust;
      chamber_.dump(exhausting_);
      return true;
    default:
      return true;
  }
}

void SimulatedController::answer(const std::string& line) {
  const InjectedFault injected = inject_ ? inject_() : InjectedFault::kNone;
  ++requests_;
  if (injected == InjectedFault::kUnplugged) return end_.hang_up();
  if (!line.starts_with(options_.unit)) return;
  const auto send = [this](const std::string& text) {
    end_.send(std::span(reinterpret_cast<const std::uint8_t*>(text.data()), text.size()));
  };
  send(std::exchange(late_, {}));
  const auto request = decode_request(line, options_.unit);
  if (!request || injected == InjectedFault::kRefused || !carry_out(*request)) return send(std::string("?") + kLineEnd);
  ControllerFrame frame{chamber_.feedback().value() / kFullScaleVolts * full_scale_.value(), setpoint_, {}};
  if (exhausting_) frame.status.emplace_back("EXH");
  std::string text = encode_answer(options_.unit, frame, options_.decimals);
  if (injected == InjectedFault::kSilent) return;
  if (injected == InjectedFault::kCorrupt) text.at(3) = '#';
  if (injected == InjectedFault::kLate) {
    late_ = text;
  } else {
    send(text);
  }
}

}  // namespace tactbench::devices
