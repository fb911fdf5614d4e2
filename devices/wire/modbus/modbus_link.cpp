#include "devices/wire/modbus/modbus_link.h"

#include <fmt/format.h>
#include <modbus.h>

#include <cerrno>
#include <utility>

#include "devices/device.h"
#include "devices/wire/modbus/modbus_line.h"

namespace tactbench::devices {
namespace {

constexpr const char* kMisfitRemedy =
    "Check that the address belongs to the module and that no other program shares its wire.";
constexpr std::uint8_t kExceptionBit = 0x80;
constexpr Nanoseconds kBusyPause = std::chrono::milliseconds(20);

void put(std::vector<std::uint8_t>& bytes, std::size_t word) {
  bytes.push_back(static_cast<std::uint8_t>(word >> 8U & 0xFFU));
  bytes.push_back(static_cast<std::uint8_t>(word & 0xFFU));
}

}  // namespace

struct ModbusLink::Request {
  const char* verb;
  const char* unit_of_count;
  int function;
  int address;
  std::size_t count;
  bool fits;                           // a frame can hold it
  std::vector<std::uint8_t> body;      // after the function code
  std::vector<std::uint8_t> expected;  // how the answer begins after the function code
  std::size_t answer_bytes;            // of the answer after the function code
};

ModbusLink::ModbusLink(ModbusEndpoint endpoint, std::string device, Clock& clock)
    : line_(std::make_shared<ModbusLine>(std::move(endpoint), clock)),
      unit_(line_->endpoint().unit),
      device_(std::move(device)) {}

ModbusLink::ModbusLink(const ModbusLink& other, int unit, std::string device)
    : line_(other.line_), unit_(unit), device_(std::move(device)) {}

ModbusLink::~ModbusLink() = default;

const ModbusEndpoint& ModbusLink::endpoint() const { return line_->endpoint(); }

void ModbusLink::close() noexcept { line_->close(); }

std::string ModbusLink::peer() const {
  const ModbusEndpoint& at = endpoint();
  return line_->is_rtu() ? fmt::format("{} at {} ({} baud, 8{}{}) unit {}", device_, at.serial_port, at.baud, at.parity,
                                       at.stop_bits, unit_)
                         : fmt::format("{} at {}:{} unit {}", device_, at.host, at.port, unit_);
}

std::string ModbusLink::take_busy_report() const { return line_->take_busy_report(); }

void ModbusLink::fail_without_answer(const std::string& what, std::size_t sent) {
  const int error = line_->error();
  if (error == ETIMEDOUT) line_->clock().reply_lost(endpoint().response_timeout);
  if (line_->echo() == ModbusLine::Echo::kCame) {
    throw Fault(
        "TB-MODBUS-ECHO", device_,
        what + fmt::format("the first {} bytes of the answer are the request itself: the adapter echoes", sent),
        "Switch off the adapter's echo (its receiver must rest while it sends), or write local_echo = true beside "
        "serial_port in the bench file.");
  }
  if (line_->echo() == ModbusLine::Echo::kMissing) {
    throw Fault(
        "TB-MODBUS-ECHO", device_,
        what + fmt::format("local_echo is set, and the {} bytes that were sent did not come back as they were", sent),
        "Remove local_echo from the bench file where the adapter has no echo; else another program or master sends "
        "on this line, or its wires are crossed.");
  }
  if (error == ETIMEDOUT) {
    throw Fault("TB-MODBUS-TIMEOUT", device_,
                what + fmt::format("no complete reply within {:g} ms", in_milliseconds(endpoint().response_timeout)),
                "Check the module's power, cable and unit number.");
  }
  if (error > MODBUS_ENOBASE) {
    throw Fault("TB-MODBUS-PROTOCOL", device_, what + modbus_strerror(error), kMisfitRemedy);
  }
  throw Fault("TB-MODBUS-CONNECT", device_, what + fmt::format("the connection broke ({})", modbus_strerror(error)),
              "Check the module's power and cable; the next request reconnects.");
}

// Returns the answer's bytes after the function code.
std::vector<std::uint8_t> ModbusLink::exchange(const Request& request) {
  const auto what = [&] {  // only for faults: a good exchange formats nothing
    return fmt::format("{} {} {}{} at 0x{:04X} (FC {}) of {}: ", request.verb, request.count, request.unit_of_count,
                       request.count == 1 ? "" : "s", request.address, request.function, peer());
  };
  const auto misfit = [&](const std::string& why) {
    return Fault("TB-MODBUS-PROTOCOL", device_, what() + why, kMisfitRemedy);
  };
  if (!request.fits) throw misfit("more than one frame can hold, or nothing");
  std::vector<std::uint8_t> bytes{static_cast<std::uint8_t>(unit_), static_cast<std::uint8_t>(request.function)};
  bytes.insert(bytes.end(), request.body.begin(), request.body.end());
  const auto fail = [&](const std::string& why) {
    line_->close_after_error();
    throw misfit(why);
  };
  Clock& clock = line_->clock();
  const Nanoseconds begun = clock.now();
  std::vector<std::uint8_t> answer;
  for (std::uint8_t busy = 0;;) {
    if (!line_->is_open()) line_->open(device_, peer());
    ++exchanges_;
    answer = line_->exchange(bytes);
    if (answer.empty()) fail_without_answer(what(), bytes.size() + 2);
    if (answer[0] != unit_) fail(fmt::format("unit {} answered", answer[0]));
    const bool refused = answer[1] == (request.function | kExceptionBit) && answer.size() == 3;  // and complete
    const auto refusal = [&](std::uint8_t number) {
      return fmt::format("exception {} ({})", number, modbus_strerror(MODBUS_ENOBASE + number));
    };
    const double waited_ms = in_milliseconds(clock.now() - begun);
    if (refused && (answer[2] == MODBUS_EXCEPTION_ACKNOWLEDGE || answer[2] == MODBUS_EXCEPTION_SLAVE_OR_SERVER_BUSY)) {
      busy = answer[2];
      if (clock.now() - begun >= endpoint().busy_time)
        throw Fault("TB-MODBUS-BUSY", device_,
                    what() + fmt::format("busy for {:.0f} ms: {}", waited_ms, refusal(busy)));
      clock.wait_until(clock.now() + kBusyPause);
      continue;
    }
    if (refused) {
      throw Fault("TB-MODBUS-EXCEPTION", device_, what() + "refused with " + refusal(answer[2]),
                  "Check that the profile in the bench file fits the module, that no other master holds it, and that "
                  "its watchdog has not tripped.");
    }
    if (busy != 0) line_->note_busy(what() + fmt::format("{}, asked again for {:.0f} ms", refusal(busy), waited_ms));
    break;
  }
  if (answer[1] != request.function) fail(fmt::format("the answer is to function {}", answer[1]));
  answer.erase(answer.begin(), answer.begin() + 2);
  if (answer.size() != request.answer_bytes ||
      !std::equal(request.expected.begin(), request.expected.end(), answer.begin())) {
    fail(fmt::format("the answer does not fit the request ({} bytes instead of {}, or another address or count)",
                     answer.size(), request.answer_bytes));
  }
  return answer;
}

void ModbusLink::read_registers(int function, int address, std::span<std::uint16_t> into, std::size_t readable) {
  std::size_t count = into.size();
  if (line_->is_rtu() && count + 1 <= readable && count < MODBUS_MAX_READ_REGISTERS) {
    if (longer_) ++count;
    longer_ = !longer_;
  }
  Request request{"reading",    "register",
                  function,     address,
                  count,        count > 0 && count <= MODBUS_MAX_READ_REGISTERS,
                  {},           {static_cast<std::uint8_t>(2 * count)},
                  1 + 2 * count};
  put(request.body, static_cast<std::size_t>(address));
  put(request.body, count);
  const auto answer = exchange(request);
  for (std::size_t i = 0; i < into.size(); ++i) {
    into[i] = static_cast<std::uint16_t>(answer[1 + 2 * i] << 8U | answer[2 + 2 * i]);
  }
}

void ModbusLink::read_input_registers(int address, std::span<std::uint16_t> into, std::size_t readable) {
  read_registers(4, address, into, readable);
}

void ModbusLink::read_holding_registers(int address, std::span<std::uint16_t> into, std::size_t readable) {
  read_registers(3, address, into, readable);
}

std::vector<bool> ModbusLink::read_discrete_inputs(int address, int count) {
  const auto bits = static_cast<std::size_t>(count);
  const std::size_t bytes = (bits + 7) / 8;
  Request request{"reading", "discrete input",
                  2,         address,
                  bits,      count > 0 && count <= MODBUS_MAX_READ_BITS,
                  {},        {static_cast<std::uint8_t>(bytes)},
                  1 + bytes};
  put(request.body, static_cast<std::size_t>(address));
  put(request.body, bits);
  const auto answer = exchange(request);
  std::vector<bool> values(bits);
  for (std::size_t i = 0; i < bits; ++i) values[i] = (answer[1 + i / 8] >> (i % 8) & 1U) != 0;
  return values;
}

void ModbusLink::write_coil(int address, bool value) {
  Request request{"writing", "coil", 5, address, 1, true, {}, {}, 4};
  put(request.body, static_cast<std::size_t>(address));
  put(request.body, value ? 0xFF00 : 0);
  request.expected = request.body;
  (void)exchange(request);
}

void ModbusLink::write_register(int address, std::uint16_t value) {
  Request request{"writing", "register", 6, address, 1, true, {}, {}, 4};
  put(request.body, static_cast<std::size_t>(address));
  put(request.body, value);
  request.expected = request.body;
  (void)exchange(request);
}

void ModbusLink::write_registers(int address, std::span<const std::uint16_t> values) {
  const std::size_t count = values.size();
  Request request{"writing", "register", 16, address, count, count > 0 && count <= MODBUS_MAX_WRITE_REGISTERS,
                  {},        {},         4};
  put(request.body, static_cast<std::size_t>(address));
  put(request.body, count);
  request.expected = request.body;
  request.body.push_back(static_cast<std::uint8_t>(2 * count));
  for (const std::uint16_t value : values) put(request.body, value);
  (void)exchange(request);
}

void ModbusLink::write_and_read_registers(int write_address, std::span<const std::uint16_t> values, int read_address,
                                          std::span<std::uint16_t> into) {
  const std::size_t count = values.size();
  const bool fits = count > 0 && count <= MODBUS_MAX_WR_WRITE_REGISTERS && !into.empty() &&
                    into.size() <= MODBUS_MAX_WR_READ_REGISTERS;
  Request request{"writing (and reading inputs)",
                  "register",
                  23,
                  write_address,
                  count,
                  fits,
                  {},
                  {static_cast<std::uint8_t>(2 * into.size())},
                  1 + 2 * into.size()};
  put(request.body, static_cast<std::size_t>(read_address));
  put(request.body, into.size());
  put(request.body, static_cast<std::size_t>(write_address));
  put(request.body, count);
  request.body.push_back(static_cast<std::uint8_t>(2 * count));
  for (const std::uint16_t value : values) put(request.body, value);
  const auto answer = exchange(request);
  for (std::size_t i = 0; i < into.size(); ++i) {
    into[i] = static_cast<std::uint16_t>(answer[1 + 2 * i] << 8U | answer[2 + 2 * i]);
  }
}

}  // namespace tactbench::devices
