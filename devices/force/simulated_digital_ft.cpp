#include "devices/force/simulated_digital_ft.h"

#include <poll.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <map>
#include <thread>
#include <utility>
#include <vector>

#include "devices/device.h"
#include "devices/force/ati_matrix.h"
#include "devices/wire/ends/end_activity.h"
#include "devices/wire/ends/stream_end.h"

namespace tactbench::devices {
namespace {

constexpr std::uint8_t kUnit = 10;
constexpr std::size_t kSentJamBytes = 14;
constexpr std::size_t kReadBytes = 8;
constexpr Nanoseconds kMillisecond = std::chrono::milliseconds(1);
constexpr int kSamplesPerMillisecond = 7;
constexpr int kSamplesPerWrench = 100;
constexpr int kServedRegister = 0x001D;

}  // namespace

class SimulatedDigitalFt::Server {
 public:
  Server(const DigitalCalibration& calibration, ForcePort& port, bool free_running, SimulatedDigitalFtFaults faults)
      : port_(port),
        faults_(std::move(faults)),
        stop_(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)),
        free_running_(free_running) {
    if (stop_ < 0) throw Fault("TB-SIM-LISTEN", "simulated Digital F/T", "no descriptor is left", "Close programs.");
    Matrix6 matrix;
    for (int row = 0; row < 6; ++row) {
      const double counts = row < 3 ? calibration.counts_per_force : calibration.counts_per_torque / 1000.0;
      for (int gauge = 0; gauge < 6; ++gauge) {
        const auto& values = calibration.matrix[static_cast<std::size_t>(row)];
        matrix(row, gauge) = static_cast<double>(values[static_cast<std::size_t>(gauge)]) / counts;
      }
    }
    gauges_per_load_ = matrix.inverse();
    for (int i = 0; i < 12; ++i) registers_[i] = calibration.gains_and_offsets[static_cast<std::size_t>(i)];
    registers_[kServedRegister] = 0;
    const auto bytes = encode(calibration);
    for (std::size_t i = 0; i < bytes.size(); i += 2) {
      registers_[kDigitalCalibrationRegister + static_cast<int>(i / 2)] =
          static_cast<std::uint16_t>(bytes[i] << 8 | bytes[i + 1]);
    }
    thread_ = work_.thread([this] { serve(); });
  }
  ~Server() {
    const std::uint64_t one = 1;
    [[maybe_unused]] const ssize_t written = ::write(stop_, &one, sizeof one);
    thread_.join();
    ::close(stop_);
  }
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;
  [[nodiscard]] const std::string& path() const { return line_.path(); }

 private:
  void serve() {
    for (;;) {
      pollfd descriptors[] = {{stop_, POLLIN, 0}, {line_.master(), POLLIN, 0}};
      if (work_.wait(descriptors, streaming_ ? std::optional(kMillisecond) : std::nullopt) < 0) continue;
      if (descriptors[0].revents != 0) return;
      if (descriptors[1].revents != 0) attend();
      for (int i = 0; streaming_ && i < kSamplesPerMillisecond; ++i) send_sample();
    }
  }

  void attend() {
    std::array<std::uint8_t, 256> bytes{};
    const ssize_t got = ::read(line_.master(), bytes.data(), bytes.size());
    if (got <= 0) return;
    if (faults_.echoes) send(std::span(bytes).first(static_cast<std::size_t>(got)));
    received_.insert(received_.end(), bytes.begin(), bytes.begin() + got);
    if (streaming_) {
      if (received_.size() < kSentJamBytes) return;  // only a jam is received
      streaming_ = false;
      received_.clear();
    }
    while (!received_.empty() && answer()) {
    }
  }

