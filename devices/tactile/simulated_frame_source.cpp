#include "devices/tactile/simulated_frame_source.h"

#include <fmt/format.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <optional>
#include <thread>
#include <utility>
#include <vector>

#include "devices/device.h"
#include "devices/wire/ends/end_activity.h"
#include "devices/wire/ends/stream_end.h"

namespace tactbench::devices {
namespace {

namespace protocol = frame_protocol;
using Real = std::chrono::steady_clock;
constexpr std::size_t kMaxSubscribers = 16;

}  // namespace

class SimulatedFrameSource::Server {
 public:
  Server(SimulatedFrameSourceOptions options, TactilePort& port, const Clock& clock)
      : options_(std::move(options)), port_(port), clock_(clock) {
    [[maybe_unused]] const auto encodable = protocol::encode({0, options_.description});
    if (!(options_.free_running_hz > 0.0 && options_.free_running_hz <= 1e5))
      fail("the rate must be above 0 and at most 100 kHz");
    period_ = std::chrono::duration_cast<Real::duration>(std::chrono::duration<double>(1.0 / options_.free_running_hz));
    last_.rows = options_.description.rows;
    last_.columns = options_.description.columns;
    last_.counts.resize(std::size_t{last_.rows} * last_.columns);
    status_.resize(last_.rows);
    stop_ = ::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
    if (stop_ < 0) fail(std::strerror(errno));
    try {
      const BoundSocket bound = bind_loopback(SOCK_STREAM, options_.port, "simulated frame source");
      listener_ = bound.socket;
      options_.port = bound.port;
    } catch (...) {
      release();
      throw;
    }
    thread_ = work_.thread([this] { serve(); });
  }

  ~Server() {
    const std::uint64_t one = 1;
    [[maybe_unused]] const ssize_t written = ::write(stop_, &one, sizeof one);
    thread_.join();
    release();
  }
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

  [[nodiscard]] int port() const { return options_.port; }

 private:
  struct Subscriber {
    int socket = -1;
    protocol::Parser parser;
    std::vector<std::uint8_t> unsent;           // while not empty, no request of this client is read
    bool closing = false;                       // close when all is sent
    std::optional<std::uint16_t> subscription;  // its tag
  };

  [[noreturn]] void fail(const std::string& why) {
    release();
    throw Fault("TB-SIM-LISTEN", "simulated frame source",
                fmt::format("listening on 127.0.0.1:{}: {}", options_.port, why),
                "Correct the rate, or close other programs.");
  }

  void release() {
    for (const Subscriber& client : clients_) ::close(client.socket);
    for (int* descriptor : {&listener_, &stop_}) {
      if (*descriptor >= 0) ::close(std::exchange(*descriptor, -1));
    }
  }

  void serve() {
    std::vector<pollfd> watched;
    for (;;) {
      const int listener = clients_.size() < kMaxSubscribers ? listener_ : -1;  // poll() ignores negative ones
      watched.assign({{stop_, POLLIN, 0}, {listener, POLLIN, 0}});
      for (const Subscriber& client : clients_) {
        watched.push_back({client.socket, static_cast<short>(client.unsent.empty() ? POLLIN : POLLOUT), 0});
      }
      if (work_.wait(watched, subscribed() ? std::optional(time_to_frame()) : std::nullopt) < 0) continue;
      if (watched[0].revents != 0) return;
      for (std::size_t i = 2; i < watched.size(); ++i) {
        Subscriber& client = clients_[i - 2];
        const bool open = watched[i].revents == 0 || (client.unsent.empty() ? attend(client) : flush(client));
        if (!open) ::close(std::exchange(client.socket, -1));
      }
      forget_closed();
      if (watched[1].revents != 0) accept();
      if (subscribed() && Real::now() >= next_frame_) publish();
    }
  }

  [[nodiscard]] bool subscribed() const {
    return std::any_of(clients_.begin(), clients_.end(),
                       [](const Subscriber& c) { return c.subscription.has_value(); });
  }

  [[nodiscard]] Nanoseconds time_to_frame() const {
    return std::max(Nanoseconds(0), Nanoseconds(next_frame_ - Real::now()));
  }

  void accept() {
    const int socket = ::accept4(listener_, nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC);
    if (socket < 0) return;
    const int one = 1;
    ::setsockopt(socket, IPPROTO_TCP, TCP_NODELAY, &one, sizeof one);
    clients_.emplace_back().socket = socket;
  }

  // False: close the connection.
  bool attend(Subscriber& client) {
    std::uint8_t bytes[512];
    const ssize_t got = ::recv(client.socket, bytes, sizeof bytes, 0);
    if (got < 0) return errno == EAGAIN;
    if (got == 0) return false;
    client.parser.feed(std::span(bytes, static_cast<std::size_t>(got)));
    while (const auto packet = client.parser.next()) answer(client, *packet);
    if (const std::string& broken = client.parser.broken(); !broken.empty()) {
      put(client, {0, protocol::Error{protocol::ErrorCode::kDamaged, "damaged request: " + broken}});
      client.closing = true;
    }
    return flush(client);
  }

