#include "devices/pressure/simulated_module.h"

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
#include <array>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <thread>
#include <utility>

#include "devices/device.h"
#include "devices/fault_injection.h"
#include "devices/pressure/module_registers.h"
#include "devices/wire/ends/end_activity.h"
#include "devices/wire/ends/stream_end.h"
#include "devices/wire/modbus/modbus_link.h"

namespace tactbench::devices {
namespace {

constexpr std::size_t kMaxClients = 32;
constexpr std::size_t kHeaderBytes = 7;  // MBAP: transaction, protocol, length of what follows, unit

// A big-endian word of a Modbus frame.
std::size_t word_at(std::span<const std::uint8_t> bytes, std::size_t at) {
  return static_cast<std::size_t>(bytes[at]) << 8U | bytes[at + 1];
}

}  // namespace

// What the TCP and the RTU server share: units, execution of requests, faults. libmodbus builds the answers.
class SimulatedModule::Server {
 public:
  Server(std::vector<SimulatedUnit> units, ChamberPort& chamber, const Clock& clock, SimulatedModuleFaults faults);
  virtual ~Server();
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;
  [[nodiscard]] virtual int port() const { return 0; }
  [[nodiscard]] virtual std::string serial_port() const { return {}; }

 protected:
  enum class Answer { kSent, kNone, kBroken, kDie };
  // One request of client number `client`, answered on `descriptor`: `frame` is header, unit, PDU, trailer.
  Answer answer(int client, int descriptor, std::span<const std::uint8_t> frame, std::size_t header,
                std::size_t trailer);
  [[noreturn]] void fail_to_listen(const std::string& what, int error);
  void start() {
    thread_ = work_.thread([this] { serve(); });
  }
  void stop();  // must be called by the destructor of the class that has serve()
  void connected();
  void disconnected(int client);

  modbus_t* modbus_ = nullptr;
  int stop_ = -1;  // readable: end
  EndActivity work_;

 private:
  virtual void serve() = 0;
  Refusal carry_out(ModuleRegisters& registers, int client, std::span<const std::uint8_t> pdu);
  Refusal read(ModuleRegisters& registers, int client, int function, int address, std::size_t count);
  Refusal write(ModuleRegisters& registers, int client, int address, std::span<const std::uint8_t> bytes);
  // The bytes that modbus_reply would send, to be corrupted.
  std::vector<std::uint8_t> catch_reply(std::span<const std::uint8_t> frame, Refusal refusal);
  int reply(std::span<const std::uint8_t> frame, Refusal refusal);
  Refusal read_bits(const ModuleRegisters& registers, int address, std::size_t count);
  std::vector<std::unique_ptr<ModuleRegisters>> units_;
  SimulatedModuleFaults faults_;
  modbus_mapping_t* mapping_ = nullptr;
  long requests_ = 0;
  InjectedFault injected_ = InjectedFault::kNone;  // of the request being answered
  int late_client_ = -1;
  std::vector<std::uint8_t> late_;
  std::thread thread_;
};

// Modbus RTU on a pseudo-terminal.
class SimulatedModule::RtuServer final : public SimulatedModule::Server {
 public:
  RtuServer(std::vector<SimulatedUnit> units, ChamberPort& chamber, const Clock& clock, SimulatedModuleFaults faults);
  ~RtuServer() override;
  RtuServer(const RtuServer&) = delete;
  RtuServer& operator=(const RtuServer&) = delete;
  [[nodiscard]] std::string serial_port() const override { return terminal_.path(); }

 private:
  void serve() override;
  [[nodiscard]] bool attend();
  PseudoTerminal terminal_;
  bool echoes_;
  std::vector<std::uint8_t> received_;
};

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

namespace {

constexpr int kRegisters = 65536;  // the whole map: profiles put theirs anywhere

}  // namespace

SimulatedModule::Server::Server(std::vector<SimulatedUnit> units, ChamberPort& chamber, const Clock& clock,
                                SimulatedModuleFaults faults)
    : stop_(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)),
      faults_(std::move(faults)),
      mapping_(modbus_mapping_new(kRegisters, kRegisters, kRegisters, kRegisters)) {
  for (SimulatedUnit& unit : units)
    units_.push_back(std::make_unique<ModuleRegisters>(std::move(unit), chamber, clock));
}

