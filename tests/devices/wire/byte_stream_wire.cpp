// Byte streams over a pseudo-terminal, TCP and a local socket; libserialport itself runs on a real port only.

#include <arpa/inet.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <termios.h>
#include <unistd.h>
#include <catch2/catch.hpp>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <functional>
#include <memory>
#include <numeric>
#include <thread>
#include <vector>

#include "devices/wire/byte_stream.h"
#include "devices/wire/ends/end_activity.h"
#include "devices/wire/ends/stream_end.h"
#include "devices/wire/wait.h"
#include "tests/devices/fault_of.h"
#include "tests/devices/full_queue.h"
#include "tests/devices/packet_listener.h"
#include "tests/devices/timeouts.h"
#include "tests/support/process.h"

using namespace std::chrono_literals;
using namespace tactbench::devices;
using tactbench::tests::TemporaryFolder;

namespace {

using Bytes = std::vector<std::uint8_t>;

SerialAddress at(const std::string& port, const std::string& usb_serial = "") {
  SerialAddress address;
  address.port = port;
  address.usb_serial = usb_serial;
  return address;
}

Bytes read_exactly(ByteStream& stream, std::size_t count) {
  Bytes all;
  std::array<std::uint8_t, 300> some{};
  while (all.size() < count) {
    const std::size_t got = stream.read(some, 5s);
    if (got == 0) break;
    all.insert(all.end(), some.begin(), some.begin() + static_cast<std::ptrdiff_t>(got));
  }
  return all;
}

Bytes read_exactly(int descriptor, std::size_t count) {
  Bytes all(count);
  std::size_t have = 0;
  while (have < count) {
    pollfd waited{descriptor, POLLIN, 0};
    if (::poll(&waited, 1, 5000) != 1) break;
    const ssize_t got = ::read(descriptor, all.data() + have, count - have);
    if (got <= 0) break;
    have += static_cast<std::size_t>(got);
  }
  all.resize(have);
  return all;
}

// Every value of a byte: none may be changed, swallowed or taken as a control character.
Bytes all_values() {
  Bytes bytes(256);
  std::iota(bytes.begin(), bytes.end(), std::uint8_t{0});
  return bytes;
}

void check_both_ways(ByteStream& stream, int other_end) {
  stream.write(all_values());
  CHECK(read_exactly(other_end, 256) == all_values());
  const Bytes back = all_values();
  REQUIRE(::write(other_end, back.data(), back.size()) == 256);
  CHECK(read_exactly(stream, 256) == all_values());
  std::array<std::uint8_t, 8> nothing{};
  CHECK(stream.read(nothing, 0ns) == 0);
}

int accept_one(int listener) {
  pollfd waited{listener, POLLIN, 0};
  REQUIRE(::poll(&waited, 1, 5000) == 1);
  return ::accept4(listener, nullptr, nullptr, SOCK_CLOEXEC);
}

}  // namespace

TEST_CASE("pseudo-terminal: carries every byte value unchanged in both directions") {
  PseudoTerminal terminal;
  const auto stream = open_stream(terminal.path());
  check_both_ways(*stream, terminal.master());
  CHECK(stream->description() == terminal.path());
}

TEST_CASE("pseudo-terminal: serves one client at a time, and the next one after it closes") {
  PseudoTerminal terminal;
  auto first = open_stream(terminal.path());
  CHECK(fault_id_of([&] { (void)open_stream(terminal.path()); }) == "TB-SERIAL-BUSY");
  first.reset();
  // Bytes that the first client left unread do not reach the second.
  const Bytes stale{1, 2, 3};
  REQUIRE(::write(terminal.master(), stale.data(), stale.size()) == 3);
  const auto second = open_stream(terminal.path());
  check_both_ways(*second, terminal.master());
}

TEST_CASE("stream: discard drops unread bytes and returns their number") {
  PseudoTerminal terminal;
  const auto stream = open_stream(terminal.path());
  const Bytes waiting{1, 2, 3};
  REQUIRE(::write(terminal.master(), waiting.data(), waiting.size()) == 3);
  std::array<std::uint8_t, 1> first{};
  REQUIRE(stream->read(first, 5s) == 1);
  CHECK(stream->discard() == 2);
  CHECK(stream->discard() == 0);
}

