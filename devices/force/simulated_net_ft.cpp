#include "devices/force/simulated_net_ft.h"

#include <netinet/in.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <thread>
#include <utility>
#include <vector>

#include "devices/device.h"
#include "devices/force/force_checks.h"
#include "devices/force/rdt_record.h"
#include "devices/wire/ends/end_activity.h"
#include "devices/wire/ends/page_server.h"
#include "devices/wire/ends/stream_end.h"

namespace tactbench::devices {
namespace {

using SteadyTime = std::chrono::steady_clock::time_point;
using RdtBytes = std::array<std::uint8_t, kRdtRecordBytes>;
constexpr std::size_t kSendBatch = 64;

std::int32_t counts(double value) {
  constexpr double kLow = std::numeric_limits<std::int32_t>::min();
  constexpr double kHigh = std::numeric_limits<std::int32_t>::max();
  return static_cast<std::int32_t>(std::isnan(value) ? kLow : std::clamp(std::round(value), kLow, kHigh));
}

}  // namespace

class SimulatedNetFt::Server {
 public:
  Server(SimulatedNetFtOptions options, ForcePort& port)
      : options_(std::move(options)),
        port_(port),
        pages_(options_.http_port, "/netftapi2.xml", format_netft_page(options_.page), "simulated Net F/T"),
        rdt_(bind_loopback(SOCK_DGRAM, options_.rdt_port, "simulated Net F/T")),
        stop_(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)) {
    if (stop_ < 0) {
      ::close(rdt_.socket);
      throw Fault("TB-SIM-LISTEN", "simulated Net F/T", "no descriptor is left for its thread", "Close programs.");
    }
    thread_ = work_.thread([this] { serve(); });
  }
  ~Server() {
    const std::uint64_t one = 1;
    [[maybe_unused]] const ssize_t written = ::write(stop_, &one, sizeof one);
    thread_.join();
    ::close(stop_);
    ::close(rdt_.socket);
  }
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

  [[nodiscard]] int rdt_port() const { return rdt_.port; }
  [[nodiscard]] int http_port() const { return pages_.port(); }

 private:
  struct Endless {
    sockaddr_in client{};
    std::uint32_t sequence = 0;
    std::uint64_t sent = 0;
    SteadyTime start;
  };

  void serve() {
    std::vector<pollfd> descriptors;
    for (;;) {
      descriptors.assign({{stop_, POLLIN, 0}, {rdt_.socket, POLLIN, 0}});
      pages_.add_to(descriptors);
      std::optional<Nanoseconds> left;
      if (endless_) left = std::max(Nanoseconds(0), Nanoseconds(due(endless_->sent + 1) - now()));
      if (work_.wait(descriptors, left) < 0) continue;
      if (descriptors[0].revents != 0) return;
      if (descriptors[1].revents != 0) attend();
      pages_.serve();
      if (endless_) keep_pace();
    }
  }

  static SteadyTime now() { return std::chrono::steady_clock::now(); }
  [[nodiscard]] SteadyTime due(std::uint64_t record) const {
    const double seconds = static_cast<double>(record) / options_.page.records_per_second;
    return endless_->start + Nanoseconds(static_cast<Nanoseconds::rep>(seconds * 1e9));
  }

  void attend() {
    std::array<std::uint8_t, 2 * kRdtRequestBytes> bytes{};
    sockaddr_in client{};
    socklen_t size = sizeof client;
    const ssize_t got =
        ::recvfrom(rdt_.socket, bytes.data(), bytes.size(), 0, reinterpret_cast<sockaddr*>(&client), &size);
    if (got < 0) return;  // an earlier client is gone, or there was nothing to read
    const auto request = decode_rdt_request(std::span(bytes).first(static_cast<std::size_t>(got)));
    if (!request) return;  // the sensor does not answer unknown requests
    switch (request->command) {
      case RdtCommand::kStartRealtime:
      case RdtCommand::kStartBuffered:
      case RdtCommand::kStartMultiUnit:
        endless_.reset();
        if (request->count == 0) {
          endless_ = Endless{client, 0, 0, now()};
        } else {
          answer(client, request->count);
        }
        break;
      case RdtCommand::kStop:
        endless_.reset();
        break;
      case RdtCommand::kSetBias:
        if (const auto loads = measure()) bias_ = *loads;
        break;
      case RdtCommand::kResetLatch:
        break;
    }
  }

