#include "devices/stage/simulated_chain.h"

#include <sys/eventfd.h>
#include <unistd.h>

#include <algorithm>
#include <condition_variable>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>

#include "devices/device.h"
#include "devices/wire/ends/end_activity.h"
#include "devices/wire/ends/stream_end.h"

namespace tactbench::devices {
namespace {

constexpr Nanoseconds kRenumbering = std::chrono::milliseconds(500);  // it ignores bytes meanwhile

ChainDeviceOptions device(std::int32_t id, std::uint8_t number) {
  ChainDeviceOptions options;
  options.device_id = id;
  options.number = number;
  return options;
}

}  // namespace

std::vector<ChainDeviceOptions> paper_chain() { return {device(60, 1), device(60, 2), device(5082, 3)}; }

class SimulatedChain::Server {
 public:
  Server(SimulatedChainOptions options, const Clock& clock, SimulatedChainFaults faults)
      : options_(std::move(options)),
        clock_(clock),
        faults_(std::move(faults)),
        end_(options_.listen),
        address_(end_.address()),
        devices_(options_.devices.begin(), options_.devices.end()),
        wake_(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)) {
    if (wake_ < 0) {
      throw Fault("TB-SIM-LISTEN", "simulated chain", "starting the simulated chain: no event descriptor is left",
                  "Raise the limit of open files.");
    }
    thread_ = work_.thread([this] { serve(); });
  }

  ~Server() {
    order(Order::kStop);
    thread_.join();
    ::close(wake_);
  }
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

  enum class Order { kNone, kStop, kUnplug, kPlugIn };

  // Passes the command to the serving thread, which alone uses the wire, and waits until it is executed.
  void order(Order wanted) {
    std::unique_lock lock(mutex_);
    order_ = wanted;
    const std::uint64_t one = 1;
    [[maybe_unused]] const ssize_t written = ::write(wake_, &one, sizeof one);
    done_.wait(lock, [this] { return order_ == Order::kNone; });
  }

  Nanoseconds now() const { return clock_.now(); }

  std::array<Millimetres, kAxes> places(Nanoseconds time) {
    const std::lock_guard lock(mutex_);
    follow_stall();
    std::array<Millimetres, kAxes> places{};
    for (std::size_t axis = 0; axis < kAxes; ++axis) places[axis] = devices_.at(options_.axes[axis]).position(time);
    return places;
  }

  bool at_rest_since(Nanoseconds time) {
    const std::lock_guard lock(mutex_);
    follow_stall();
    return std::all_of(devices_.begin(), devices_.end(), [&](const auto& one) { return one.at_rest_since(time); });
  }

  void power_cycle() {
    const std::lock_guard lock(mutex_);
    for (ChainDevice& one : devices_) one.reset(clock_.now());
  }

  mutable std::mutex mutex_;
  std::string address() const { return address_; }
  std::uint64_t bytes_ = 0;
  std::vector<ZaberFrame> log_;
  std::optional<std::pair<ZaberCommand, std::int32_t>> refusal_;
  std::vector<ZaberFrame> extra_frames_;

 private:
  // The 10 ms within which the bytes of a frame must follow one another are real time: a client's pause is real.
  static Nanoseconds real_time() { return std::chrono::steady_clock::now().time_since_epoch(); }

  void serve() {
    for (;;) {
      pollfd descriptors[] = {{wake_, POLLIN, 0}, {end_.descriptor(), POLLIN, 0}};
      work_.wait(descriptors, patience());
      const bool asked = (descriptors[1].revents & POLLIN) != 0;
      const InjectedFault injected = asked && faults_.inject ? faults_.inject() : InjectedFault::kNone;
      const std::lock_guard lock(mutex_);
      injected_ = injected;
      follow_stall();
      if (descriptors[0].revents != 0 && !obey()) return;
      if (options_.free_running) send_due_replies();
      if (descriptors[1].revents != 0) attend();
    }
  }

  // The motion is changed at the times themselves, as a past position may be requested later.
  void follow_stall() {
    if (!faults_.stall) return;
    const StageStall stall = faults_.stall();
    const Nanoseconds now = clock_.now();
    if (stall.from && *stall.from <= now && stall.from != stuck_from_) {
      free_all(*stall.from);
      for (std::size_t axis = 0; axis < kAxes; ++axis) {
        if (stall.axis.value_or(static_cast<Axis>(axis)) == static_cast<Axis>(axis)) {
          devices_.at(options_.axes[axis]).stick(*stall.from);
        }
      }
      stuck_from_ = stall.from;
    }
    if (stall.until && *stall.until <= now) free_all(*stall.until);
  }

  void free_all(Nanoseconds when) {
    for (ChainDevice& one : devices_) one.free(when);
  }

  std::optional<Nanoseconds> patience() const {
    if (!options_.free_running) return std::nullopt;
    const std::lock_guard lock(mutex_);
    std::optional<Nanoseconds> next;
    for (const ChainDevice& one : devices_) {
      if (const auto due = one.due(); due && (!next || *due < *next)) next = due;
    }
    if (next) next = std::clamp<Nanoseconds>(*next - clock_.now(), Nanoseconds(0), std::chrono::seconds(1));
    return next;
  }

  bool obey() {
    std::uint64_t count{};
    [[maybe_unused]] const ssize_t got = ::read(wake_, &count, sizeof count);
    const Order wanted = std::exchange(order_, Order::kNone);
    if (wanted == Order::kUnplug) end_.hang_up();
    try {
      if (wanted == Order::kPlugIn) plug_in();
    } catch (const Fault&) {
      // It stays unplugged; opening it fails with the reason.
    }
    done_.notify_all();
    return wanted != Order::kStop;
  }