TEST_CASE("pseudo-terminal: a hang-up is a lost connection, not silence") {
  PseudoTerminal terminal;
  const auto stream = open_stream(terminal.path());
  terminal.hang_up();
  std::array<std::uint8_t, 8> into{};
  const Bytes out{1};
  CHECK(fault_id_of([&] { (void)stream->read(into, 24h); }) == "TB-SERIAL-LOST");
  CHECK(fault_id_of([&] { stream->write(out); }) == "TB-SERIAL-LOST");
  CHECK(fault_id_of([&] { stream->discard(); }) == "TB-SERIAL-LOST");
  CHECK(terminal.master() == -1);
  const PseudoTerminal another;
  CHECK(another.path() != terminal.path());  // which another program's terminal might have, and the client would open
  CHECK(fault_id_of([&] { (void)open_stream(terminal.path()); }) == "TB-SERIAL-OPEN");
}

TEST_CASE("stream: a write times out if the other end reads nothing") {
  PseudoTerminal terminal;
  const auto stream = open_stream(terminal.path(), 1ms);
  const Bytes many(1U << 20U);
  CHECK(fault_id_of([&] { stream->write(many); }) == "TB-SERIAL-TIMEOUT");
}

namespace {

// `listener` hears at `name`.
void check_socket(int listener, const std::string& name) {
  const auto stream = open_serial(at(name));
  const int other_end = accept_one(listener);
  check_both_ways(*stream, other_end);
  ::close(other_end);
  std::array<std::uint8_t, 8> into{};
  CHECK(fault_id_of([&] { (void)stream->read(into, 24h); }) == "TB-SERIAL-LOST");
  ::close(listener);
  CHECK(fault_id_of([&] { (void)open_stream(name); }) == "TB-SERIAL-OPEN");
}

}  // namespace

TEST_CASE("stream: TCP and local sockets carry bytes both ways and report the end of the connection") {
  const BoundSocket tcp = bind_loopback(SOCK_STREAM, 0, "test");
  check_socket(tcp.socket, "tcp:127.0.0.1:" + std::to_string(tcp.port));
  const TemporaryFolder folder;
  const std::string path = folder.path("end");
  const int listener = bound_at(path, SOCK_STREAM);
  REQUIRE(::listen(listener, 1) == 0);
  check_socket(listener, "unix:" + path);
}

TEST_CASE("stream: a serial address that is a link to a pseudo-terminal opens the pseudo-terminal") {
  PseudoTerminal terminal;
  const auto link = std::filesystem::temp_directory_path() / ("tactbench-link-" + std::to_string(::getpid()));
  std::filesystem::remove(link);
  std::filesystem::create_symlink(terminal.path(), link);
  const auto stream = open_serial(at(link.string()));
  std::filesystem::remove(link);
  check_both_ways(*stream, terminal.master());
  CHECK(stream->description() == terminal.path());
}

TEST_CASE("serial ports: listed ports have names and are never pseudo-terminals") {
  const PseudoTerminal terminal;
  for (const SerialPortInfo& port : list_serial_ports()) {
    CHECK(port.name.starts_with("/dev/"));
    CHECK(port.name != terminal.path());
  }
}

namespace {

std::string opening(const std::string& address) {
  return fault_id_of([&] { (void)open_stream(address, kShort); });
}

}  // namespace

TEST_CASE("stream: each malformed address and each failed opening is a fault") {
  const FullQueue unheard;
  for (const std::string& address :
       {std::string("tcp:"), std::string("tcp:127.0.0.1"), std::string("tcp::5"), std::string("tcp:127.0.0.1:"),
        std::string("tcp:127.0.0.1:no such service"), std::string("/dev/pts/999999"), std::string("/dev/pts/../null"),
        std::string("unix:/nowhere/at/all"), "unix:" + std::string(200, 'x'),
        "tcp:127.0.0.1:" + std::to_string(unheard.port())}) {
    INFO(address);
    CHECK(opening(address) == "TB-SERIAL-OPEN");
  }
  for (const char* address : {"serial", "/dev/ttyS0", "/dev/null", "udp:127.0.0.1:5"}) {
    CHECK(opening(address) == "TB-SERIAL-OPEN");
    CHECK_FALSE(is_stream_address(address));
  }
  for (const char* address : {"/dev/pts/3", "tcp:x", "unix:x"}) CHECK(is_stream_address(address));
}

TEST_CASE("stream: an opening that is not answered ends after its timeout") {
  FullQueue queue;
  queue.fill();
  const std::string name = "tcp:127.0.0.1:" + std::to_string(queue.port());
  CHECK(opening(name) == "TB-SERIAL-OPEN");
}

