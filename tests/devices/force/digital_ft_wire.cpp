#include "devices/force/digital_ft.h"

#include <catch2/catch.hpp>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <functional>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <thread>

#include "devices/force/simulated_digital_ft.h"
#include "devices/wire/byte_stream.h"
#include "tests/devices/force/scripted_digital.h"
#include "tests/devices/test_chamber.h"
#include "tests/devices/timeouts.h"

using namespace std::chrono_literals;
using namespace tactbench::devices;

using RawBytes = std::vector<std::uint8_t>;

namespace {

class Load final : public ForcePort {
 public:
  Wrench wrench() override {
    const std::lock_guard lock(mutex_);
    ++asked_;
    return wrench_;
  }
  int asked() {
    const std::lock_guard lock(mutex_);
    return asked_;
  }
  void set(const Wrench& wrench) {
    const std::lock_guard lock(mutex_);
    wrench_ = wrench;
  }

 private:
  std::mutex mutex_;
  int asked_ = 0;
  Wrench wrench_{{1.0, -2.0, 4.0}, {80.0, -40.0, 8.0}};
};

struct DigitalFtRig {
  explicit DigitalFtRig(SimulatedDigitalFtFaults faults = {}, Nanoseconds reply_timeout = 20s)
      : server(invented_digital(), load, false, faults) {
    options.quiet = 50ms;
    options.reply_timeout = reply_timeout;
    options.origin = Origin::kSimulated;
  }
  [[nodiscard]] DigitalFt open() { return {open_stream(server.path()), options, clock}; }
  ManualClock clock;
  Load load;
  SimulatedDigitalFt server;
  DigitalFtOptions options;
};

void check_near(const Wrench& wrench, const Wrench& expected) {
  for (std::size_t i = 0; i < 3; ++i) {
    CHECK(wrench.force_n[i] == Approx(expected.force_n[i]).margin(1e-9));
    CHECK(wrench.torque_nmm[i] == Approx(expected.torque_nmm[i]).margin(1e-9));
  }
}

}  // namespace

TEST_CASE("Digital F/T: calibration, readings and bias are correct over a serial line") {
  DigitalFtRig rig;
  auto sensor = rig.open();
  CHECK(sensor.calibration_serial() == "FT99902");
  CHECK(sensor.range()[0] == Approx(25.0));
  CHECK(sensor.range()[5] == Approx(250.0));
  rig.clock.wait_until(3s);
  auto reading = sensor.read(20);
  CHECK(reading.records == 20);
  CHECK(reading.lost == 0);
  CHECK(reading.time == 3s);
  CHECK(rig.clock.now() == 3s);
  check_near(reading.wrench, {{1.0, -2.0, 4.0}, {80.0, -40.0, 8.0}});
  CHECK(reading.raw == SixAxes{-1000, 250, -500, 1000, -10000, 5000});
  check_near(sensor.bias(5).wrench, {{1.0, -2.0, 4.0}, {80.0, -40.0, 8.0}});
  rig.load.set({{2.0, -2.0, 4.0}, {80.0, -40.0, 0.0}});
  reading = sensor.read(5);
  check_near(reading.wrench, {{1.0, 0.0, 0.0}, {0.0, 0.0, -8.0}});
  CHECK(reading.raw[1] == 500);
  // Three register reads and three starts.
  CHECK(sensor.exchanges() == 6);
}

TEST_CASE("Digital F/T: an echoing adapter is recognised, and with local_echo set the readings are the same") {
  for (const bool echoes : {true, false}) {
    for (const bool expected : {true, false}) {
      INFO("echoes " << echoes << ", expected " << expected);
      DigitalFtRig rig({.echoes = echoes});
      rig.options.local_echo = expected;
      if (echoes != expected) {
        check_fault([&] { (void)rig.open(); }, "TB-FORCE-PROTOCOL", {}, echoes ? "echo" : "local_echo");
        continue;
      }
      auto sensor = rig.open();
      for (int i = 0; i < 2; ++i) {
        const ForceReading reading = sensor.read(20);
        check_near(reading.wrench, {{1.0, -2.0, 4.0}, {80.0, -40.0, 8.0}});
        CHECK(reading.lost == 0);
        CHECK(reading.spread_n == 0.0);
      }
    }
  }
}

