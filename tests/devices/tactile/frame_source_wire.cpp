#include <sys/socket.h>
#include <unistd.h>
#include <catch2/catch.hpp>

#include <atomic>
#include <list>
#include <thread>
#include <tuple>

#include "devices/tactile/frame_source.h"
#include "devices/tactile/simulated_frame_source.h"
#include "tests/devices/packet_listener.h"
#include "tests/devices/scripted_server.h"
#include "tests/devices/tactile/frame_client.h"
#include "tests/devices/test_chamber.h"
#include "tests/devices/timeouts.h"

using namespace std::chrono_literals;
using namespace tactbench::devices::frame_protocol;
using namespace tactbench::devices;
using Steady = std::chrono::steady_clock;

namespace protocol = tactbench::devices::frame_protocol;
using namespace tactbench::devices;
using namespace std::chrono_literals;

namespace {

const protocol::Description kDescription = {1, 16, 16, 1e-4, "Laboratory scanner", "SIM-42", "1.2"};

struct FrameSourceRig {
  explicit FrameSourceRig(SimulatedFrameSourceFaults faults = {}, Nanoseconds timeout = kPatient,
                          const protocol::Description& description = kDescription)
      : server(std::make_unique<SimulatedFrameSource>(
            SimulatedFrameSourceOptions{.description = description, .faults = faults}, array, clock)) {
    options.address = "tcp:127.0.0.1:" + std::to_string(server->port());
    options.frame_timeout = timeout;
    options.origin = Origin::kSimulated;
  }
  [[nodiscard]] FrameSource open() const { return FrameSource(options, clock); }

  mutable ManualClock clock;
  TestArray array;
  FrameSourceOptions options;
  std::unique_ptr<SimulatedFrameSource> server;
};

}  // namespace

TEST_CASE("frame source: supports arrays of any shape up to 256 x 256") {
  for (const auto& [rows, columns] : {std::pair{1, 1}, {3, 200}, {256, 256}}) {
    auto description = kDescription;
    description.rows = static_cast<std::uint16_t>(rows);
    description.columns = static_cast<std::uint16_t>(columns);
    FrameSourceRig rig({}, kPatient, description);
    rig.options.rows = rows;
    rig.options.columns = columns;
    auto source = rig.open();
    const auto set = source.read(2);
    check_scan(set, 0, 0);
    check_scan(set, 1, 1);
  }
}

TEST_CASE("frame source: frames read by another client appear as a jump of the counter") {
  const FrameSourceRig rig;
  auto source = rig.open();
  auto other = rig.open();
  (void)other.read(5);
  const ScanSet first = source.read(1);
  check_scan(first, 0, 5);
  (void)other.read(3);
  const ScanSet second = source.read(1);
  check_scan(second, 0, 9);
  CHECK(second.frame_counters.front() - first.frame_counters.front() == 4);
}

TEST_CASE("frame source: each scan fault has its id, and the next scan succeeds, on a new connection if need be") {
  const struct {
    SimulatedFrameSourceFaults faults;
    std::string id;
    bool lives;
    int next;
  } cases[] = {{{.double_scan = 0}, "none", true, 2},  // used once
               {{.drop_scan = 1}, "TB-SCANNER-TIMEOUT", true, 2},
               {{.repeat_scan = 1}, "TB-SCANNER-CORRUPT", true, 1},  // under a new tag
               {{.corrupt_scan = 1}, "TB-SCANNER-CORRUPT", false, 2},
               {{.cut_scan = 1}, "TB-SCANNER-LOST", false, 2}};
  for (const auto& [faults, id, lives, next] : cases) {
    const FrameSourceRig rig(faults, id == "TB-SCANNER-TIMEOUT" ? kShort : kPatient);
    auto source = rig.open();
    check_scan(source.read(1), 0, 0);
    for (int i = 0; i < (lives ? 1 : 2); ++i) CHECK(fault_id_of([&] { (void)source.read(1); }) == id);
    auto again = rig.open();
    const ScanSet after = (lives ? source : again).read(1);
    check_scan(after, 0, next);
    CHECK(after.frame_counters == std::vector<std::uint32_t>{static_cast<std::uint32_t>(next)});
  }
}