TEST_CASE("stream: an IPv6 address may be written with or without matching brackets") {
  const int listener = ::socket(AF_INET6, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_in6 address{};
  address.sin6_family = AF_INET6;
  address.sin6_addr = in6addr_loopback;
  socklen_t size = sizeof address;
  if (listener < 0 || ::bind(listener, reinterpret_cast<const sockaddr*>(&address), size) != 0) return;  // no IPv6 here
  REQUIRE(::listen(listener, 4) == 0);
  REQUIRE(::getsockname(listener, reinterpret_cast<sockaddr*>(&address), &size) == 0);
  const std::string port = std::to_string(ntohs(address.sin6_port));
  CHECK(opening("tcp:[::1]:" + port) == "none");
  CHECK(opening("tcp:::1:" + port) == "none");
  for (const char* host : {"[::1", "::1]", "x::1]", "[::1x", "[]", "[", "]"}) {
    CHECK(opening("tcp:" + std::string(host) + ":" + port) == "TB-SERIAL-OPEN");
  }
  ::close(listener);
}

TEST_CASE("stream: a pseudo-terminal is in raw mode at both ends") {
  const PseudoTerminal terminal;
  const auto check_raw = [](int descriptor) {
    termios settings{};
    REQUIRE(::tcgetattr(descriptor, &settings) == 0);
    CHECK((settings.c_lflag & (ECHO | ICANON | ISIG | IEXTEN)) == 0);
    CHECK((settings.c_oflag & OPOST) == 0);
    return settings;
  };
  check_raw(terminal.master());  // before any client
  const auto stream = open_stream(terminal.path());
  const termios settings = check_raw(stream->descriptor());
  CHECK((settings.c_cflag & CLOCAL) != 0);
  CHECK((settings.c_cflag & CREAD) != 0);
  CHECK(settings.c_cc[VMIN] == 1);
  CHECK(settings.c_cc[VTIME] == 0);
  CHECK(::fcntl(stream->descriptor(), F_GETFD) == FD_CLOEXEC);
  CHECK((::fcntl(stream->descriptor(), F_GETFL) & O_NONBLOCK) != 0);
  CHECK(::fcntl(terminal.master(), F_GETFD) == FD_CLOEXEC);
}

TEST_CASE("stream: a closed peer, a full device and a folder are lost-connection faults") {
  const std::array<std::uint8_t, 5> bytes{1, 2, 3, 4, 5};
  std::array<std::uint8_t, 8> into{};
  std::array<int, 2> line{};
  REQUIRE(::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0, line.data()) == 0);
  const auto socket = adopt_stream(line[0], "the line");
  CHECK(socket->read(into, 0ns) == 0);
  CHECK(socket->read(into, 1ms) == 0);
  ::close(line[1]);
  const std::string lost = "TB-SERIAL-LOST";
  CHECK(fault_id_of([&] { (void)socket->read(into, kPatient); }) == lost);
  CHECK(fault_id_of([&] { socket->write(bytes); }) == lost);
  const auto full = adopt_stream(::open("/dev/full", O_RDWR | O_CLOEXEC), "a full disk");
  CHECK(fault_id_of([&] { full->write(bytes); }) == lost);
  const auto folder = adopt_stream(::open("/", O_RDONLY | O_CLOEXEC), "a folder");
  CHECK(fault_id_of([&] { (void)folder->read(into, 0ns); }) == lost);
}

TEST_CASE("stream: discard ends even if the sender never stops") {
  const auto endless = adopt_stream(::open("/dev/zero", O_RDONLY | O_CLOEXEC), "endless");
  CHECK(endless->discard() == 1U << 20U);
}

TEST_CASE("stream: a write timeout states the number of unsent bytes, and a slow reader receives all bytes") {
  std::array<int, 2> line{};
  REQUIRE(::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0, line.data()) == 0);
  std::vector<std::uint8_t> many(1U << 20U);
  std::iota(many.begin(), many.end(), std::uint8_t{0});
  {
    const auto hurried = adopt_stream(::fcntl(line[0], F_DUPFD_CLOEXEC, 0), "the line", 2ms);
    const auto fault = whole_fault_of([&] { hurried->write(many); });
    REQUIRE(fault);
    CHECK(fault->id() == "TB-SERIAL-TIMEOUT");
    std::vector<std::uint8_t> taken(many.size());
    std::size_t count = 0;
    for (ssize_t got = 1; got > 0; count += static_cast<std::size_t>(std::max<ssize_t>(got, 0))) {
      got = ::recv(line[1], taken.data(), taken.size(), 0);
    }
    CHECK_THAT(fault->what(), Catch::Contains(" " + std::to_string(many.size() - count) + " "));
  }
  std::vector<std::uint8_t> read;
  std::thread reader([&] {
    std::array<std::uint8_t, 4096> some{};
    pollfd waited{line[1], POLLIN, 0};
    while (read.size() < many.size() && ::poll(&waited, 1, 20000) == 1) {
      const ssize_t got = ::recv(line[1], some.data(), some.size(), 0);
      if (got <= 0) break;
      read.insert(read.end(), some.begin(), some.begin() + got);
    }
  });
  const auto patient = adopt_stream(line[0], "the line", kPatient);
  CHECK(fault_id_of([&] { patient->write(many); }) == "none");
  reader.join();
  CHECK((read == many));
  ::close(line[1]);
}

