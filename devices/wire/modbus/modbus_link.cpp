#include "devices/wire/modbus/modbus_link.h"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <modbus.h>
#include <netdb.h>
#include <poll.h>
#include <sys/file.h>
#include <sys/ioctl.h>
#include <sys/select.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <thread>
#include <utility>

#include "devices/device.h"
#include "devices/wire/byte_stream.h"
#include "devices/wire/wait.h"

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

namespace {

using RealClock = std::chrono::steady_clock;

constexpr std::size_t kTcpHeader = 6;  // transaction, protocol, length
constexpr std::size_t kCheckSum = 2;
constexpr Nanoseconds kRestOfEcho = std::chrono::milliseconds(50);
// Rates of which libmodbus 3.1.6 knows the constant.
constexpr std::array kRates{110,   300,   600,    1200,   2400,   4800,   9600,   19200,
                            38400, 57600, 115200, 230400, 460800, 500000, 576000, 921600};

// Modbus over serial line 1.02, section 2.5.1.1: 3.5 characters of 11 bits between frames, 1.75 ms above 19200 baud.
RealClock::duration frame_gap(int baud) {
  return baud > 19200 ? std::chrono::microseconds(1750) : std::chrono::microseconds(38'500'000 / baud);
}

// libmodbus waits with select(), which cannot hold a descriptor beyond FD_SETSIZE.
bool beyond_select(int descriptor) { return descriptor >= FD_SETSIZE; }

// The descriptor that the system would give now.
int next_descriptor() {
  const int next = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  ::close(next);
  return next;
}

// modbus_send_raw_request() would give each request the transaction id 0.
int send_tcp(int socket, std::uint16_t transaction, std::span<const std::uint8_t> request) {
  std::vector<std::uint8_t> frame{
      static_cast<std::uint8_t>(transaction >> 8U),    static_cast<std::uint8_t>(transaction & 0xFFU),   0, 0,
      static_cast<std::uint8_t>(request.size() >> 8U), static_cast<std::uint8_t>(request.size() & 0xFFU)};
  frame.insert(frame.end(), request.begin(), request.end());
  const ssize_t sent = ::send(socket, frame.data(), frame.size(), MSG_NOSIGNAL);
  return sent == static_cast<ssize_t>(frame.size()) ? static_cast<int>(sent) : -1;
}

}  // namespace

struct ModbusLine::Context {
  modbus_t* modbus = nullptr;
  ~Context() {
    if (modbus == nullptr) return;
    modbus_close(modbus);
    modbus_free(modbus);
  }
};

ModbusLine::ModbusLine(ModbusEndpoint endpoint, Clock& clock) : endpoint_(std::move(endpoint)), clock_(clock) {}

ModbusLine::~ModbusLine() = default;

void ModbusLine::close() noexcept { context_.reset(); }

void ModbusLine::close_after_error() noexcept {
  close();
  if (is_rtu()) quiet_until_ = RealClock::now() + endpoint_.max_reply_delay;
}

void ModbusLine::look_up(const std::string& device, const std::string& peer) {
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
    throw Fault("TB-MODBUS-CONNECT", device,
                fmt::format("connecting to {}: the host's name has no address ({})", peer, gai_strerror(result)),
                "Check the host in the bench file, or give its IPv4 address.");
  }
  char text[NI_MAXHOST] = "";
  getnameinfo(found->ai_addr, found->ai_addrlen, text, sizeof text, nullptr, 0, NI_NUMERICHOST);
  freeaddrinfo(found);
  address_ = text;
}