TEST_CASE("frame source: a port without a listener or an invalid address is a lost-scanner fault") {
  FrameSourceRig rig;
  rig.server.reset();
  CHECK(fault_id_of([&] { (void)rig.open(); }) == "TB-SCANNER-LOST");
  rig.options.address = "tcp:nowhere";
  CHECK(fault_id_of([&] { (void)rig.open(); }) == "TB-SCANNER-LOST");
  rig.options.address = "unix:no/such/socket";
  CHECK(fault_id_of([&] { (void)rig.open(); }) == "TB-SCANNER-LOST");
}

TEST_CASE("simulated frame source: a port in use is a fault") {
  const FrameSourceRig rig;
  TestArray array;
  CHECK(fault_id_of([&] {
          SimulatedFrameSource({.description = kDescription, .port = rig.server->port()}, array, rig.clock);
        }) == "TB-SIM-LISTEN");
}

// The driver of a frame source: its faults, fields at their edges, and a source that takes no more bytes.

namespace protocol = tactbench::devices::frame_protocol;

namespace {

using Tag = std::uint16_t;
using Answer = std::function<Bytes(int number, Tag tag)>;

Bytes told(Tag tag, const protocol::Body& body) { return protocol::encode({tag, body}); }
Bytes both(Bytes first, const Bytes& second) {
  first.insert(first.end(), second.begin(), second.end());
  return first;
}
const protocol::Description kTwoByTwo{1, 2, 2, 0.5, "M", "S1", "F1"};
protocol::Frame two_by_two(std::uint32_t counter, std::uint8_t status = 0, std::uint64_t time = 0) {
  const auto base = static_cast<std::uint16_t>(10 * counter);
  return {time, counter, status, 2, 2, {base, static_cast<std::uint16_t>(base + 1), 7, 8}};
}

// A source that gives these answers (number 0: to the request for its identity), and a driver for 2 x 2 taxels.
struct ToldSource {
  explicit ToldSource(Answer answer)
      : server([answer = std::move(answer)](int number, int socket, const Bytes& request) {
          const Bytes bytes = answer(number, static_cast<Tag>(request[6] | request[7] << 8));
          if (bytes.empty()) return;
          if (bytes == Bytes{0}) ::shutdown(socket, SHUT_RDWR);
          ScriptedServer::send(socket, bytes);
        }) {
    options.address = "tcp:127.0.0.1:" + std::to_string(server.port());
    options.rows = options.columns = 2;
    options.frame_timeout = kPatient;
    options.expected_serial = "S1";
  }
  // The faults of opening, and of the last of so many readings of one scan.
  std::string opened() {
    return fault_id_of([&] { FrameSource(options, clock); });
  }
  std::string read(int times = 1) {
    FrameSource source(options, clock);
    for (int i = 1; i < times; ++i) (void)source.read(1);
    return fault_id_of([&] { (void)source.read(1); });
  }
  ScriptedServer server;
  FrameSourceOptions options;
  ManualClock clock;
};

// The identity, then what `scan` says.
Answer after_identity(Answer scan) {
  return
      [scan = std::move(scan)](int number, Tag tag) { return number == 0 ? told(tag, kTwoByTwo) : scan(number, tag); };
}

}  // namespace

TEST_CASE("frame source: an identity with a wrong type, version, shape or serial number is a fault") {
  const auto opened = [](const protocol::Body& body) {
    return ToldSource([&](int, Tag tag) { return told(tag, body); }).opened();
  };
  CHECK(opened(kTwoByTwo) == "none");
  CHECK(opened(two_by_two(1)) == "TB-SCANNER-CORRUPT");
  for (const std::uint16_t version : std::vector<std::uint16_t>{0, 2})
    CHECK(opened(protocol::Description{version, 2, 2, 0.5, "M", "S1", "F1"}) == "TB-SCANNER-CORRUPT");
  CHECK(opened(protocol::Description{1, 3, 2, 0.5, "M", "S1", "F1"}) == "TB-SCANNER-GEOMETRY");
  CHECK(opened(protocol::Description{1, 2, 1, 0.5, "M", "S1", "F1"}) == "TB-SCANNER-GEOMETRY");
  CHECK(opened(protocol::Description{1, 2, 2, 0.5, "M", "S2", "F1"}) == "TB-SCANNER-SERIAL");
  CHECK(opened(protocol::Error{protocol::ErrorCode::kOtherVersion, "old"}) == "TB-SCANNER-REFUSED");
  const protocol::Description eight_by_twelve{1, 8, 12, 0.5, "M", "S1", "F1"};
  for (const auto& [rows, columns, id] : {std::tuple(0, 0, "none"), std::tuple(8, 0, "none"), std::tuple(0, 12, "none"),
                                          std::tuple(0, 8, "TB-SCANNER-GEOMETRY")}) {
    ToldSource sized([&](int, Tag tag) { return told(tag, eight_by_twelve); });
    sized.options.rows = rows;  // 0: what the source states
    sized.options.columns = columns;
    CHECK(sized.opened() == id);
  }
  ToldSource any([](int, Tag tag) { return told(tag, kTwoByTwo); });
  any.options.expected_serial.clear();
  CHECK(any.opened() == "none");
}