namespace {

std::string listening(const std::string& listen) {
  return fault_id_of([&] { const StreamEnd end(listen); });
}

void next_event(const StreamEnd& end) {
  pollfd waited{end.descriptor(), POLLIN, 0};
  REQUIRE(::poll(&waited, 1, 20000) == 1);
}

// A local socket's path of this length.
std::string long_path(const TemporaryFolder& folder, std::size_t length) {
  const std::string begin = folder.path("x");
  REQUIRE(begin.size() < length);
  return begin + std::string(length - begin.size(), 'y');
}

int option_of(int socket, int level, int name) {
  int value = -1;
  socklen_t size = sizeof value;
  CHECK(::getsockopt(socket, level, name, &value, &size) == 0);
  return value;
}

}  // namespace

TEST_CASE("stream listener: an address that cannot be listened on is a fault") {
  for (const char* port : {"", "x", "1x", " 1", "-1", "65536", "70000", "99999999999"})
    CHECK(listening("tcp:" + std::string(port)) == "TB-SIM-LISTEN");
  for (const char* form : {"udp:5", "/dev/ttyS0", "TCP:0", "x"}) CHECK(listening(form) == "TB-SIM-LISTEN");
  const StreamEnd end("tcp:0");
  CHECK(end.address().starts_with("tcp:127.0.0.1:"));
  const std::string taken = "tcp:" + end.address().substr(14);
  CHECK(listening(taken) == "TB-SIM-LISTEN");
}

TEST_CASE("stream listener: the longest path of a local socket is the same for listener and client") {
  const TemporaryFolder folder;
  const std::string longest = "unix:" + long_path(folder, 107);
  StreamEnd end(longest);
  CHECK(end.address() == longest);
  CHECK(opening(longest) == "none");
  for (const std::string& address : {std::string("unix:"), "unix:" + long_path(folder, 108)}) {
    CHECK(listening(address) == "TB-SIM-LISTEN");
    CHECK(opening(address) == "TB-SERIAL-OPEN");
  }
}

TEST_CASE("stream listener: replaces the socket of a dead program, but not a live one's or another file") {
  const TemporaryFolder folder;
  const std::string address = "unix:" + folder.path("end");
  {
    const StreamEnd living(address);
    CHECK(listening(address) == "TB-SIM-LISTEN");
    CHECK(opening(address) == "none");
    errno = ECONNREFUSED;  // an older call's
    CHECK(listening(address) == "TB-SIM-LISTEN");
    // Its queue is full, and it lives.
    std::vector<std::unique_ptr<ByteStream>> clients;
    while (fault_id_of([&] { clients.push_back(open_stream(address, kShort)); }) == "none")
      REQUIRE(clients.size() < 99);
    CHECK(listening(address) == "TB-SIM-LISTEN");
    CHECK(std::filesystem::exists(folder.path("end")));
  }
  CHECK_FALSE(std::filesystem::exists(folder.path("end")));
  const std::string path = folder.path("end");
  ::close(bound_at(path, SOCK_STREAM));
  REQUIRE(std::filesystem::exists(path));
  CHECK(listening(address) == "none");
  std::ofstream(path) << "notes";
  CHECK(listening(address) == "TB-SIM-LISTEN");
  CHECK(tactbench::tests::read_file(path) == "notes");
}