TEST_CASE("Digital F/T: with the simulated clock each reading samples the load once, however many samples it has") {
  DigitalFtRig rig;
  auto sensor = rig.open();
  for (int reading = 1; reading <= 3; ++reading) {
    CHECK(sensor.read(250).records == 250);
    CHECK(rig.load.asked() == reading);
  }
}

TEST_CASE("Digital F/T: opening stops a stream that another program left running") {
  DigitalFtRig rig;
  {
    const auto left_behind = open_stream(rig.server.path());
    left_behind->write(digital_start_stream(10));
    std::array<std::uint8_t, 64> bytes{};
    std::size_t seen = 0;
    while (seen < 200) {
      const std::size_t got = left_behind->read(bytes, 20s);
      REQUIRE(got > 0);
      seen += got;
    }
  }
  auto sensor = rig.open();
  CHECK(sensor.read(3).records == 3);
}

TEST_CASE("Digital F/T: silence is a timeout, and after an error bit and an overload the next reading succeeds") {
  {
    DigitalFtRig rig({.silent_after_samples = 10}, 300ms);
    auto sensor = rig.open();
    check_fault([&] { (void)sensor.read(20); }, "TB-FORCE-TIMEOUT", {}, "10 came");
  }
  DigitalFtRig rig({.error_sample = 2});
  auto sensor = rig.open();
  CHECK(fault_id_of([&] { (void)sensor.read(20); }) == "TB-FORCE-STATUS");
  rig.load.set({{26.0, 0.0, 0.0}, {}});
  CHECK(fault_id_of([&] { (void)sensor.read(20); }) == "TB-FORCE-OVERLOAD");
  rig.load.set({});
  CHECK(sensor.read(20).records == 20);
}

TEST_CASE("Digital F/T: another unit number times out, another serial number is refused") {
  DigitalFtRig rig({}, 300ms);
  rig.options.unit = 11;
  CHECK(fault_id_of([&] { (void)rig.open(); }) == "TB-FORCE-TIMEOUT");
  CHECK(rig.clock.now() == 300ms);
  rig.options.unit = 10;
  rig.options.reply_timeout = 20s;
  rig.options.expected_serial = "FT00000";
  CHECK(fault_id_of([&] { (void)rig.open(); }) == "TB-FORCE-SERIAL");
}

// The simulated Digital F/T by its bytes: which requests it answers, what ends its stream, and what its samples carry.

namespace {

constexpr std::uint8_t kUnit = 10;
constexpr std::size_t kSample = 13;

Wrench pull(double newtons) { return {{newtons, 0.0, 0.0}, {}}; }  // 250 counts of G1 a newton

// A raw client of a sensor with that load.
struct DigitalClient {
  explicit DigitalClient(std::function<Wrench(int)> told, SimulatedDigitalFtFaults faults = {})
      : load(std::move(told)),
        server(invented_digital(), load, true, std::move(faults)),
        stream(open_stream(server.path())) {}