TEST_CASE("frame source: invalid, refused and damaged scans are faults, and answers to other tags are ignored") {
  const auto read = [](const Answer& scan) { return ToldSource(after_identity(scan)).read(); };
  const auto read_of = [&](const protocol::Body& body) { return read([&](int, Tag tag) { return told(tag, body); }); };
  const std::string corrupt = "TB-SCANNER-CORRUPT", refused = "TB-SCANNER-REFUSED";
  CHECK(read_of(two_by_two(0)) == "none");
  CHECK(read_of(kTwoByTwo) == corrupt);
  CHECK(read_of(protocol::Frame{0, 0, 0, 1, 2, {1, 2}}) == corrupt);
  CHECK(read_of(protocol::Frame{0, 0, 0, 2, 1, {1, 2}}) == corrupt);
  CHECK(read_of(protocol::Error{protocol::ErrorCode::kDevice, "no power"}) == refused);
  const protocol::Error unread{protocol::ErrorCode::kDamaged, "damaged request: CRC"};
  CHECK(read([&](int, Tag) { return told(0, unread); }) == refused);
  for (const protocol::Body& of_another : {protocol::Body{unread}, protocol::Body{two_by_two(100)}})
    CHECK(read([&](int, Tag tag) {
            return both(told(static_cast<Tag>(tag + 1), of_another), told(tag, two_by_two(0)));
          }) == "none");
  CHECK(read([](int, Tag tag) {
          Bytes bytes = told(tag, two_by_two(0));
          bytes[20] ^= 1U;
          return bytes;
        }) == corrupt);
  CHECK(read([](int, Tag tag) {  // whole, and of no type of the protocol
          Bytes bytes = told(tag, protocol::Scan{});
          bytes.resize(bytes.size() - protocol::kChecksumBytes);
          bytes[4] = 0x0C;
          bytes[8] = 2;
          bytes.insert(bytes.end(), {7, 7});
          const std::uint32_t crc = protocol::crc32(bytes);
          for (unsigned i = 0; i < 4; ++i) bytes.push_back(static_cast<std::uint8_t>(crc >> (8 * i) & 0xFFU));
          return bytes;
        }) == corrupt);
  CHECK(read([](int, Tag) { return Bytes{0}; }) == "TB-SCANNER-LOST");
}

TEST_CASE("frame source: the frame counter must advance, by less than half its range") {
  const auto read = [](std::uint32_t first, std::uint32_t second) {
    return ToldSource(
               after_identity([=](int number, Tag tag) { return told(tag, two_by_two(number == 1 ? first : second)); }))
        .read(2);
  };
  for (const std::uint32_t first : {0U, 5U, 0xFFFFFFFFU, 0x80000000U}) {
    CHECK(read(first, first + 1) == "none");
    CHECK(read(first, first + 0x7FFFFFFFU) == "none");
    for (const std::uint32_t second : {first, first + 0x80000000U, first - 1})
      CHECK(read(first, second) == "TB-SCANNER-CORRUPT");
  }
}

