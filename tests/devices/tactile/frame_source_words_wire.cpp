// The driver of a frame source: every word of its complaints, fields at their edges, and a source that takes no more
// bytes.
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <atomic>
#include <catch2/catch.hpp>
#include <thread>

#include "devices/tactile/frame_source.h"
#include "tests/devices/scripted_server.h"
#include "tests/devices/test_chamber.h"
#include "tests/devices/timeouts.h"

using namespace tactbench::devices;
using namespace std::chrono_literals;
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
  template <class Act>
  std::string words(Act&& act) const {
    const auto fault = fault_of(act);
    if (!fault) return "";
    std::string text = fault->id() + ": " + fault->what();
    const auto at = text.find(options.address);
    return at == std::string::npos ? text : text.replace(at, options.address.size(), "A");
  }
  // What opening says.
  std::string opened() {
    return words([&] { FrameSource(options, clock); });
  }
  // What the last of so many readings of one scan says.
  std::string read(int times = 1) {
    FrameSource source(options, clock);
    for (int i = 1; i < times; ++i) (void)source.read(1);
    return words([&] { (void)source.read(1); });
  }
  ScriptedServer server;
  FrameSourceOptions options;
  TurnedClock clock;
};

// The identity, then what `scan` says.
Answer after_identity(Answer scan) {
  return
      [scan = std::move(scan)](int number, Tag tag) { return number == 0 ? told(tag, kTwoByTwo) : scan(number, tag); };
}

}  // namespace

TEST_CASE("frame source told: what is wrong with its identity") {
  const auto said = [](const protocol::Body& body) {
    return ToldSource([&](int, Tag tag) { return told(tag, body); }).opened();
  };
  const std::string corrupt = "TB-SCANNER-CORRUPT: frame source A: ";
  CHECK(said(kTwoByTwo).empty());
  CHECK(said(two_by_two(1)) == corrupt + "its reply to the request for its identity is of another kind");
  CHECK(said(protocol::Description{2, 2, 2, 0.5, "M", "S1", "F1"}) ==
        corrupt + "it speaks version 2 of the protocol, not 1");
  CHECK(said(protocol::Description{0, 2, 2, 0.5, "M", "S1", "F1"}) ==
        corrupt + "it speaks version 0 of the protocol, not 1");
  CHECK(said(protocol::Description{1, 3, 2, 0.5, "M", "S1", "F1"}) ==
        "TB-SCANNER-GEOMETRY: a scanner of 2 x 2 taxels is configured, A reports 3 x 2");
  CHECK(said(protocol::Description{1, 2, 1, 0.5, "M", "S1", "F1"}) ==
        "TB-SCANNER-GEOMETRY: a scanner of 2 x 2 taxels is configured, A reports 2 x 1");
  CHECK(said(protocol::Description{1, 2, 2, 0.5, "M", "S2", "F1"}) ==
        "TB-SCANNER-SERIAL: scanner 'S1' is configured, 'S2' answers on A");
  CHECK(said(protocol::Error{protocol::ErrorCode::kOtherVersion, "old"}) ==
        "TB-SCANNER-REFUSED: asking A its identity: error 4 'old'");
  ToldSource any([](int, Tag tag) { return told(tag, kTwoByTwo); });
  any.options.expected_serial.clear();
  CHECK(any.opened().empty());
}

TEST_CASE("frame source told: what is wrong with a scan") {
  const auto said = [](const Answer& scan) { return ToldSource(after_identity(scan)).read(); };
  const auto said_to = [&](const protocol::Body& body) { return said([&](int, Tag tag) { return told(tag, body); }); };
  const std::string corrupt = "TB-SCANNER-CORRUPT: frame source A: ";
  CHECK(said_to(two_by_two(0)).empty());
  CHECK(said_to(kTwoByTwo) == corrupt + "its reply to the request for a scan is of another kind");
  CHECK(said_to(protocol::Frame{0, 0, 0, 1, 2, {1, 2}}) ==
        corrupt + "a frame of 1 x 2 taxels came, the array has 2 x 2");
  CHECK(said_to(protocol::Frame{0, 0, 0, 2, 1, {1, 2}}) ==
        corrupt + "a frame of 2 x 1 taxels came, the array has 2 x 2");
  CHECK(said_to(protocol::Error{protocol::ErrorCode::kDevice, "no power"}) ==
        "TB-SCANNER-REFUSED: asking A for scan 0: error 5 'no power'");
  const protocol::Error unread{protocol::ErrorCode::kDamaged, "damaged request: CRC"};
  CHECK(said([&](int, Tag) { return told(0, unread); }) ==
        "TB-SCANNER-REFUSED: asking A for scan 0: error 1 'damaged request: CRC'");
  CHECK(said([&](int, Tag tag) {
          return both(told(static_cast<Tag>(tag + 1), unread), told(tag, two_by_two(0)));  // of another request
        }).empty());
  CHECK(said([](int, Tag tag) {
          Bytes bytes = told(tag, two_by_two(0));
          bytes[20] ^= 1U;
          return bytes;
        }) == corrupt + "the stream of messages is damaged (CRC)");
  CHECK(said([](int, Tag tag) {
          Bytes bytes = told(tag, protocol::Scan{});
          bytes.resize(bytes.size() - protocol::kChecksumBytes);
          bytes[4] = 0x0C;
          bytes[8] = 2;
          bytes.insert(bytes.end(), {7, 7});
          const std::uint32_t crc = protocol::crc32(bytes);
          for (unsigned i = 0; i < 4; ++i) bytes.push_back(static_cast<std::uint8_t>(crc >> (8 * i) & 0xFFU));
          return bytes;
        }) == corrupt + "a message of type 0x0c with 2 bytes is not in the protocol");
  CHECK_THAT(said([](int, Tag) { return Bytes{0}; }), Catch::StartsWith("TB-SCANNER-LOST: the frame source is gone: "));
}