  // Takes the first request, or a byte that begins none; false: more bytes are needed.
  bool answer() {
    const std::size_t size = received_.size() < 2 ? 2 : received_[1] == 3 ? kReadBytes : received_[1] == 0x46 ? 5 : 1;
    if (received_[0] != kUnit || size == 1) {
      received_.erase(received_.begin());
      return true;
    }
    if (received_.size() < size) return false;
    const std::vector<std::uint8_t> request(received_.begin(), received_.begin() + static_cast<std::ptrdiff_t>(size));
    received_.erase(received_.begin(), received_.begin() + static_cast<std::ptrdiff_t>(size));
    if (!rtu_frame_is_whole(request)) return true;  // a slave is silent to a damaged frame
    if (request[1] == 3) {
      read_registers(request[2] << 8 | request[3], request[4] << 8 | request[5]);
    } else if (request[2] == 0x55) {
      reply({kUnit, 0x46, 1});
      streaming_ = measure();
    }
    return true;
  }

  void read_registers(int address, int count) {
    if (count < 1 || count > 125) return reply({kUnit, 0x83, 3});
    std::vector<std::uint8_t> body{kUnit, 3, static_cast<std::uint8_t>(2 * count)};
    for (int i = address; i < address + count; ++i) {
      const auto found = registers_.find(i);
      if (found == registers_.end()) return reply({kUnit, 0x83, 2});
      body.push_back(static_cast<std::uint8_t>(found->second >> 8U));
      body.push_back(static_cast<std::uint8_t>(found->second & 0xFFU));
    }
    reply(body);
  }

  void reply(const std::vector<std::uint8_t>& body) { send(rtu_frame(body)); }

  // A line that nobody reads drops what does not fit.
  void send(std::span<const std::uint8_t> bytes) const {
    [[maybe_unused]] const ssize_t sent = ::write(line_.master(), bytes.data(), bytes.size());
  }

  void send_sample() {
    if (free_running_ && of_wrench_ == kSamplesPerWrench) streaming_ = measure();
    if (!streaming_) return;
    ++of_wrench_;
    const long number = samples_++;
    if (faults_.silent_after_samples >= 0 && number >= faults_.silent_after_samples) return;
    DigitalSample sample = sample_;
    sample.error = number == faults_.error_sample || injected_ == InjectedFault::kSaturated;
    const auto bytes = encode(sample);
    send(number == faults_.damaged_sample ? std::span(bytes).subspan(1) : std::span(bytes));
  }

  // False: physics failed, and the sensor falls silent.
  bool measure() {
    of_wrench_ = 0;
    injected_ = faults_.inject ? faults_.inject() : InjectedFault::kNone;
    if (injected_ == InjectedFault::kSilent) return false;
    try {
      const Wrench wrench = port_.wrench();
      Vector6 loads;
      loads << wrench.force_n[0], wrench.force_n[1], wrench.force_n[2], wrench.torque_nmm[0], wrench.torque_nmm[1],
          wrench.torque_nmm[2];
      const Vector6 gauges = gauges_per_load_ * loads;
      for (int i = 0; i < 6; ++i) {
        const double value = std::isfinite(gauges[i]) ? gauges[i] : 32767.0;
        sample_.gauges[static_cast<std::size_t>(i)] =
            static_cast<std::int16_t>(std::lround(std::clamp(value, -32768.0, 32767.0)));
      }
      return true;
    } catch (...) {
      return false;
    }
  }

  Matrix6 gauges_per_load_;
  ForcePort& port_;
  SimulatedDigitalFtFaults faults_;
  PseudoTerminal line_;
  std::map<int, std::uint16_t> registers_;
  std::vector<std::uint8_t> received_;
  long of_wrench_ = 0;  // samples sent of the last wrench
  long samples_ = 0;
  DigitalSample sample_;
  InjectedFault injected_ = InjectedFault::kNone;
  int stop_;
  const bool free_running_;
  bool streaming_ = false;
  EndActivity work_;
  std::thread thread_;
};

SimulatedDigitalFt::SimulatedDigitalFt(const DigitalCalibration& calibration, ForcePort& port, bool free_running,
                                       SimulatedDigitalFtFaults faults)
    : server_(std::make_unique<Server>(calibration, port, free_running, std::move(faults))) {}

SimulatedDigitalFt::~SimulatedDigitalFt() = default;

const std::string& SimulatedDigitalFt::path() const { return server_->path(); }

}  // namespace tactbench::devices