  void send(const RawBytes& bytes) const { stream->write(bytes); }
  // Exactly the next `size` bytes; fewer when they do not come.
  [[nodiscard]] RawBytes next(std::size_t size) const {
    RawBytes bytes(size);
    std::size_t came = 0;
    while (came < size) {
      const std::size_t got = stream->read(std::span(bytes).subspan(came), kPatient);
      if (got == 0) break;
      came += got;
    }
    bytes.resize(came);
    return bytes;
  }
  [[nodiscard]] DigitalSample sample() const { return decode_digital_sample(next(kSample)).value(); }
  void start() const {
    send(digital_start_stream(kUnit));
    REQUIRE(next(5) == rtu_frame(RawBytes{kUnit, 0x46, 1}));
  }
  // The bytes received until a pause; empty if they never pause.
  [[nodiscard]] std::optional<RawBytes> until_calm() const {
    const auto end = std::chrono::steady_clock::now() + kPatient;
    RawBytes came;
    std::array<std::uint8_t, 256> bytes{};
    while (std::chrono::steady_clock::now() < end) {
      const std::size_t got = stream->read(bytes, 50ms);
      if (got == 0) return came;
      came.insert(came.end(), bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(got));
    }
    return std::nullopt;
  }
  // Asks for a register until it is answered: a request that comes together with a jam is a part of the jam. Returns
  // what came before the answer.
  [[nodiscard]] RawBytes settle() const {
    RawBytes came;
    const RawBytes reply = one_register(1004);
    const auto end = std::chrono::steady_clock::now() + kPatient;
    while (std::chrono::steady_clock::now() < end) {
      send(rtu_read_holding(kUnit, 4, 1));
      std::array<std::uint8_t, 256> bytes{};
      while (const std::size_t got = stream->read(bytes, 100ms)) {
        came.insert(came.end(), bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(got));
      }
      const auto found = std::search(came.begin(), came.end(), reply.begin(), reply.end());
      if (found != came.end()) return {came.begin(), found};
    }
    FAIL("no answer");
    return {};
  }
  // The next bytes answer this request: nothing else was on its way.
  void expect_calm() const {
    send(rtu_read_holding(kUnit, 3, 1));
    CHECK(next(7) == one_register(1003));
  }
  static RawBytes one_register(int value) {
    return rtu_frame(
        RawBytes{kUnit, 3, 2, static_cast<std::uint8_t>(value >> 8), static_cast<std::uint8_t>(value & 0xFF)});
  }

  NumberedLoad load;
  SimulatedDigitalFt server;
  std::unique_ptr<ByteStream> stream;
};

}  // namespace

TEST_CASE("simulated Digital F/T: answers for each existing register, and refuses any other") {
  const DigitalClient client([](int) { return Wrench{}; });
  const auto answer = [&](int address, int count, std::size_t size) {
    client.send(rtu_read_holding(kUnit, address, count));
    return client.next(size);
  };
  const RawBytes no_such = rtu_frame(RawBytes{kUnit, 0x83, 2}), bad_count = rtu_frame(RawBytes{kUnit, 0x83, 3});
  for (int i = 0; i < 12; ++i) REQUIRE(answer(i, 1, 7) == DigitalClient::one_register(1000 + i));
  REQUIRE(answer(0x001D, 1, 7) == DigitalClient::one_register(0));
  const auto bytes = encode(invented_digital());
  for (int i = 0; i < 169; ++i) {
    const auto at = static_cast<std::size_t>(2 * i);
    REQUIRE(answer(0x00E3 + i, 1, 7) == DigitalClient::one_register(bytes[at] << 8 | bytes[at + 1]));
  }
  for (const int absent : {12, 0x001C, 0x001E, 0x00E2, 0x00E3 + 169, 0x1000, 0xFFFF})
    REQUIRE(answer(absent, 1, 5) == no_such);
  REQUIRE(answer(11, 2, 5) == no_such);
  REQUIRE(answer(10, 2, 9) == rtu_frame(RawBytes{kUnit, 3, 4, 0x03, 0xF2, 0x03, 0xF3}));
  for (const int count : {0, 126, 0x0101, 0x8000}) REQUIRE(answer(0x00E3, count, 5) == bad_count);
  const RawBytes most = answer(0x00E3, 125, 255);
  CHECK((most.size() == 255 && rtu_frame_is_whole(most) && most[2] == 250));
  CHECK(std::equal(bytes.begin(), bytes.begin() + 250, most.begin() + 3));
}