TEST_CASE("stream listener: has no descriptor while unplugged, and its TCP or local address again once plugged in") {
  const TemporaryFolder folder;
  for (const std::string& listen : {std::string("tcp:0"), "unix:" + folder.path("end"), std::string()}) {
    INFO("'" << listen << "'");
    StreamEnd end(listen);
    const std::string before = end.address();
    std::array<std::uint8_t, 8> into{};
    auto client = open_stream(before);
    end.hang_up();
    CHECK(end.descriptor() == -1);
    CHECK(fault_id_of([&] { (void)client->read(into, kPatient); }) == "TB-SERIAL-LOST");
    end.send(into);  // to nobody
    client.reset();
    end.plug_in();
    CHECK(end.descriptor() >= 0);
    if (!listen.empty()) CHECK(end.address() == before);
    client = open_stream(end.address());
    end.plug_in();  // plugged in twice: the first client is gone
    CHECK(fault_id_of([&] { (void)client->read(into, kPatient); }) == "TB-SERIAL-LOST");
    CHECK(opening(end.address()) == "none");
  }
}

TEST_CASE("stream listener: serves one client at a time, and the second after the first disconnects") {
  StreamEnd end("tcp:0");
  std::array<std::uint8_t, 8> into{};
  CHECK(end.receive(into) == 0);  // nobody has come
  auto first = open_stream(end.address());
  next_event(end);
  CHECK(end.receive(into) == 0);
  CHECK(option_of(end.descriptor(), IPPROTO_TCP, TCP_NODELAY) == 1);
  CHECK(option_of(first->descriptor(), IPPROTO_TCP, TCP_NODELAY) == 1);
  CHECK(end.receive(into) == 0);  // it has sent nothing, and stays
  const auto second = open_stream(end.address());
  second->write(std::array<std::uint8_t, 2>{5, 6});
  first->write(std::array<std::uint8_t, 1>{4});
  next_event(end);
  CHECK(end.receive(into) == 1);
  CHECK(into[0] == 4);
  first.reset();
  next_event(end);
  CHECK(end.receive(into) == 0);
  next_event(end);
  CHECK(end.receive(into) == 0);
  next_event(end);
  CHECK(end.receive(into) == 2);
  end.send(std::array<std::uint8_t, 3>{7, 8, 9});
  CHECK(second->read(into, kPatient) == 3);
  const std::vector<std::uint8_t> many(1U << 23U);
  end.send(many);  // more than the socket takes: the rest is lost
}

// Waits on a wire: their time, what they report, and how an end that still owes an answer prolongs them.

namespace {

// On the stack its mutex may lie where another's lay before, which ThreadSanitizer then takes for one.
std::unique_ptr<EndActivity> on_the_heap() { return std::make_unique<EndActivity>(); }

using Real = std::chrono::steady_clock;

struct WaitedLine {
  WaitedLine() { REQUIRE(::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()) == 0); }
  ~WaitedLine() {
    for (const int end : ends) ::close(end);
  }
  WaitedLine(const WaitedLine&) = delete;
  WaitedLine& operator=(const WaitedLine&) = delete;
  void put() const { REQUIRE(::send(ends[1], "x", 1, 0) == 1); }
  std::array<int, 2> ends{-1, -1};
};

Nanoseconds spent(const std::function<void()>& act) {
  const auto begin = Real::now();
  act();
  return Real::now() - begin;
}

}  // namespace