SimulatedModule::Server::~Server() {
  if (stop_ >= 0) ::close(stop_);
  modbus_mapping_free(mapping_);
  if (modbus_ == nullptr) return;
  modbus_set_socket(modbus_, -1);
  modbus_free(modbus_);
}

void SimulatedModule::Server::stop() {
  const std::uint64_t one = 1;
  [[maybe_unused]] const ssize_t written = ::write(stop_, &one, sizeof one);
  if (thread_.joinable()) thread_.join();
}

void SimulatedModule::Server::fail_to_listen(const std::string& what, int error) {
  throw Fault("TB-SIM-LISTEN", "simulated module", fmt::format("{}: {}", what, std::strerror(error)),
              "Choose another port, or 0 to let the system choose.");
}

void SimulatedModule::Server::connected() {
  for (const auto& unit : units_) unit->connected();
}

void SimulatedModule::Server::disconnected(int client) {
  for (const auto& unit : units_) unit->disconnected(client);
}

SimulatedModule::Server::Answer SimulatedModule::Server::answer(int client, int descriptor,
                                                                std::span<const std::uint8_t> frame, std::size_t header,
                                                                std::size_t trailer) {
  const int asked = frame[header];
  const auto unit = std::find_if(units_.begin(), units_.end(), [&](const auto& candidate) {
    return candidate->unit() == 0 || candidate->unit() == asked;
  });
  if (unit == units_.end()) return Answer::kNone;
  const long number = requests_++;
  if (faults_.dead_after_requests >= 0 && number >= faults_.dead_after_requests) return Answer::kDie;
  if (faults_.silent_after_requests >= 0 && number >= faults_.silent_after_requests) return Answer::kNone;
  injected_ = faults_.inject ? faults_.inject() : InjectedFault::kNone;
  if (injected_ == InjectedFault::kUnplugged) return Answer::kBroken;
  if (injected_ == InjectedFault::kSilent) return Answer::kNone;
  Refusal refusal = injected_ == InjectedFault::kBusy ? Refusal::kBusy : Refusal::kFailure;
  try {
    for (const auto& each : units_) each->turn();
    if (injected_ != InjectedFault::kRefused && injected_ != InjectedFault::kBusy) {
      refusal = carry_out(**unit, client, frame.subspan(header + 1, frame.size() - header - 1 - trailer));
    }
  } catch (...) {
    // The port failed: the client sees a failed device.
  }
  if (late_client_ == client && !late_.empty()) {
    if (::write(descriptor, late_.data(), late_.size()) < 0) return Answer::kBroken;
    late_.clear();
  }
  if (injected_ == InjectedFault::kLate || injected_ == InjectedFault::kCorrupt) {
    std::vector<std::uint8_t> bytes = catch_reply(frame, refusal);
    if (injected_ == InjectedFault::kLate) {
      late_client_ = client;
      late_ = std::move(bytes);
      return Answer::kNone;
    }
    if (bytes.size() > header + 1)
      bytes[header + 1] ^= 0x10U;  // the function code: also detected on TCP, which has no Modbus checksum
    return ::write(descriptor, bytes.data(), bytes.size()) >= 0 ? Answer::kSent : Answer::kBroken;
  }
  modbus_set_socket(modbus_, descriptor);
  return reply(frame, refusal) >= 0 ? Answer::kSent : Answer::kBroken;
}

