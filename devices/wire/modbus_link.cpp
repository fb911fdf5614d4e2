#include "devices/wire/modbus_link.h"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <modbus.h>
#include <netdb.h>
#include <sys/select.h>

#include <cerrno>
#include <utility>

#include "devices/fault.h"

namespace tactbench::devices {
namespace {

bool is_exception(int error) { return error > MODBUS_ENOBASE && error < MODBUS_ENOBASE + MODBUS_EXCEPTION_MAX; }

double milliseconds(Nanoseconds time) { return std::chrono::duration<double, std::milli>(time).count(); }

}  // namespace

struct ModbusLink::Context {
  modbus_t* modbus = nullptr;
  ~Context() {
    if (modbus == nullptr) return;
    modbus_close(modbus);
    modbus_free(modbus);
  }
};

struct ModbusLink::Request {
  const char* verb;
  int function;
  int address;
  std::size_t count;
  std::size_t most;      // registers that a frame of this function can hold
  std::size_t expected;  // libmodbus' return value when all went well
};

ModbusLink::ModbusLink(ModbusEndpoint endpoint, std::string device, Clock& clock)
    : endpoint_(std::move(endpoint)), device_(std::move(device)), clock_(clock) {}

ModbusLink::~ModbusLink() = default;

std::string ModbusLink::peer() const {
  return fmt::format("{} at {}:{} unit {}", device_, endpoint_.host, endpoint_.port, endpoint_.unit);
}

void ModbusLink::close() noexcept { context_.reset(); }

void ModbusLink::look_up() {
  in_addr numeric{};
  if (inet_pton(AF_INET, endpoint_.host.c_str(), &numeric) == 1) {
    address_ = endpoint_.host;
    return;
  }
  addrinfo hints{};
  hints.ai_family = AF_INET;
  hints.ai_socktype = SOCK_STREAM;
  addrinfo* found = nullptr;
  const int result = getaddrinfo(endpoint_.host.c_str(), nullptr, &hints, &found);
  if (result != 0) {
    throw Fault("TB-MODBUS-CONNECT", device_,
                fmt::format("connecting to {}: the host's name has no address ({})", peer(), gai_strerror(result)),
                "Check the host in the bench file, or give its IPv4 address.");
  }
  char text[NI_MAXHOST] = "";
  getnameinfo(found->ai_addr, found->ai_addrlen, text, sizeof text, nullptr, 0, NI_NUMERICHOST);
  freeaddrinfo(found);
  address_ = text;
}

void ModbusLink::connect() {
  if (address_.empty()) look_up();
  auto fresh = std::make_unique<Context>();
  fresh->modbus = modbus_new_tcp(address_.c_str(), endpoint_.port);
  const auto timeout = std::chrono::duration_cast<std::chrono::microseconds>(endpoint_.response_timeout).count();
  // A byte timeout of 0 makes the response timeout rule the whole reply: a peer that trickles bytes cannot stretch it.
  const bool set = fresh->modbus != nullptr && timeout > 0 && modbus_set_slave(fresh->modbus, endpoint_.unit) == 0 &&
                   modbus_set_response_timeout(fresh->modbus, static_cast<std::uint32_t>(timeout / 1'000'000),
                                               static_cast<std::uint32_t>(timeout % 1'000'000)) == 0 &&
                   modbus_set_byte_timeout(fresh->modbus, 0, 0) == 0;
  if (!set) fail_connect(EINVAL);
  errno = 0;
  int result = modbus_connect(fresh->modbus);
  if (result != 0 && errno == EINTR) result = modbus_connect(fresh->modbus);
  // libmodbus leaves EINPROGRESS behind when its wait for the connection ran out.
  if (result != 0) fail_connect(errno == EINPROGRESS ? ETIMEDOUT : errno);
  // libmodbus waits with select(), which cannot hold a descriptor beyond FD_SETSIZE.
  if (modbus_get_socket(fresh->modbus) >= FD_SETSIZE) fail_connect(EMFILE);
  context_ = std::move(fresh);
}

template <class Call>
void ModbusLink::exchange(const Request& request, Call&& call) {
  if (request.count == 0 || request.count > request.most) fail_exchange(request, -1, EMBMDATA);
  if (!context_) connect();
  ++exchanges_;
  errno = 0;
  const int result = call(context_->modbus);
  if (result == static_cast<int>(request.expected)) return;
  const int error = errno;
  close();
  fail_exchange(request, result, error);
}

void ModbusLink::fail_connect(int error) {
  const std::string what = fmt::format("connecting to {}: ", peer());
  if (error == ETIMEDOUT) {
    clock_.reply_lost(endpoint_.response_timeout);
    throw Fault("TB-MODBUS-TIMEOUT", device_,
                what + fmt::format("no answer within {:g} ms", milliseconds(endpoint_.response_timeout)),
                "Check the module's power and network cable, and the host in the bench file.");
  }
  if (error == EINVAL) {
    throw Fault("TB-MODBUS-CONNECT", device_,
                what + fmt::format("address, port, unit or response timeout ({:g} ms) is not valid",
                                   milliseconds(endpoint_.response_timeout)),
                "Correct the endpoint in the bench file.");
  }
  throw Fault("TB-MODBUS-CONNECT", device_, what + modbus_strerror(error),
              "Check that the module is on and that host and port in the bench file are its own.");
}

void ModbusLink::fail_exchange(const Request& request, int result, int error) {
  const std::string what = fmt::format("{} {} register{} at 0x{:04X} (FC {}) of {}: ", request.verb, request.count,
                                       request.count == 1 ? "" : "s", request.address, request.function, peer());
  if (error == ETIMEDOUT) {
    clock_.reply_lost(endpoint_.response_timeout);
    throw Fault("TB-MODBUS-TIMEOUT", device_,
                what + fmt::format("no complete reply within {:g} ms", milliseconds(endpoint_.response_timeout)),
                "Check the module's power, network cable and unit number.");
  }
  if (is_exception(error)) {
    throw Fault("TB-MODBUS-EXCEPTION", device_,
                what + fmt::format("refused with exception {} ({})", error - MODBUS_ENOBASE, modbus_strerror(error)),
                "Check that the profile in the bench file fits the module, that no other master holds it, and that "
                "its watchdog has not tripped.");
  }
  if (error > MODBUS_ENOBASE || result >= 0) {
    throw Fault("TB-MODBUS-PROTOCOL", device_,
                what + (result >= 0 ? fmt::format("the answer speaks of {} instead of {}", result, request.expected)
                                    : std::string(modbus_strerror(error))),
                "Check that host and port belong to the module and that no other program shares its gateway.");
  }
  throw Fault("TB-MODBUS-CONNECT", device_, what + fmt::format("the connection broke ({})", modbus_strerror(error)),
              "Check the module's power and network cable; the next request connects anew.");
}

void ModbusLink::read_input_registers(int address, std::span<std::uint16_t> into) {
  exchange({"reading", 4, address, into.size(), MODBUS_MAX_READ_REGISTERS, into.size()}, [&](modbus_t* modbus) {
    return modbus_read_input_registers(modbus, address, static_cast<int>(into.size()), into.data());
  });
}

void ModbusLink::read_holding_registers(int address, std::span<std::uint16_t> into) {
  exchange({"reading", 3, address, into.size(), MODBUS_MAX_READ_REGISTERS, into.size()}, [&](modbus_t* modbus) {
    return modbus_read_registers(modbus, address, static_cast<int>(into.size()), into.data());
  });
}

void ModbusLink::write_registers(int address, std::span<const std::uint16_t> values) {
  exchange({"writing", 16, address, values.size(), MODBUS_MAX_WRITE_REGISTERS, values.size()}, [&](modbus_t* modbus) {
    return modbus_write_registers(modbus, address, static_cast<int>(values.size()), values.data());
  });
}

void ModbusLink::write_and_read_registers(int write_address, std::span<const std::uint16_t> values, int read_address,
                                          std::span<std::uint16_t> into) {
  // libmodbus returns the number of registers read; the two sizes have limits of their own.
  const std::size_t most =
      into.empty() || into.size() > MODBUS_MAX_WR_READ_REGISTERS ? 0 : MODBUS_MAX_WR_WRITE_REGISTERS;
  exchange(
      {"writing (and reading inputs)", 23, write_address, values.size(), most, into.size()}, [&](modbus_t* modbus) {
        return modbus_write_and_read_registers(modbus, write_address, static_cast<int>(values.size()), values.data(),
                                               read_address, static_cast<int>(into.size()), into.data());
      });
}

}  // namespace tactbench::devices