  bool flush(Subscriber& client) {
    while (!client.unsent.empty()) {
      const ssize_t sent = ::send(client.socket, client.unsent.data(), client.unsent.size(), MSG_NOSIGNAL);
      if (sent < 0) return errno == EAGAIN;
      client.unsent.erase(client.unsent.begin(), client.unsent.begin() + sent);
    }
    return !client.closing;
  }

  static void put(Subscriber& client, const protocol::Message& message) {
    const auto bytes = protocol::encode(message);
    client.unsent.insert(client.unsent.end(), bytes.begin(), bytes.end());
  }

  void answer(Subscriber& client, const protocol::Packet& packet) {
    const auto error = [&](protocol::ErrorCode code, const char* text) {
      put(client, {packet.tag, protocol::Error{code, text}});
    };
    const auto request = protocol::decode(packet);
    injected_ = options_.faults.inject ? options_.faults.inject() : InjectedFault::kNone;
    if (injected_ == InjectedFault::kUnplugged) client.closing = true;
    if (injected_ == InjectedFault::kUnplugged || injected_ == InjectedFault::kSilent) return;
    if (!protocol::known_type(packet.type) || packet.type >= 0x80) {
      error(protocol::ErrorCode::kUnknownType, "not a request of this protocol");
    } else if (!request) {
      error(protocol::ErrorCode::kBadPayload, "the payload does not fit the request");
    } else if (std::holds_alternative<protocol::Identify>(request->body)) {
      put(client, {packet.tag, options_.description});
    } else if (std::holds_alternative<protocol::Scan>(request->body)) {
      scan(client, packet.tag);
    } else if (std::holds_alternative<protocol::Subscribe>(request->body)) {
      if (!subscribed()) next_frame_ = Real::now();
      client.subscription = packet.tag;
    } else {
      client.subscription.reset();
      put(client, {packet.tag, protocol::Done{}});
    }
  }

  // False: physics failed.
  bool make_frame() {
    try {
      port_.scan(last_.counts, status_);
    } catch (...) {
      return false;
    }
    last_.counter = counter_++;
    last_.status = 0;
    for (const std::uint8_t status : status_) last_.status = static_cast<std::uint8_t>(last_.status | status);
    last_.device_time_us =
        static_cast<std::uint64_t>(std::chrono::duration_cast<std::chrono::microseconds>(clock_.now()).count());
    return true;
  }

  void scan(Subscriber& client, std::uint16_t tag) {
    const auto& faults = options_.faults;
    const long number = scans_++;
    if (faults.silent_after_scans >= 0 && number >= faults.silent_after_scans) return;
    if (number != faults.repeat_scan && injected_ != InjectedFault::kStale && !make_frame()) {
      put(client, {tag, protocol::Error{protocol::ErrorCode::kDevice, "the array does not answer"}});
      return;
    }
    if (number == faults.drop_scan) return;
    const std::size_t begin = client.unsent.size();
    put(client, {tag, last_});
    const std::size_t middle = begin + (client.unsent.size() - begin) / 2;
    if (number == faults.corrupt_scan || injected_ == InjectedFault::kCorrupt) client.unsent[middle] ^= 0x10U;
    if (number == faults.double_scan) put(client, {tag, last_});
    if (number == faults.cut_scan || injected_ == InjectedFault::kTorn) {
      client.unsent.resize(middle);
      client.closing = true;
    }
  }

  void forget_closed() {
    std::erase_if(clients_, [](const Subscriber& client) { return client.socket < 0; });
  }

  // Sends a frame to each subscriber that has taken the previous one; a slow one sees the counter jump.
  void publish() {
    next_frame_ = std::max(next_frame_ + period_, Real::now());
    if (!make_frame()) return;
    for (Subscriber& client : clients_) {
      if (!client.subscription || !client.unsent.empty()) continue;
      put(client, {*client.subscription, last_});
      if (!flush(client)) ::close(std::exchange(client.socket, -1));
    }
    forget_closed();
  }

  SimulatedFrameSourceOptions options_;
  TactilePort& port_;
  const Clock& clock_;
  Real::duration period_{};
  Real::time_point next_frame_;
  protocol::Frame last_;
  std::vector<std::uint8_t> status_;
  std::uint32_t counter_ = 0;
  long scans_ = 0;
  InjectedFault injected_ = InjectedFault::kNone;  // of the request being answered
  int listener_ = -1;
  int stop_ = -1;
  std::vector<Subscriber> clients_;
  EndActivity work_;
  std::thread thread_;
};

SimulatedFrameSource::SimulatedFrameSource(SimulatedFrameSourceOptions options, TactilePort& port, const Clock& clock)
    : server_(std::make_unique<Server>(std::move(options), port, clock)) {}

SimulatedFrameSource::~SimulatedFrameSource() = default;

int SimulatedFrameSource::port() const { return server_->port(); }

}  // namespace tactbench::devices