TEST_CASE("frame source: several scans keep their counts, counters, status and times") {
  ToldSource rig(after_identity([](int number, Tag tag) {
    const auto scan = static_cast<std::uint32_t>(number);
    // Data received after the answer, together with it, are old at the next request.
    return both(told(tag, two_by_two(scan, static_cast<std::uint8_t>(1U << scan), 0x1'0000'0000U + 40 + scan)),
                told(0, protocol::Error{protocol::ErrorCode::kDamaged, "of nothing"}));
  }));
  FrameSource source(rig.options, rig.clock);
  const Identity identity = source.identity();
  CHECK((identity.role == "tactile scanner" && identity.model == "M" && identity.serial == "S1"));
  CHECK((identity.firmware == "F1" && identity.origin == Origin::kHardware));
  CHECK((source.volts_per_count().value() == 0.5 && source.rows() == 2 && source.columns() == 2));
  rig.clock.wait_until(3s);
  for (const int none : {0, -1}) {
    const ScanSet empty = source.read(none);
    CHECK((empty.counts.empty() && empty.frame_counters.empty() && empty.scans == none && empty.time == 3s));
  }
  CHECK(source.exchanges() == 1);
  for (std::uint16_t scan = 1; scan <= 3; ++scan) {
    const ScanSet set = source.read(1);
    CHECK(set.counts[0] == 10 * scan);
    CHECK(set.device_time_us == 40U + scan);
  }
  ToldSource clean(after_identity([](int number, Tag tag) {
    const auto scan = static_cast<std::uint32_t>(number);
    return told(tag, two_by_two(scan, static_cast<std::uint8_t>(1U << scan), 0x1'0000'0000U + 40 + scan));
  }));
  FrameSource other(clean.options, clean.clock);
  const ScanSet three = other.read(3);
  CHECK(three.counts == std::vector<std::uint16_t>{10, 11, 7, 8, 20, 21, 7, 8, 30, 31, 7, 8});
  CHECK(three.frame_counters == std::vector<std::uint32_t>{1, 2, 3});
  CHECK((three.status == 14 && three.device_time_us == 41 && three.scans == 3));
  CHECK((three.rows == 2 && three.columns == 2 && other.exchanges() == 4));
}

TEST_CASE("frame source: a missing answer is a timeout that states the scan number") {
  ToldSource rig(after_identity([](int number, Tag tag) {
    return number < 3 ? told(tag, two_by_two(static_cast<std::uint32_t>(number))) : Bytes{};
  }));
  rig.options.frame_timeout = kShort;
  FrameSource source(rig.options, rig.clock);
  check_fault([&] { (void)source.read(5); }, "TB-SCANNER-TIMEOUT", {}, "scan 2");
  CHECK(rig.clock.now() == kShort);
  ToldSource mute([](int, Tag) { return Bytes{}; });
  mute.options.frame_timeout = kShort;
  CHECK(mute.opened() == "TB-SCANNER-TIMEOUT");
  ToldSource late(after_identity([](int, Tag tag) { return told(static_cast<Tag>(tag - 1), two_by_two(1)); }));
  late.options.frame_timeout = kShort;
  CHECK(late.read() == "TB-SCANNER-TIMEOUT");
}

TEST_CASE("frame source: a flood of old answers does not extend the timeout") {
  static constexpr auto kFlood = 20 * kShort;  // ends with the right answer, too late
  const ScriptedServer server(
      [](int number, int socket, const Bytes& request) {
        const auto tag = static_cast<Tag>(request[6] | request[7] << 8);
        const Bytes old = told(static_cast<Tag>(tag - 1), two_by_two(1));
        const auto end = std::chrono::steady_clock::now() + kFlood;
        while (number > 0 && std::chrono::steady_clock::now() < end) {
          if (::send(socket, old.data(), old.size(), MSG_NOSIGNAL) < 0) return;  // the driver has hung up
        }
        ScriptedServer::send(socket, number == 0 ? told(tag, kTwoByTwo) : told(tag, two_by_two(2)));
      },
      false);
  ManualClock clock;
  FrameSourceOptions options;
  options.address = "tcp:127.0.0.1:" + std::to_string(server.port());
  options.rows = options.columns = 2;
  options.frame_timeout = kShort;
  FrameSource source(options, clock);
  CHECK(fault_id_of([&] { (void)source.read(1); }) == "TB-SCANNER-TIMEOUT");
}