  void plug_in() {
    faults_.unplug_after_requests = -1;
    parser_ = ZaberParser();
    end_.plug_in();
    address_ = end_.address();
  }

  void attend() {
    std::array<std::uint8_t, 512> bytes{};
    const std::size_t got = end_.receive(bytes);
    bytes_ += got;
    std::vector<ZaberBytes> frames;
    parser_.add(std::span(bytes).first(got), real_time(), frames);
    for (const ZaberBytes& frame : frames) request(frame);
  }

  void request(const ZaberBytes& bytes) {
    const auto number = static_cast<long>(log_.size());
    log_.push_back(decode(bytes));
    const bool unplugged = faults_.unplug_after_requests >= 0 && number >= faults_.unplug_after_requests;
    if (unplugged || injected_ == InjectedFault::kUnplugged) return end_.hang_up();
    const Nanoseconds now = clock_.now();
    if (now < deaf_until_) return;
    silent_ = faults_.silent_after_requests >= 0 && number >= faults_.silent_after_requests;
    silent_ = silent_ || injected_ == InjectedFault::kSilent;
    send_due_replies();
    for (const ZaberFrame& frame : std::exchange(extra_frames_, {})) reply(encode(frame));
    if (bytes[0] == 0 && log_.back().command == ZaberCommand::kRenumber) deaf_until_ = now + kRenumbering;
    for (std::size_t i = 0; i < devices_.size(); ++i) hand_to(i, bytes, now);
  }

  void hand_to(std::size_t index, const ZaberBytes& bytes, Nanoseconds now) {
    ChainDevice& one = devices_[index];
    if (!one.hears(bytes[0])) return;
    const bool ids = one.message_ids();
    ZaberFrame frame = ids ? decode(bytes) : decode_without_id(bytes);
    std::vector<ZaberFrame> replies;
    if (refusal_ && refusal_->first == frame.command) {
      replies.push_back({one.number(), ZaberCommand::kError, refusal_->second, frame.id});
      refusal_.reset();
    } else {
      one.receive(frame, now, static_cast<std::uint8_t>(index + 1), replies);
    }
    send(one, replies);
  }

  void send_due_replies() {
    for (ChainDevice& one : devices_) {
      std::vector<ZaberFrame> replies;
      one.run(clock_.now(), replies);
      send(one, replies);
    }
  }

  void send(const ChainDevice& one, const std::vector<ZaberFrame>& replies) {
    for (const ZaberFrame& frame : replies) {
      ZaberBytes bytes = encode_without_id(frame);
      if (one.message_ids()) bytes[5] = frame.id;
      reply(bytes);
    }
  }

  void reply(ZaberBytes bytes) {
    const long number = replies_++;
    if (silent_) return;
    if (number == faults_.corrupt_reply || injected_ == InjectedFault::kCorrupt) bytes[0] ^= 0x40U;
    if (number == faults_.cut_reply || injected_ == InjectedFault::kTorn) return end_.send(std::span(bytes).first(3));
    if (number == faults_.late_reply || (injected_ == InjectedFault::kLate && !late_)) {
      late_ = bytes;
      return;
    }
    end_.send(bytes);
    if (late_) end_.send(*std::exchange(late_, std::nullopt));
  }

  SimulatedChainOptions options_;
  const Clock& clock_;
  SimulatedChainFaults faults_;
  StreamEnd end_;
  std::string address_;
  ZaberParser parser_;
  std::vector<ChainDevice> devices_;
  Nanoseconds deaf_until_{0};
  std::optional<ZaberBytes> late_;
  long replies_ = 0;
  bool silent_ = false;
  InjectedFault injected_ = InjectedFault::kNone;  // of the requests being read
  std::optional<Nanoseconds> stuck_from_;
  Order order_ = Order::kNone;
  std::condition_variable done_;
  int wake_;
  EndActivity work_;
  std::thread thread_;
};

SimulatedChain::SimulatedChain(SimulatedChainOptions options, const Clock& clock, SimulatedChainFaults faults)
    : server_(std::make_unique<Server>(std::move(options), clock, std::move(faults))) {}

SimulatedChain::~SimulatedChain() = default;

std::array<Millimetres, kAxes> SimulatedChain::places(Nanoseconds time) const { return server_->places(time); }
bool SimulatedChain::at_rest_since(Nanoseconds time) const { return server_->at_rest_since(time); }

Millimetres SimulatedChain::position(Axis axis) const {
  return server_->places(server_->now()).at(static_cast<std::size_t>(axis));
}

std::string SimulatedChain::address() const {
  const std::lock_guard lock(server_->mutex_);
  return server_->address();
}

std::uint64_t SimulatedChain::bytes_received() const {
  const std::lock_guard lock(server_->mutex_);
  return server_->bytes_;
}

std::vector<ZaberFrame> SimulatedChain::requests() const {
  const std::lock_guard lock(server_->mutex_);
  return server_->log_;
}

void SimulatedChain::unplug() { server_->order(Server::Order::kUnplug); }
void SimulatedChain::plug_in() { server_->order(Server::Order::kPlugIn); }
void SimulatedChain::power_cycle() { server_->power_cycle(); }

void SimulatedChain::refuse_next(ZaberCommand command, std::int32_t error) {
  const std::lock_guard lock(server_->mutex_);
  server_->refusal_ = {command, error};
}

void SimulatedChain::inject(const ZaberFrame& frame) {
  const std::lock_guard lock(server_->mutex_);
  server_->extra_frames_.push_back(frame);
}

}  // namespace tactbench::devices