TEST_CASE("simulated Digital F/T: accepts requests byte by byte, several at once and after noise") {
  const DigitalClient client([](int) { return Wrench{}; });
  const auto joined = [](RawBytes first, const RawBytes& second) {
    first.insert(first.end(), second.begin(), second.end());
    return first;
  };
  const RawBytes request = rtu_read_holding(kUnit, 5, 1), reply = DigitalClient::one_register(1005);
  for (const std::uint8_t byte : request) {
    client.send({byte});
    std::this_thread::sleep_for(2ms);
  }
  REQUIRE(client.next(7) == reply);
  client.send(joined(request, rtu_read_holding(kUnit, 6, 1)));
  REQUIRE(client.next(14) == joined(reply, DigitalClient::one_register(1006)));
  // Noise, another unit's request, the unit's number alone, and a function that it does not have.
  for (const RawBytes& noise : {RawBytes{0xFF}, RawBytes{1, 2, 3}, rtu_read_holding(kUnit + 1, 5, 1), RawBytes{kUnit},
                                RawBytes{kUnit, 4}, RawBytes{kUnit, 0x43, kUnit}, RawBytes(14, 0xFF)}) {
    client.send(joined(noise, request));
    REQUIRE(client.next(7) == reply);
  }
  client.send({0xFF});
  std::this_thread::sleep_for(2ms);  // a single byte that begins nothing
  client.send(request);
  REQUIRE(client.next(7) == reply);
}

TEST_CASE("simulated Digital F/T: does not answer damaged requests or unknown start requests") {
  const DigitalClient client([](int) { return Wrench{}; });
  for (std::size_t at = 2; at < 8; ++at) {
    RawBytes damaged = rtu_read_holding(kUnit, 5, 1);
    damaged[at] ^= 0x10U;
    client.send(damaged);
    client.expect_calm();
  }
  for (const RawBytes& other :
       {RawBytes{kUnit, 0x46, 0x54}, RawBytes{kUnit, 0x46, 0x56}, RawBytes{kUnit, 0x46, 0x00}}) {
    client.send(rtu_frame(other));
    client.expect_calm();
  }
  CHECK(client.load.asked == 0);
}

TEST_CASE(
    "simulated Digital F/T: fourteen bytes stop the stream, thirteen do not, and neither is answered as a request") {
  DigitalClient client([](int) { return pull(1.0); });
  client.start();
  CHECK(client.sample().gauges == std::array<std::int16_t, 6>{0, 250, 0, 0, 0, 0});
  // A whole request and five bytes: thirteen. Whoever has read them goes on sending.
  client.send(rtu_read_holding(kUnit, 0, 1));
  client.send(RawBytes(5, 0xFF));
  const int before = client.load.asked;
  const auto end = std::chrono::steady_clock::now() + kPatient;
  std::array<std::uint8_t, 256> sink{};
  while (client.load.asked < before + 3 && std::chrono::steady_clock::now() < end) {
    (void)client.stream->read(sink, 20ms);
  }
  CHECK(client.load.asked >= before + 3);
  client.send({0xFF});
  const auto rest = client.until_calm();
  REQUIRE(rest);
  const RawBytes answer = DigitalClient::one_register(1000);
  CHECK(std::search(rest->begin(), rest->end(), answer.begin(), answer.end()) == rest->end());
  CHECK(client.settle().empty());
  // Bytes received before the next start are not part of the next burst.
  client.start();
  client.send(RawBytes(14, 0xFF));
  CHECK(client.until_calm());
  CHECK(client.settle().empty());
}

TEST_CASE("simulated Digital F/T: the load is read at each start and after every hundred samples") {
  DigitalClient client([](int number) {
    if (number == 9) throw std::runtime_error("no physics");
    return pull(0.1 * (number + 1));
  });
  const auto begin = std::chrono::steady_clock::now();
  client.start();
  for (int sample = 0; sample < 900; ++sample) {
    const auto came = client.sample();
    if (came.error || came.gauges[1] != 25 * (sample / 100 + 1)) FAIL("sample " << sample << ": " << came.gauges[1]);
  }
  // 900 samples are 129 steps of a millisecond, the first of which takes no time.
  CHECK(std::chrono::steady_clock::now() - begin >= 128ms);
  client.expect_calm();  // without a load the sensor is silent
  CHECK(client.load.asked == 10);
  client.start();
  CHECK(client.sample().gauges[1] == 275);
}