TEST_CASE("frame source told: the counter goes on, by no more than half its range") {
  const auto said = [](std::uint32_t first, std::uint32_t second) {
    return ToldSource(
               after_identity([=](int number, Tag tag) { return told(tag, two_by_two(number == 1 ? first : second)); }))
        .read(2);
  };
  const std::string corrupt = "TB-SCANNER-CORRUPT: frame source A: on a request for a fresh frame it sent frame ";
  for (const std::uint32_t first : {0U, 5U, 0xFFFFFFFFU, 0x80000000U}) {
    CHECK(said(first, first + 1).empty());
    CHECK(said(first, first + 0x7FFFFFFFU).empty());
    const std::string after = " after frame " + std::to_string(first) + ": it came twice, or is old";
    CHECK(said(first, first) == corrupt + std::to_string(first) + after);
    CHECK(said(first, first + 0x80000000U) == corrupt + std::to_string(first + 0x80000000U) + after);
    CHECK(said(first, first - 1) == corrupt + std::to_string(first - 1) + after);
  }
}

TEST_CASE("frame source told: counts, counters, status and times of several scans") {
  ToldSource rig(after_identity([](int number, Tag tag) {
    const auto scan = static_cast<std::uint32_t>(number);
    // What comes behind the answer, with it, is old when the next request is made.
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

TEST_CASE("frame source told: no answer, and which one it was") {
  ToldSource rig(after_identity([](int number, Tag tag) {
    return number < 3 ? told(tag, two_by_two(static_cast<std::uint32_t>(number))) : Bytes{};
  }));
  rig.options.frame_timeout = kShort;
  FrameSource source(rig.options, rig.clock);
  CHECK(rig.words([&] { (void)source.read(5); }) == "TB-SCANNER-TIMEOUT: asking A for scan 2: no answer within 400 ms");
  CHECK(rig.clock.now() == kShort);
  ToldSource mute([](int, Tag) { return Bytes{}; });
  mute.options.frame_timeout = kShort;
  CHECK(mute.opened() == "TB-SCANNER-TIMEOUT: asking A its identity: no answer within 400 ms");
}

TEST_CASE("frame source told: a source that takes no more bytes is slow, not gone") {
  const TemporaryFolder folder;
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  const std::string path = folder.path("source");
  std::copy(path.begin(), path.end(), address.sun_path);
  const int listener = ::socket(AF_UNIX, SOCK_STREAM, 0);
  REQUIRE(::bind(listener, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0);
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
  TurnedClock clock;
  FrameSourceOptions options;
  options.address = "unix:" + path;
  options.rows = options.columns = 2;
  options.frame_timeout = kPatient;
  options.connect_timeout = 100ms;  // of each write, too
  {
    FrameSource driver(options, clock);
    std::string said;
    // Small requests fill the socket's buffer, one after another.
    for (int i = 0; i < 20'000 && !said.starts_with("TB-SCANNER-TIMEOUT: the frame source takes no bytes: "); ++i) {
      const auto fault = fault_of([&] { (void)driver.read(1); });
      REQUIRE(fault);
      said = fault->id() + ": " + fault->what();
    }
    CHECK_THAT(said, Catch::StartsWith("TB-SCANNER-TIMEOUT: the frame source takes no bytes: "));
  }
  ended = true;
  source.join();
  ::close(client);
  ::close(listener);
}