int SimulatedModule::Server::reply(std::span<const std::uint8_t> frame, Refusal refusal) {
  return refusal == Refusal::kNone ? modbus_reply(modbus_, frame.data(), static_cast<int>(frame.size()), mapping_)
                                   : modbus_reply_exception(modbus_, frame.data(), static_cast<unsigned>(refusal));
}

std::vector<std::uint8_t> SimulatedModule::Server::catch_reply(std::span<const std::uint8_t> frame, Refusal refusal) {
  std::array<int, 2> ends{};
  if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0, ends.data()) != 0) return {};
  modbus_set_socket(modbus_, ends[0]);
  reply(frame, refusal);
  std::vector<std::uint8_t> bytes(MODBUS_MAX_ADU_LENGTH);
  const ssize_t got = ::read(ends[1], bytes.data(), bytes.size());
  bytes.resize(got > 0 ? static_cast<std::size_t>(got) : 0);
  for (const int end : ends) ::close(end);
  return bytes;
}

// Carries out the request and leaves the values to be answered in the mapping, from which libmodbus answers.
Refusal SimulatedModule::Server::carry_out(ModuleRegisters& registers, int client, std::span<const std::uint8_t> pdu) {
  const int function = pdu[0];
  if (function != 2 && function != 3 && function != 4 && function != 5 && function != 6 && function != 16 &&
      function != 23) {
    return Refusal::kFunction;
  }
  if (pdu.size() < 5) return Refusal::kValue;
  const int address = static_cast<int>(word_at(pdu, 1));
  const std::size_t count = function == 6 ? 1 : word_at(pdu, 3);
  switch (function) {
    case 2:
      if (pdu.size() != 5 || count < 1 || count > MODBUS_MAX_READ_BITS) return Refusal::kValue;
      return read_bits(registers, address, count);
    case 3:
    case 4:
      if (pdu.size() != 5 || count < 1 || count > MODBUS_MAX_READ_REGISTERS) return Refusal::kValue;
      return read(registers, client, function, address, count);
    case 5:
      if (pdu.size() != 5 || (count != 0xFF00 && count != 0)) return Refusal::kValue;
      return registers.write_bit(address, count != 0);
    case 6:
      return pdu.size() == 5 ? write(registers, client, address, pdu.subspan(3)) : Refusal::kValue;
    case 16:
      if (count < 1 || count > MODBUS_MAX_WRITE_REGISTERS || pdu.size() != 6 + 2 * count || pdu[5] != 2 * count) {
        return Refusal::kValue;
      }
      return write(registers, client, address, pdu.subspan(6));
    default: {
      if (pdu.size() < 10 || count < 1 || count > MODBUS_MAX_WR_READ_REGISTERS) return Refusal::kValue;
      const std::size_t written = word_at(pdu, 7);
      if (written < 1 || written > MODBUS_MAX_WR_WRITE_REGISTERS || pdu.size() != 10 + 2 * written ||
          pdu[9] != 2 * written) {
        return Refusal::kValue;
      }
      Refusal refusal = registers.check_read(3, address, count);
      if (refusal == Refusal::kNone) {
        refusal = write(registers, client, static_cast<int>(word_at(pdu, 5)), pdu.subspan(10));
      }
      return refusal == Refusal::kNone ? read(registers, client, 3, address, count) : refusal;
    }
  }
}

Refusal SimulatedModule::Server::read(ModuleRegisters& registers, int client, int function, int address,
                                      std::size_t count) {
  if (injected_ == InjectedFault::kStale) return Refusal::kNone;  // the mapping holds the values read before
  std::uint16_t values[MODBUS_MAX_READ_REGISTERS];
  const Refusal refusal = registers.read(client, function, address, std::span(values, count));
  std::uint16_t* table = function == 4 ? mapping_->tab_input_registers : mapping_->tab_registers;
  if (refusal == Refusal::kNone) std::copy_n(values, count, table + address);
  return refusal;
}