void ModbusLine::open(const std::string& device, const std::string& peer) {
  auto fresh = std::make_unique<Context>();
  if (is_rtu()) {
    if (std::find(kRates.begin(), kRates.end(), endpoint_.baud) == kRates.end()) fail(EINVAL, device, peer);
    std::this_thread::sleep_until(quiet_until_);
    fresh->modbus =
        modbus_new_rtu(endpoint_.serial_port.c_str(), endpoint_.baud, endpoint_.parity, 8, endpoint_.stop_bits);
  } else {
    if (address_.empty()) look_up(device, peer);
    fresh->modbus = modbus_new_tcp(address_.c_str(), endpoint_.port);
  }
  const auto timeout = std::chrono::duration_cast<std::chrono::microseconds>(endpoint_.response_timeout).count();
  // With a byte timeout of 0 the response timeout bounds the whole reply: a peer that sends slowly cannot extend it.
  const bool set = fresh->modbus != nullptr && timeout > 0 && modbus_set_slave(fresh->modbus, endpoint_.unit) == 0 &&
                   modbus_set_response_timeout(fresh->modbus, static_cast<std::uint32_t>(timeout / 1'000'000),
                                               static_cast<std::uint32_t>(timeout % 1'000'000)) == 0 &&
                   modbus_set_byte_timeout(fresh->modbus, 0, 0) == 0;
  if (!set) fail(EINVAL, device, peer);
  if (beyond_select(next_descriptor())) fail(EMFILE, device, peer);  // libmodbus waits for a connection, too
  errno = 0;
  int result = modbus_connect(fresh->modbus);
  if (result != 0 && errno == EINTR) result = modbus_connect(fresh->modbus);
  // libmodbus leaves EINPROGRESS when its wait for the connection timed out.
  if (result != 0) fail(errno == EINPROGRESS ? ETIMEDOUT : errno, device, peer);
  const int descriptor = modbus_get_socket(fresh->modbus);
  if (beyond_select(descriptor)) fail(EMFILE, device, peer);  // another thread has opened files meanwhile
  if (is_rtu() && endpoint_.lock && flock(descriptor, LOCK_EX | LOCK_NB) != 0) fail(EBUSY, device, peer);
  // On a pseudo-terminal it would outlive a killed client, since the simulated end keeps the terminal open.
  if (is_rtu() && endpoint_.exclusive && !is_stream_address(endpoint_.serial_port)) ioctl(descriptor, TIOCEXCL);
  context_ = std::move(fresh);
  transaction_ = 0;
}

void ModbusLine::fail(int error, const std::string& device, const std::string& peer) {
  const std::string what = fmt::format("connecting to {}: ", peer);
  if (error == ETIMEDOUT) {
    clock_.reply_lost(endpoint_.response_timeout);
    throw Fault("TB-MODBUS-TIMEOUT", device,
                what + fmt::format("no answer within {:g} ms",
                                   std::chrono::duration<double, std::milli>(endpoint_.response_timeout).count()),
                "Check the module's power and network cable, and the host in the bench file.");
  }
  if (error == EINVAL) {
    throw Fault("TB-MODBUS-CONNECT", device,
                what + (is_rtu() ? fmt::format("{} baud, parity {}, {} stop bits or the unit is not valid",
                                               endpoint_.baud, endpoint_.parity, endpoint_.stop_bits)
                                 : "address, port, unit or response timeout is not valid"),
                is_rtu() ? fmt::format("Correct the endpoint in the bench file. Rates: {}.", fmt::join(kRates, ", "))
                         : "Correct the endpoint in the bench file.");
  }
  if (error == EBUSY) {
    throw Fault("TB-MODBUS-CONNECT", device, what + "another program has the port open",
                "Stop the other program; a serial port has one owner.");
  }
  throw Fault("TB-MODBUS-CONNECT", device, what + modbus_strerror(error),
              is_rtu() ? "Check the adapter's cable, the port in the bench file and who may open it (group dialout)."
                       : "Check that the module is on and that host and port in the bench file are its own.");
}

void ModbusLine::wait_for_gap() {
  std::this_thread::sleep_until(quiet_until_);
  modbus_flush(context_->modbus);  // a late answer to an earlier request, or noise
}

// Waits here, not in libmodbus, which does not know simulated ends. The rest of the reply gets the remaining time.
int ModbusLine::receive(std::span<std::uint8_t> answer) {
  const RealTime end = RealClock::now() + endpoint_.response_timeout;
  if (wait_for(modbus_get_socket(context_->modbus), POLLIN, endpoint_.response_timeout) == 0) {
    errno = ETIMEDOUT;
    return -1;
  }
  constexpr std::chrono::microseconds kLeast(1000);  // for bytes that have already arrived
  const auto left = std::max(kLeast, std::chrono::duration_cast<std::chrono::microseconds>(end - RealClock::now()));
  modbus_set_response_timeout(context_->modbus, static_cast<std::uint32_t>(left.count() / 1'000'000),
                              static_cast<std::uint32_t>(left.count() % 1'000'000));
  return modbus_receive_confirmation(context_->modbus, answer.data());
}

// Fills `into` as far as bytes come in time; returns their number.
std::size_t ModbusLine::read(std::span<std::uint8_t> into, Nanoseconds timeout) {
  const RealTime end = RealClock::now() + timeout;
  const int descriptor = modbus_get_socket(context_->modbus);
  std::size_t came = 0;
  while (came < into.size() && (wait_for(descriptor, POLLIN, left_until(end)) & POLLIN) != 0) {
    const ssize_t got = ::read(descriptor, into.data() + came, into.size() - came);
    if (got <= 0) break;
    came += static_cast<std::size_t>(got);
  }
  return came;
}

