#include "devices/pressure/simulated_module.h"

#include <arpa/inet.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <modbus.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <thread>
#include <utility>

#include "devices/fault.h"
#include "devices/pressure/module_registers.h"

namespace tactbench::devices {
namespace {

constexpr std::size_t kMaxClients = 32;
constexpr std::size_t kHeaderBytes = 7;  // MBAP: transaction, protocol, length of what follows, unit

std::size_t word_at(std::span<const std::uint8_t> bytes, std::size_t at) {
  return static_cast<std::size_t>(bytes[at]) << 8U | bytes[at + 1];
}

struct Client {
  int socket = -1;
  int number = 0;
  std::vector<std::uint8_t> received;
};

}  // namespace

// libmodbus listens and answers. Requests are gathered here, a socket read each, since modbus_receive() would let a
// client that sends half a request hold up all others.
class SimulatedModule::Server {
 public:
  Server(const ModuleProfile& profile, int port, ChamberPort& chamber, const Clock& clock, SimulatedModuleFaults faults)
      : registers_(profile, chamber, clock), faults_(faults), modbus_(modbus_new_tcp("127.0.0.1", port)) {
    const int words = std::max({profile.input_address + profile.inputs, profile.output_address + profile.outputs,
                                profile.watchdog_address + 5});
    mapping_ = modbus_mapping_new(0, 0, words, profile.input_address + profile.inputs);
    if (modbus_ != nullptr) listener_ = modbus_tcp_listen(modbus_, static_cast<int>(kMaxClients));
    stop_ = ::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
    sockaddr_in address{};
    socklen_t size = sizeof address;
    if (mapping_ == nullptr || stop_ < 0 || listener_ < 0 ||
        ::getsockname(listener_, reinterpret_cast<sockaddr*>(&address), &size) != 0 ||
        ::fcntl(listener_, F_SETFL, O_NONBLOCK) != 0) {
      const int error = errno;
      release();
      throw Fault("TB-SIM-LISTEN", "simulated module",
                  fmt::format("listening on 127.0.0.1:{}: {}", port, std::strerror(error)),
                  "Choose another port, or 0 to let the system choose.");
    }
    port_ = ntohs(address.sin_port);
    thread_ = std::thread([this] { serve(); });
  }

  ~Server() {
    const std::uint64_t one = 1;
    [[maybe_unused]] const ssize_t written = ::write(stop_, &one, sizeof one);
    thread_.join();
    release();
  }
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

  [[nodiscard]] int port() const { return port_; }

 private:
  void release() {
    for (const Client& client : clients_) ::close(client.socket);
    if (listener_ >= 0) ::close(listener_);
    if (stop_ >= 0) ::close(stop_);
    modbus_mapping_free(mapping_);
    if (modbus_ != nullptr) {
      modbus_set_socket(modbus_, -1);
      modbus_free(modbus_);
    }
  }

  void serve() {
    std::vector<pollfd> descriptors;
    for (;;) {
      const int listener = clients_.size() < kMaxClients ? listener_ : -1;  // poll() passes over negative ones
      descriptors.assign({{stop_, POLLIN, 0}, {listener, POLLIN, 0}});
      for (const Client& client : clients_) descriptors.push_back({client.socket, POLLIN, 0});
      if (::poll(descriptors.data(), descriptors.size(), -1) < 0) continue;
      if (descriptors[0].revents != 0) return;
      if (clients_.size() > 1) bury();
      for (std::size_t i = 2; i < descriptors.size(); ++i) {
        if (descriptors[i].revents != 0 && !attend(clients_[i - 2])) drop(clients_[i - 2]);
      }
      std::erase_if(clients_, [](const Client& client) { return client.socket < 0; });
      if (descriptors[1].revents != 0 && listener_ >= 0) accept();
    }
  }

  // Who has hung up is seen before any other's request, as it happened: the write lock passes on with that.
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
    registers_.connected();
  }

  void drop(Client& client) {
    if (client.socket < 0) return;
    ::close(std::exchange(client.socket, -1));
    registers_.disconnected(client.number);
  }

  // The listener first: whoever sees the connection break must not get a new one.
  void die() {
    if (listener_ >= 0) ::close(std::exchange(listener_, -1));
    for (Client& client : clients_) drop(client);
  }

  // False: the connection is to be closed.
  bool attend(Client& client) {
    if (client.socket < 0) return false;
    std::uint8_t bytes[2 * MODBUS_TCP_MAX_ADU_LENGTH];
    const ssize_t got = ::recv(client.socket, bytes, sizeof bytes, 0);
    if (got < 0) return errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR;
    if (got == 0) return false;
    auto& waiting = client.received;
    waiting.insert(waiting.end(), bytes, bytes + got);
    std::size_t begin = 0;
    while (waiting.size() - begin >= kHeaderBytes) {
      const auto rest = std::span(waiting).subspan(begin);
      const std::size_t size = 6 + word_at(rest, 4);
      if (word_at(rest, 2) != 0 || size < kHeaderBytes + 1 || size > MODBUS_TCP_MAX_ADU_LENGTH) return false;
      if (rest.size() < size) break;
      if (!answer(client, rest.first(size))) return false;
      begin += size;
    }
    waiting.erase(waiting.begin(), waiting.begin() + static_cast<std::ptrdiff_t>(begin));
    return true;
  }