TEST_CASE("simulated Digital F/T: seven samples take about a millisecond") {
  DigitalClient client([](int number) {
    if (number % 2 == 1) throw std::runtime_error("no physics");  // each stream has a hundred samples
    return pull(1.0);
  });
  // Fourteen steps are 28 ms and more where each takes two. On a busy machine one of many streams is on time.
  const auto end = std::chrono::steady_clock::now() + kPatient;
  bool in_time = false;
  while (!in_time && std::chrono::steady_clock::now() < end) {
    const auto begin = std::chrono::steady_clock::now();
    client.start();
    REQUIRE(client.next(100 * kSample).size() == 100 * kSample);
    in_time = std::chrono::steady_clock::now() - begin < 28ms;
  }
  CHECK(in_time);
}

TEST_CASE("simulated Digital F/T: gauge counts are rounded and limited to sixteen bits, whatever the load") {
  const auto gauges_of = [](const Wrench& wrench) {
    DigitalClient client([&](int) { return wrench; });
    client.start();
    return client.sample().gauges;
  };
  using Gauges = std::array<std::int16_t, 6>;
  CHECK(gauges_of({{0.004, 0.008, 0.012}, {0.032, 0.040, 0.048}}) == Gauges{-6, 1, 2, 3, -4, -5});
  CHECK(gauges_of({{0.0099, 0.0101, -0.0101}, {}}) == Gauges{0, 2, 3, -3, 0, 0});
  CHECK(gauges_of({{1e6, -1e6, 131.068}, {}}) == Gauges{0, 32767, -32768, 32767, 0, 0});
  CHECK(gauges_of({{131.064, -131.072, -131.068}, {}}) == Gauges{0, 32766, -32768, -32767, 0, 0});
  CHECK(gauges_of({{std::nan(""), 0.0, 0.0}, {}})[1] == 32767);
}

TEST_CASE("simulated Digital F/T: faults of single samples count the samples of all streams") {
  {
    DigitalClient client([](int) { return pull(1.0); }, {.damaged_sample = 1, .error_sample = 0});
    client.start();
    CHECK(client.sample().error);
    const RawBytes whole = client.next(12 + kSample);  // a byte is missing
    CHECK_FALSE(decode_digital_sample(std::span(whole).first(kSample)));
    const auto third = decode_digital_sample(std::span(whole).subspan(12));
    REQUIRE(third);
    CHECK_FALSE(third->error);
  }
  {
    DigitalClient silent([](int) { return pull(1.0); }, {.silent_after_samples = 0});
    silent.start();
    silent.send(RawBytes(14, 0xFF));
    CHECK(silent.settle().empty());
  }
  DigitalClient few([](int) { return pull(1.0); }, {.silent_after_samples = 3, .error_sample = 2});
  few.start();
  CHECK_FALSE(few.sample().error);
  CHECK_FALSE(few.sample().error);
  CHECK(few.sample().error);
  few.send(RawBytes(14, 0xFF));
  CHECK(few.settle().empty());
}

TEST_CASE("simulated Digital F/T: an injected fault lasts for a hundred samples") {
  std::atomic<int> asked{0};
  DigitalClient client(
      [](int) { return pull(1.0); }, {.inject = [&] {
        const int number = asked++;
        return number == 1 ? InjectedFault::kSaturated : number == 3 ? InjectedFault::kSilent : InjectedFault::kNone;
      }});
  client.start();
  for (int sample = 0; sample < 300; ++sample) CHECK(client.sample().error == (sample / 100 == 1));
  client.expect_calm();
  CHECK((asked == 4 && client.load.asked == 3));
  client.start();
  CHECK_FALSE(client.sample().error);
}