  // All requested records together: process time does not advance while they are requested.
  void answer(const sockaddr_in& client, std::uint32_t count) {
    std::uint32_t sequence = 0;
    while (sequence < count) {
      const auto batch = std::min<std::uint32_t>(count - sequence, kSendBatch);
      send(client, sequence, batch);
      sequence += batch;
    }
  }

  // Sends the records that are due. After a delay of more than a second it goes on from now, as if it had rested.
  void keep_pace() {
    const SteadyTime time = now();
    if (time - due(endless_->sent) > std::chrono::seconds(1)) {
      endless_->start = time;
      endless_->sent = 0;
    }
    while (due(endless_->sent + 1) <= time) {
      send(endless_->client, endless_->sequence, 1);
      ++endless_->sequence;
      ++endless_->sent;
    }
  }

  // Counts without bias; empty when physics fails: the sensor falls silent.
  std::optional<std::array<double, 6>> measure() {
    try {
      const Wrench wrench = port_.wrench();
      std::array<double, 6> loads{};
      for (std::size_t i = 0; i < 3; ++i) {
        loads[i] = wrench.force_n[i] / options_.page.newtons_per_count();
        loads[i + 3] = wrench.torque_nmm[i] / options_.page.newton_millimetres_per_count();
      }
      return loads;
    } catch (...) {
      return std::nullopt;
    }
  }

  // Sends a stream's records from `sequence + 1` on in one call.
  void send(const sockaddr_in& client, std::uint32_t sequence, std::uint32_t count) {
    const SimulatedNetFtFaults& faults = options_.faults;
    const InjectedFault injected = faults.inject ? faults.inject() : InjectedFault::kNone;
    if (injected == InjectedFault::kSilent) return;
    packets_.clear();
    std::optional<RdtBytes> held;
    for (std::uint32_t i = 0; i < count; ++i) {
      const long number = records_++;
      const auto loads = measure();
      if (!loads || (faults.silent_after_records >= 0 && number >= faults.silent_after_records)) continue;
      const bool stands = faults.stall_from_record >= 0 && number >= faults.stall_from_record;
      if (!stands && injected != InjectedFault::kStale) ++sample_;
      if (number == faults.drop_record) continue;
      const bool bad = number == faults.status_record || injected == InjectedFault::kSaturated;
      RdtRecord record{sequence + i + 1, sample_, bad ? faults.status_bits : 0, {}};
      for (std::size_t axis = 0; axis < 6; ++axis) record.counts[axis] = counts((*loads)[axis] - bias_[axis]);
      if (number == faults.late_record) {
        held = encode(record);
        continue;
      }
      packets_.push_back(encode(record));
      if (held) packets_.push_back(*std::exchange(held, std::nullopt));
    }
    if (held) packets_.push_back(*held);
    send_packets(client);
  }

  // What the network does not take is lost, as any datagram may be.
  void send_packets(sockaddr_in client) {
    std::array<iovec, kSendBatch> parts{};
    std::array<mmsghdr, kSendBatch> messages{};
    for (std::size_t i = 0; i < packets_.size(); ++i) {
      parts[i] = {packets_[i].data(), packets_[i].size()};
      messages[i].msg_hdr.msg_name = &client;
      messages[i].msg_hdr.msg_namelen = sizeof client;
      messages[i].msg_hdr.msg_iov = &parts[i];
      messages[i].msg_hdr.msg_iovlen = 1;
    }
    [[maybe_unused]] const int sent =
        ::sendmmsg(rdt_.socket, messages.data(), static_cast<unsigned>(packets_.size()), 0);
  }

  SimulatedNetFtOptions options_;
  ForcePort& port_;
  PageServer pages_;
  BoundSocket rdt_;
  int stop_;
  std::optional<Endless> endless_;
  std::array<double, 6> bias_{};
  std::uint32_t sample_ = 0;
  long records_ = 0;
  std::vector<RdtBytes> packets_;
  EndActivity work_;
  std::thread thread_;
};

SimulatedNetFt::SimulatedNetFt(SimulatedNetFtOptions options, ForcePort& port)
    : server_(std::make_unique<Server>(std::move(options), port)) {}

SimulatedNetFt::~SimulatedNetFt() = default;

int SimulatedNetFt::rdt_port() const { return server_->rdt_port(); }
int SimulatedNetFt::http_port() const { return server_->http_port(); }

}  // namespace tactbench::devices