Refusal SimulatedModule::Server::read_bits(const ModuleRegisters& registers, int address, std::size_t count) {
  if (injected_ == InjectedFault::kStale) return Refusal::kNone;
  std::vector<std::uint8_t> bits(count);
  const Refusal refusal = registers.read_bits(address, bits);
  if (refusal == Refusal::kNone) std::copy(bits.begin(), bits.end(), mapping_->tab_input_bits + address);
  return refusal;
}

Refusal SimulatedModule::Server::write(ModuleRegisters& registers, int client, int address,
                                       std::span<const std::uint8_t> bytes) {
  std::uint16_t values[MODBUS_MAX_WRITE_REGISTERS];
  const std::size_t count = bytes.size() / 2;
  for (std::size_t i = 0; i < count; ++i) values[i] = static_cast<std::uint16_t>(word_at(bytes, 2 * i));
  return registers.write(client, address, std::span(values, count));
}

namespace {

constexpr int kOnlyClient = 0;
// A client never pauses longer than this inside a frame; an older incomplete frame is noise.
constexpr Nanoseconds kFramePause = std::chrono::milliseconds(100);

// Bytes of the request that begins `bytes` (unit, function, ..., check sum); 0: not yet known.
std::size_t request_size(std::span<const std::uint8_t> bytes) {
  if (bytes.size() < 2) return 0;
  if (bytes[1] == 16) return bytes.size() < 7 ? 0 : 9U + bytes[6];
  if (bytes[1] == 23) return bytes.size() < 11 ? 0 : 13U + bytes[10];
  return 8;
}

}  // namespace

SimulatedModule::RtuServer::RtuServer(std::vector<SimulatedUnit> units, ChamberPort& chamber, const Clock& clock,
                                      SimulatedModuleFaults faults)
    : Server(std::move(units), chamber, clock, faults), echoes_(faults.echoes) {
  modbus_ = modbus_new_rtu(terminal_.path().c_str(), 9600, 'N', 8, 1);
  if (modbus_ == nullptr || stop_ < 0) fail_to_listen("serving " + terminal_.path(), errno);
  connected();
  start();
}

SimulatedModule::RtuServer::~RtuServer() { stop(); }

void SimulatedModule::RtuServer::serve() {
  for (;;) {
    std::array<pollfd, 2> descriptors{pollfd{stop_, POLLIN, 0}, pollfd{terminal_.master(), POLLIN, 0}};
    const int ready = work_.wait(descriptors, received_.empty() ? std::nullopt : std::optional(kFramePause));
    if (ready == 0) received_.clear();
    if (descriptors[0].revents != 0) return;
    if (ready > 0 && descriptors[1].revents != 0 && !attend()) {
      terminal_.hang_up();
      return;
    }
  }
}

// False: hang up the line.
bool SimulatedModule::RtuServer::attend() {
  std::array<std::uint8_t, MODBUS_RTU_MAX_ADU_LENGTH> bytes{};
  const ssize_t got = ::read(terminal_.master(), bytes.data(), bytes.size());
  if (got <= 0) return got < 0 && (errno == EAGAIN || errno == EINTR);
  if (echoes_) (void)!::write(terminal_.master(), bytes.data(), static_cast<std::size_t>(got));
  received_.insert(received_.end(), bytes.begin(), bytes.begin() + got);
  for (;;) {
    const std::size_t size = request_size(received_);
    if (size == 0 || received_.size() < size) return true;
    const auto frame = std::span<const std::uint8_t>(received_).first(size);
    const std::uint16_t crc = crc16_modbus(frame.first(size - 2));
    if (frame[size - 2] != (crc & 0xFFU) || frame[size - 1] != crc >> 8U) {
      received_.clear();  // a damaged request is not answered, and only silence marks where the next one begins
      return true;
    }
    if (answer(kOnlyClient, terminal_.master(), frame, 0, 2) == Answer::kDie) return false;
    received_.erase(received_.begin(), received_.begin() + static_cast<std::ptrdiff_t>(size));
  }
}

}  // namespace tactbench::devices