TEST_CASE("frame source: a source that accepts no more bytes is a timeout, not a lost scanner") {
  const TemporaryFolder folder;
  const std::string path = folder.path("source");
  const int listener = bound_at(path, SOCK_STREAM);
  REQUIRE(::listen(listener, 1) == 0);
  int client = -1;
  std::atomic<bool> ended{false};
  // Answers the identity, reads nothing more, and refuses whatever may have been asked.
  std::thread source([&] {
    client = ::accept(listener, nullptr, nullptr);
    Bytes request(64);
    (void)!::recv(client, request.data(), request.size(), 0);
    ScriptedServer::send(client, told(static_cast<Tag>(request[6] | request[7] << 8), kTwoByTwo));
    const Bytes refusal = told(0, protocol::Error{protocol::ErrorCode::kDevice, "no"});
    while (!ended) {
      ::send(client, refusal.data(), refusal.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
      std::this_thread::sleep_for(100us);
    }
  });
  ManualClock clock;
  FrameSourceOptions options;
  options.address = "unix:" + path;
  options.rows = options.columns = 2;
  options.frame_timeout = kPatient;
  options.connect_timeout = 100ms;  // of each write, too
  {
    FrameSource driver(options, clock);
    std::string id;
    // Small requests fill the socket's buffer, one after another.
    for (int i = 0; i < 20'000 && id != "TB-SCANNER-TIMEOUT"; ++i) id = fault_id_of([&] { (void)driver.read(1); });
    CHECK(id == "TB-SCANNER-TIMEOUT");
  }
  ended = true;
  source.join();
  ::close(client);
  ::close(listener);
}

// Clients of the simulated frame source that subscribe, that are many, and that read late.

namespace {

struct Running {
  explicit Running(double rate, std::uint16_t side = 2)
      : server({.description = {1, side, side, 0.25, "", "", ""}, .free_running_hz = rate}, array, clock),
        address("tcp:127.0.0.1:" + std::to_string(server.port())) {}
  ManualClock clock;
  CountedArray array;
  SimulatedFrameSource server;
  std::string address;
};

void check_whole(const Frame& frame, int scan) {
  for (std::size_t i = 0; i < frame.counts.size(); ++i) {
    if (frame.counts[i] != static_cast<std::uint16_t>(100 * scan + static_cast<int>(i))) FAIL("taxel " << i);
  }
}

}  // namespace

TEST_CASE("frame subscribers: each receives every frame under its own tag, until it unsubscribes") {
  const Running source(500.0);
  FrameClient first(source.address), second(source.address);
  first.send(11, Subscribe{});
  CHECK(first.expect<Frame>(11).counter == 0);
  second.send(22, Subscribe{});
  const auto begin = second.expect<Frame>(22).counter;
  for (std::uint32_t i = 1; i <= begin + 5; ++i) CHECK(first.expect<Frame>(11).counter == i);
  for (std::uint32_t i = 1; i <= 5; ++i) {
    const Frame frame = second.expect<Frame>(22);
    CHECK(frame.counter == begin + i);
    check_whole(frame, static_cast<int>(begin + i));
  }
  first.send(12, Unsubscribe{});
  for (auto message = first.next(); message->tag != 12; message = first.next()) REQUIRE(message->tag == 11);
  auto last = second.expect<Frame>(22).counter;
  for (int i = 0; i < 20; ++i) {
    const auto counter = second.expect<Frame>(22).counter;
    CHECK(counter == last + 1);
    last = counter;
  }
  first.send(13, Identify{});
  (void)first.expect<Description>(13);  // nothing of the subscription in between
  first.send(14, Subscribe{});
  first.send(15, Subscribe{});  // the newer tag counts
  bool newer = false;
  while (!newer) newer = first.next().value().tag == 15;
  (void)first.expect<Frame>(15);
}

TEST_CASE("frame subscribers: the first frame is sent at once, the others a period apart, for any number of clients") {
  const Running source(40.0);
  FrameClient first(source.address), second(source.address);
  const auto begin = Steady::now();
  first.send(1, Subscribe{});
  CHECK(first.expect<Frame>(1).counter == 0);
  second.send(2, Subscribe{});
  CHECK(second.expect<Frame>(2).counter >= 1);
  CHECK(Steady::now() - begin >= 25ms);
  while (first.expect<Frame>(1).counter < 4) {
  }
  CHECK(Steady::now() - begin >= 100ms);
  // On a busy machine one of many times three frames come within little more than three periods.
  const auto end = Steady::now() + kPatient;
  bool in_time = false;
  while (!in_time && Steady::now() < end) {
    FrameClient client(source.address);
    const auto asked = Steady::now();
    client.send(3, Subscribe{});
    for (int frame = 0; frame < 3; ++frame) (void)client.expect<Frame>(3);
    in_time = Steady::now() - asked < 85ms;
  }
  CHECK(in_time);
}

TEST_CASE("frame subscribers: the first subscriber gets a frame without a long wait") {
  const Running source(2.0);
  const auto end = Steady::now() + kPatient;
  bool at_once = false;
  while (!at_once && Steady::now() < end) {
    FrameClient client(source.address);
    const auto asked = Steady::now();
    client.send(3, Subscribe{});
    (void)client.expect<Frame>(3);
    at_once = Steady::now() - asked < 400ms;
    client.send(4, Unsubscribe{});
    (void)client.expect<Done>(4);
  }
  CHECK(at_once);
}

TEST_CASE("frame subscribers: a frame that the array fails to measure is skipped") {
  Running source(500.0);
  source.array.broken_scan = 1;
  FrameClient client(source.address);
  client.send(1, Subscribe{});
  for (const int scan : {0, 2, 3}) {
    const Frame frame = client.expect<Frame>(1);
    CHECK(frame.counter == static_cast<std::uint32_t>(scan == 0 ? 0 : scan - 1));
    check_whole(frame, scan);
  }
}

TEST_CASE("frame subscribers: sixteen clients are served, and the next one after one disconnects") {
  const Running source(100.0);
  std::list<FrameClient> clients;
  for (std::uint16_t i = 0; i < 16; ++i) {
    clients.emplace_back(source.address).send(i, Identify{});
    (void)clients.back().expect<Description>(i);
  }
  FrameClient waiting(source.address);
  waiting.send(99, Identify{});
  for (std::uint16_t i = 0; i < 3; ++i) {
    clients.front().send(i, Identify{});
    (void)clients.front().expect<Description>(i);
  }
  CHECK_FALSE(waiting.waits());
  clients.pop_back();
  (void)waiting.expect<Description>(99);
}

TEST_CASE("frame subscribers: a client that reads late receives all answers, whole and in order") {
  const Running source(100.0, 256);
  FrameClient client(source.address);
  for (std::uint16_t tag = 0; tag < 80; ++tag) client.send(tag, Scan{});  // 10 megabytes
  FrameClient other(source.address);
  other.send(5, Identify{});
  (void)other.expect<Description>(5);
  for (std::uint16_t tag = 0; tag < 80; ++tag) {
    const Frame frame = client.expect<Frame>(tag);
    CHECK(frame.counter == tag);
    check_whole(frame, tag);
  }
  client.send(200, Identify{});
  (void)client.expect<Description>(200);
}

TEST_CASE(
    "frame subscribers: a client that reads late misses frames, gets the others whole, and delays no other client") {
  const Running source(20'000.0, 256);
  FrameClient late(source.address), other(source.address);
  late.send(1, Subscribe{});
  const auto end = Steady::now() + kPatient;
  while (source.array.scans < 200 && Steady::now() < end) std::this_thread::yield();
  REQUIRE(source.array.scans >= 200);
  other.send(5, Identify{});
  (void)other.expect<Description>(5);
  bool missed = false;
  std::uint32_t expected = 0;
  for (int i = 0; i < 400 && !missed; ++i) {
    const Frame frame = late.expect<Frame>(1);
    check_whole(frame, static_cast<int>(frame.counter));
    missed = frame.counter != expected;
    expected = frame.counter + 1;
  }
  CHECK(missed);
}

TEST_CASE("frame subscribers: a client that disconnects during its stream frees its place") {
  const Running source(5000.0);
  FrameClient staying(source.address);
  staying.send(1, Subscribe{});
  for (int i = 0; i < 40; ++i) {
    FrameClient leaving(source.address);
    leaving.send(2, Subscribe{});
    (void)leaving.expect<Frame>(2);
  }
  auto last = staying.expect<Frame>(1).counter;
  for (int i = 0; i < 20; ++i) {
    const auto counter = staying.expect<Frame>(1).counter;
    CHECK(counter > last);
    last = counter;
  }
}
