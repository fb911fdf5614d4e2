#include "devices/pressure/simulated_module.h"

#include <fcntl.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <string>
#include <utility>

#include "devices/pressure/simulated_rtu.h"
#include "devices/pressure/simulated_server.h"

namespace tactbench::devices {
namespace {

constexpr std::size_t kMaxClients = 32;
constexpr std::size_t kHeaderBytes = 7;  // MBAP: transaction, protocol, length of what follows, unit

}  // namespace

// libmodbus listens and answers. Requests are gathered here, one socket read each: in modbus_receive() a client that
// sends half a request would hold up all others.
class SimulatedModule::TcpServer final : public SimulatedModule::Server {
 public:
  TcpServer(std::vector<SimulatedUnit> units, int port, ChamberPort& chamber, const Clock& clock,
            SimulatedModuleFaults faults)
      : Server(std::move(units), chamber, clock, std::move(faults)) {
    modbus_ = modbus_new_tcp("127.0.0.1", port);
    if (modbus_ != nullptr) listener_ = modbus_tcp_listen(modbus_, static_cast<int>(kMaxClients));
    sockaddr_in address{};
    socklen_t size = sizeof address;
    if (stop_ < 0 || listener_ < 0 || ::getsockname(listener_, reinterpret_cast<sockaddr*>(&address), &size) != 0 ||
        ::fcntl(listener_, F_SETFL, O_NONBLOCK) != 0) {
      const int error = errno;
      if (listener_ >= 0) ::close(listener_);
      fail_to_listen("listening on 127.0.0.1:" + std::to_string(port), error);
    }
    port_ = ntohs(address.sin_port);
    start();
  }

  ~TcpServer() override {
    stop();
    for (const Client& client : clients_) ::close(client.socket);
    if (listener_ >= 0) ::close(listener_);
  }
  TcpServer(const TcpServer&) = delete;
  TcpServer& operator=(const TcpServer&) = delete;

  [[nodiscard]] int port() const override { return port_; }

 private:
  struct Client {
    int socket = -1;
    int number = 0;
    std::vector<std::uint8_t> received;
  };

  void serve() override {
    std::vector<pollfd> descriptors;
    for (;;) {
      const int listener = clients_.size() < kMaxClients ? listener_ : -1;  // poll() ignores negative ones
      descriptors.assign({{stop_, POLLIN, 0}, {listener, POLLIN, 0}});
      for (const Client& client : clients_) descriptors.push_back({client.socket, POLLIN, 0});
      if (work_.wait(descriptors) < 0) continue;
      if (descriptors[0].revents != 0) return;
      if (clients_.size() > 1) bury();
      for (std::size_t i = 2; i < descriptors.size(); ++i) {
        if (descriptors[i].revents != 0 && !attend(clients_[i - 2])) drop(clients_[i - 2]);
      }
      std::erase_if(clients_, [](const Client& client) { return client.socket < 0; });
      if (descriptors[1].revents != 0 && listener_ >= 0) accept();
    }
  }

  // A client that hung up is handled before requests of others, in the order of events: the write lock passes on.
  void bury() {
    for (Client& client : clients_) {
      pollfd descriptor{client.socket, POLLRDHUP, 0};
      if (::poll(&descriptor, 1, 0) != 1) continue;
      while (attend(client)) {
      }
      drop(client);
    }
  }

  void accept() {
    const int socket = ::accept4(listener_, nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC);
    if (socket < 0) return;
    const int one = 1;
    ::setsockopt(socket, IPPROTO_TCP, TCP_NODELAY, &one, sizeof one);
    clients_.push_back({socket, next_number_++, {}});
    connected();
  }

  void drop(Client& client) {
    if (client.socket < 0) return;
    ::close(std::exchange(client.socket, -1));
    disconnected(client.number);
  }

  // Closes the listener first: a client that sees the connection break must not get a new one.
  void die() {
    if (listener_ >= 0) ::close(std::exchange(listener_, -1));
    for (Client& client : clients_) drop(client);
  }

  // False: close the connection.
  bool attend(Client& client) {
    if (client.socket < 0) return false;
    std::uint8_t bytes[2 * MODBUS_TCP_MAX_ADU_LENGTH];
    const ssize_t got = ::recv(client.socket, bytes, sizeof bytes, 0);
    if (got < 0) return errno == EAGAIN || errno == EINTR;
    if (got == 0) return false;
    auto& waiting = client.received;
    waiting.insert(waiting.end(), bytes, bytes + got);
    std::size_t begin = 0;
    while (waiting.size() - begin >= kHeaderBytes) {
      const auto rest = std::span(waiting).subspan(begin);
      const std::size_t size = 6 + word_at(rest, 4);
      if (word_at(rest, 2) != 0 || size < kHeaderBytes + 1 || size > MODBUS_TCP_MAX_ADU_LENGTH) return false;
      if (rest.size() < size) break;
      const Answer answered = answer(client.number, client.socket, rest.first(size), kHeaderBytes - 1, 0);
      if (answered == Answer::kDie) die();
      if (answered == Answer::kDie || answered == Answer::kBroken) return false;
      begin += size;
    }
    waiting.erase(waiting.begin(), waiting.begin() + static_cast<std::ptrdiff_t>(begin));
    return true;
  }

  int listener_ = -1;
  int port_ = 0;
  int next_number_ = 0;
  std::vector<Client> clients_;
};

SimulatedModule::SimulatedModule(const ModuleProfile& profile, int port, ChamberPort& chamber, const Clock& clock,
                                 SimulatedModuleFaults faults)
    : SimulatedModule({{0, profile, {}}}, Wire::kTcp, port, chamber, clock, std::move(faults)) {}

SimulatedModule::SimulatedModule(std::vector<SimulatedUnit> units, Wire wire, int port, ChamberPort& chamber,
                                 const Clock& clock, SimulatedModuleFaults faults) {
  if (wire == Wire::kTcp) {
    server_ = std::make_unique<TcpServer>(std::move(units), port, chamber, clock, std::move(faults));
  } else {
    server_ = std::make_unique<RtuServer>(std::move(units), chamber, clock, std::move(faults));
  }
}

SimulatedModule::~SimulatedModule() = default;

int SimulatedModule::port() const { return server_->port(); }

std::string SimulatedModule::serial_port() const { return server_->serial_port(); }

}  // namespace tactbench::devices