  bool answer(const Client& client, std::span<const std::uint8_t> request) {
    const long number = requests_++;
    if (faults_.dead_after_requests >= 0 && number >= faults_.dead_after_requests) {
      die();
      return false;
    }
    if (faults_.silent_after_requests >= 0 && number >= faults_.silent_after_requests) return true;
    Refusal refusal = Refusal::kFailure;
    try {
      registers_.turn();
      refusal = carry_out(client.number, request.subspan(kHeaderBytes));
    } catch (...) {
      // The port failed: to the client that is a failing device.
    }
    modbus_set_socket(modbus_, client.socket);
    const int sent = refusal == Refusal::kNone
                         ? modbus_reply(modbus_, request.data(), static_cast<int>(request.size()), mapping_)
                         : modbus_reply_exception(modbus_, request.data(), static_cast<unsigned>(refusal));
    return sent >= 0;
  }

  // Does what the request asks and leaves what is to be answered in the mapping, from which libmodbus answers.
  Refusal carry_out(int client, std::span<const std::uint8_t> pdu) {
    const int function = pdu[0];
    if (function != 3 && function != 4 && function != 6 && function != 16 && function != 23) return Refusal::kFunction;
    if (pdu.size() < 5) return Refusal::kValue;
    const int address = static_cast<int>(word_at(pdu, 1));
    const std::size_t count = function == 6 ? 1 : word_at(pdu, 3);
    switch (function) {
      case 3:
      case 4:
        if (pdu.size() != 5 || count < 1 || count > MODBUS_MAX_READ_REGISTERS) return Refusal::kValue;
        return read(client, function, address, count);
      case 6:
        return pdu.size() == 5 ? write(client, address, pdu.subspan(3)) : Refusal::kValue;
      case 16:
        if (count < 1 || count > MODBUS_MAX_WRITE_REGISTERS || pdu.size() != 6 + 2 * count || pdu[5] != 2 * count) {
          return Refusal::kValue;
        }
        return write(client, address, pdu.subspan(6));
      default: {
        if (pdu.size() < 10 || count < 1 || count > MODBUS_MAX_WR_READ_REGISTERS) return Refusal::kValue;
        const std::size_t written = word_at(pdu, 7);
        if (written < 1 || written > MODBUS_MAX_WR_WRITE_REGISTERS || pdu.size() != 10 + 2 * written ||
            pdu[9] != 2 * written) {
          return Refusal::kValue;
        }
        Refusal refusal = registers_.check_read(3, address, count);
        if (refusal == Refusal::kNone) refusal = write(client, static_cast<int>(word_at(pdu, 5)), pdu.subspan(10));
        return refusal == Refusal::kNone ? read(client, 3, address, count) : refusal;
      }
    }
  }

  Refusal read(int client, int function, int address, std::size_t count) {
    std::uint16_t values[MODBUS_MAX_READ_REGISTERS];
    const Refusal refusal = registers_.read(client, function, address, std::span(values, count));
    std::uint16_t* table = function == 4 ? mapping_->tab_input_registers : mapping_->tab_registers;
    if (refusal == Refusal::kNone) std::copy_n(values, count, table + address);
    return refusal;
  }

  Refusal write(int client, int address, std::span<const std::uint8_t> bytes) {
    std::uint16_t values[MODBUS_MAX_WRITE_REGISTERS];
    const std::size_t count = bytes.size() / 2;
    for (std::size_t i = 0; i < count; ++i) values[i] = static_cast<std::uint16_t>(word_at(bytes, 2 * i));
    return registers_.write(client, address, std::span(values, count));
  }

  ModuleRegisters registers_;
  SimulatedModuleFaults faults_;
  modbus_t* modbus_ = nullptr;
  modbus_mapping_t* mapping_ = nullptr;
  int listener_ = -1;
  int stop_ = -1;
  int port_ = 0;
  int next_number_ = 0;
  long requests_ = 0;
  std::vector<Client> clients_;
  std::thread thread_;
};

SimulatedModule::SimulatedModule(const ModuleProfile& profile, int port, ChamberPort& chamber, const Clock& clock,
                                 SimulatedModuleFaults faults)
    : server_(std::make_unique<Server>(profile, port, chamber, clock, faults)) {}

SimulatedModule::~SimulatedModule() = default;

int SimulatedModule::port() const { return server_->port(); }

}  // namespace tactbench::devices