TEST_CASE("wait: lasts at least as long as requested, and returns immediately for 0 or less") {
  const WaitedLine line;
  for (const Nanoseconds timeout : {Nanoseconds(3ms), Nanoseconds(1'050ms)}) {
    const Nanoseconds took = spent([&] { CHECK(wait_for(line.ends[0], POLLIN, timeout) == 0); });
    CHECK(took >= timeout);
    CHECK(took < timeout + 10s);
  }
  for (const Nanoseconds timeout : {Nanoseconds(0), Nanoseconds(-1h)}) {
    CHECK(spent([&] { CHECK(wait_for(line.ends[0], POLLIN, timeout) == 0); }) < 10s);
  }
}

TEST_CASE("wait: reports an event at once") {
  const WaitedLine line;
  CHECK(wait_for(line.ends[0], POLLOUT, 1h) == POLLOUT);
  line.put();
  for (const Nanoseconds timeout : {Nanoseconds(-1), Nanoseconds(0), Nanoseconds(1), Nanoseconds(1h)}) {
    CHECK(wait_for(line.ends[0], POLLIN, timeout) == POLLIN);
  }
  ::shutdown(line.ends[1], SHUT_RDWR);
  CHECK((wait_for(line.ends[0], POLLIN, 1h) & POLLHUP) != 0);
  const int closed = ::dup(line.ends[0]);
  ::close(closed);
  CHECK(wait_for(closed, POLLIN, 1h) == POLLNVAL);
}

TEST_CASE("wait: left_until is the time to a moment, and 1 ms after it while a simulated instrument is busy") {
  CHECK(left_until(Real::now() + 1h) > 59min);
  CHECK(left_until(Real::now() + 1h) <= 1h);
  CHECK(left_until(Real::now()) == 0ns);
  CHECK(left_until(Real::now() - 1h) == 0ns);
  const auto held_end = on_the_heap();  // at work until its first wait
  EndActivity& end = *held_end;
  CHECK(left_until(Real::now() + 1h) > 59min);
  CHECK(left_until(Real::now()) == 1ms);
  CHECK(left_until(Real::now() - 5s) == 1ms);
  CHECK(left_until(Real::now() - 20s) == 0ns);  // it will never finish
  const WaitedLine line;
  for (const Nanoseconds none : {Nanoseconds(0), Nanoseconds(-1)}) {  // who does not wait does not wait for an end
    CHECK(spent([&] { CHECK(wait_for(line.ends[0], POLLIN, none) == 0); }) < 10s);
  }
  end.leave();
  CHECK(left_until(Real::now()) == 0ns);
}

TEST_CASE("wait: continues while a simulated instrument is busy, and receives what it sends last") {
  const WaitedLine line;
  for (const Nanoseconds timeout : {Nanoseconds(1), Nanoseconds(1ms)}) {
    const auto held_end = on_the_heap();
    EndActivity& end = *held_end;
    std::thread worker = end.thread([&] {
      std::this_thread::sleep_for(60ms);
      [[maybe_unused]] const ssize_t sent = ::send(line.ends[1], "x", 1, 0);
    });
    CHECK(wait_for(line.ends[0], POLLIN, timeout) == POLLIN);
    worker.join();
    std::array<char, 4> into{};
    CHECK(::recv(line.ends[0], into.data(), into.size(), 0) == 1);
  }
  const auto held_idle = on_the_heap();
  EndActivity& idle = *held_idle;
  std::thread worker = idle.thread([] {});
  worker.join();
  CHECK(wait_for(line.ends[0], POLLIN, 1ms) == 0);
}

TEST_CASE("busy instrument: is busy until its first wait and while it has input, and never in a child process") {
  CHECK_FALSE(EndActivity::any());
  {
    const auto held_made = on_the_heap();
    CHECK(EndActivity::any());
    const pid_t child = ::fork();
    if (child == 0) ::_exit(EndActivity::any() ? 1 : 0);
    int status = -1;
    REQUIRE(::waitpid(child, &status, 0) == child);
    CHECK(status == 0);
  }
  CHECK_FALSE(EndActivity::any());
  const WaitedLine line;
  {
    const auto held_end = on_the_heap();
    EndActivity& end = *held_end;
    std::array<pollfd, 1> watched{pollfd{line.ends[0], POLLIN, 0}};
    CHECK(end.wait(watched, 5ms) == 0);
    CHECK(EndActivity::any());  // works again, on what its wait brought
    auto second = std::make_unique<EndActivity>();
    end.leave();
    CHECK(EndActivity::any());
    second.reset();
    CHECK_FALSE(EndActivity::any());
  }
  const auto held_end = on_the_heap();
  EndActivity& end = *held_end;
  std::array<pollfd, 1> seen{pollfd{line.ends[0], POLLIN, 0}};
  int ready = -1;
  std::thread waiter([&] {
    ready = end.wait(seen);
    end.leave();
  });
  for (int i = 0; i < 20'000 && EndActivity::any(); ++i) std::this_thread::sleep_for(1ms);
  CHECK_FALSE(EndActivity::any());  // it waits, and there is nothing to read
  line.put();
  waiter.join();
  CHECK(ready == 1);
  CHECK(seen[0].revents == POLLIN);
}

TEST_CASE("busy instrument: a wait lasts for its time, and a failed one keeps errno") {
  const WaitedLine line;
  const auto held_end = on_the_heap();
  EndActivity& end = *held_end;
  std::array<pollfd, 1> watched{pollfd{line.ends[0], POLLIN, 0}};
  for (const Nanoseconds longest : {Nanoseconds(0), Nanoseconds(7ms), Nanoseconds(1'020ms)}) {
    const Nanoseconds took = spent([&] { CHECK(end.wait(watched, longest) == 0); });
    CHECK(took >= longest);
    CHECK(took < longest + 10s);
  }
  CHECK(end.wait(watched, Nanoseconds(-1)) == -1);
  CHECK(errno == EINVAL);
  line.put();
  CHECK(end.wait(watched, 1h) == 1);
}