// An echo that differs is another sender's, or the answer itself of an adapter that does not echo.
bool ModbusLine::take_echo(std::span<const std::uint8_t> sent) {
  std::vector<std::uint8_t> echo(sent.size());
  errno = read(echo, endpoint_.response_timeout) < echo.size() ? ETIMEDOUT : EMBBADDATA;
  if (std::equal(echo.begin(), echo.end(), sent.begin())) return true;
  echo_ = Echo::kMissing;
  return false;
}

// Whether what came begins with the whole request. Of it libmodbus has read as much as an answer would have.
bool ModbusLine::is_echo(std::span<const std::uint8_t> sent, std::span<std::uint8_t> came) {
  if (came[0] != sent[0] || came[1] != sent[1]) return false;
  constexpr std::size_t kAnswerToWriting = 8, kHead = 3;
  std::size_t begun = sent[1] == 5 || sent[1] == 6 || sent[1] == 16 ? kAnswerToWriting : kHead + kCheckSum + came[2];
  if (begun > MODBUS_RTU_MAX_ADU_LENGTH) begun = kHead;  // an answer cannot be as long
  if (begun < sent.size()) (void)read(came.subspan(begun, sent.size() - begun), kRestOfEcho);
  return std::equal(sent.begin(), sent.end(), came.begin());
}

void ModbusLine::note_busy(std::string words) {
  ++busy_;
  busy_text_ = fmt::format("{}{}", std::move(words), busy_ > 1 ? fmt::format("; {} times so far", busy_) : "");
}

std::string ModbusLine::take_busy_report() {
  if (busy_ < next_busy_report_) return {};
  next_busy_report_ = 2 * busy_;
  return busy_text_;
}

std::vector<std::uint8_t> ModbusLine::exchange(std::span<const std::uint8_t> request) {
  modbus_t* modbus = context_->modbus;
  if (is_rtu()) wait_for_gap();
  std::array<std::uint8_t, MODBUS_TCP_MAX_ADU_LENGTH> answer{};
  errno = 0;
  modbus_set_slave(modbus, request[0]);
  int length = is_rtu() ? modbus_send_raw_request(modbus, request.data(), static_cast<int>(request.size()))
                        : send_tcp(modbus_get_socket(modbus), ++transaction_, request);
  echo_ = Echo::kAsExpected;
  const std::vector<std::uint8_t> sent = is_rtu() ? rtu_frame(request) : std::vector<std::uint8_t>();
  if (length > 0 && endpoint_.local_echo && is_rtu() && !take_echo(sent)) length = -1;
  if (length > 0) length = receive(answer);
  error_ = length == 0 ? EMBBADSLAVE : errno;  // 0: libmodbus ignores another unit's answer
  if (length <= 0 && is_rtu() && !endpoint_.local_echo && is_echo(sent, answer)) echo_ = Echo::kCame;
  if (is_rtu()) quiet_until_ = RealClock::now() + frame_gap(endpoint_.baud);
  if (length > 0) {  // then libmodbus has found unit, function and more
    const auto bytes = std::span(answer).first(static_cast<std::size_t>(length));
    if (is_rtu()) return {bytes.begin(), bytes.end() - kCheckSum};
    if (bytes[0] == transaction_ >> 8U && bytes[1] == (transaction_ & 0xFFU) && bytes[2] == 0 && bytes[3] == 0) {
      return {bytes.begin() + kTcpHeader, bytes.end()};
    }
    error_ = EMBBADDATA;
  }
  close_after_error();
  return {};
}

std::uint16_t crc16_modbus(std::span<const std::uint8_t> bytes) {
  unsigned crc = 0xFFFF;
  for (const std::uint8_t byte : bytes) {
    crc ^= byte;
    for (int bit = 0; bit < 8; ++bit) crc = (crc & 1U) != 0 ? crc >> 1U ^ 0xA001U : crc >> 1U;
  }
  return static_cast<std::uint16_t>(crc);
}

std::vector<std::uint8_t> rtu_frame(std::span<const std::uint8_t> body) {
  std::vector<std::uint8_t> frame(body.begin(), body.end());
  const unsigned crc = crc16_modbus(body);
  frame.push_back(static_cast<std::uint8_t>(crc & 0xFFU));
  frame.push_back(static_cast<std::uint8_t>(crc >> 8U));
  return frame;
}

}  // namespace tactbench::devices
