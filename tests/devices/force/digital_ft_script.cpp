// The driver of the Digital F/T against a line in memory (scripted_digital.h).
#include <algorithm>
#include <catch2/catch.hpp>

#include "devices/force/digital_ft.h"
#include "tests/devices/fault_of.h"
#include "tests/devices/force/scripted_digital.h"

using namespace tactbench::devices;
using namespace tactbench::tests;
using namespace std::chrono_literals;

TEST_CASE("Digital F/T line: opening sends a 14-byte jam, reads calibration and gains, and writes no register") {
  Script script;
  auto sensor = script.open();
  CHECK(script.line.written == std::vector<Bytes>{Bytes(14, 0xFF), rtu_read_holding(kUnit, 0x00E3, 125),
                                                  rtu_read_holding(kUnit, 0x00E3 + 125, 44),
                                                  rtu_read_holding(kUnit, 0x0000, 12)});
  CHECK(sensor.exchanges() == 3);
  CHECK(sensor.calibration_serial() == "FT99902");
  CHECK(sensor.range() == SixAxes{500, 500, 500, 500, 500, 500});
  const Identity identity = sensor.identity();
  CHECK((identity.role == "force sensor" && identity.serial == "FT99902" && identity.firmware.empty()));
  CHECK((identity.model == script.options.model && identity.origin == Origin::kHardware));
  CHECK(script.clock.now() == 0s);
}

TEST_CASE("Digital F/T line: opening is refused if a gauge gain or offset differs from the calibration") {
  for (int i = 0; i < 12; ++i) {
    Script script;
    script.line.registers[i] = static_cast<std::uint16_t>(0x4000 + i);
    check_fault([&] { (void)script.open(); }, "TB-FORCE-CALIBRATION", {}, "G" + std::to_string(i % 6) + " ");
  }
}

TEST_CASE("Digital F/T line: a reading is the mean of its samples, however their bytes are split") {
  for (const std::size_t chunk : {1U, 5U, 13U, 14U, 1000U}) {
    Script script;
    script.say({100, 200, 300, 400, 500, 600});
    script.say({-100, 201, 302, 403, 504, 605});
    script.say({30'000, 1, 1, 1, 1, 1});  // not asked for
    auto sensor = script.open();
    script.line.chunk = chunk;
    script.clock.wait_until(7s);
    const auto reading = sensor.read(2);
    CHECK(reading.raw == SixAxes{0, 200.5, 301, 401.5, 502, 602.5});
    CHECK(reading.wrench.force_n[0] == Approx(0.004 * 200.5).epsilon(1e-12));
    CHECK(reading.wrench.force_n[1] == Approx(0.004 * 301).epsilon(1e-12));
    CHECK(reading.wrench.force_n[2] == Approx(0.004 * 401.5).epsilon(1e-12));
    CHECK(reading.wrench.torque_nmm[0] == Approx(-0.008 * 502).epsilon(1e-12));
    CHECK(reading.wrench.torque_nmm[1] == Approx(-0.008 * 602.5).epsilon(1e-12));
    CHECK(reading.wrench.torque_nmm[2] == Approx(0.0).margin(1e-12));
    CHECK((reading.records == 2 && reading.lost == 0 && reading.time == 7s));
    CHECK(sensor.exchanges() == 4);
    CHECK(script.line.written[4] == digital_start_stream(kUnit));
    CHECK(script.jams() == 2);
    CHECK(script.line.written.size() == 6);
  }
}

TEST_CASE("Digital F/T line: after a delay beyond the timeout, one more read accepts samples that already arrived") {
  for (const std::size_t samples_a_look : {2U, 1U}) {
    Script script;
    for (int i = 0; i < 4; ++i) script.say({100, 200, 300, 400, 500, 600});
    script.options.reply_timeout = 500ms;
    auto sensor = script.open();
    script.line.chunk = samples_a_look * kDigitalSampleBytes;
    script.line.waits.clear();
    script.line.slow_read = 2;  // the first after the answer to the start
    script.line.held_up = 600ms;
    const auto fault = fault_of([&] { (void)sensor.read(4); });
    REQUIRE(fault.has_value() == (samples_a_look == 1));
    if (fault) CHECK(fault->id() == "TB-FORCE-TIMEOUT");
  }
}

TEST_CASE("Digital F/T line: bytes received before a request are not used as its reply") {
  Script script;
  script.say({100, 200, 300, 400, 500, 600});
  script.line.change = [](const Bytes&, Bytes answer) {
    if (answer[1] == 3) answer.push_back(0x55);  // noise after each answer
    return answer;
  };
  auto sensor = script.open();
  script.line.coming = {1, 2, 3};
  CHECK(sensor.read(1).raw[1] == 200.0);
  CHECK(script.clock.now() == 0s);
}

TEST_CASE("Digital F/T line: after a bias, loads are relative to the measured bias and raw counts are not") {
  Script script;
  script.say({0, 1000, 0, 0, 0, 0});  // Fx 4 N
  auto sensor = script.open();
  CHECK(sensor.bias(1).wrench.force_n[0] == Approx(4.0));
  script.line.stream.clear();
  script.say({0, 1500, 0, 0, 1000, 0});
  const auto reading = sensor.read(1);
  CHECK(reading.wrench.force_n[0] == Approx(2.0));
  CHECK(reading.wrench.torque_nmm[0] == Approx(-8.0));
  CHECK(reading.raw[1] == 1500.0);
}

TEST_CASE("Digital F/T line: a load at the range is accepted, one beyond it in any sample is an overload fault") {
  // 0.25 N are exactly 64 gauge counts of 1/256 N here; -0.5 N*mm are 64 of -1/128 N*mm.
  DigitalCalibration exact = invented_digital();
  for (std::size_t row = 0; row < 6; ++row) exact.matrix[row] = {};
  for (std::size_t row = 0; row < 6; ++row) exact.matrix[row][row] = row < 3 ? 4.0F : -8.0F;
  exact.counts_per_force = 1024;
  exact.counts_per_torque = 1'024'000;
  exact.range = {0.25F, 0.25F, 0.25F, 0.0005F, 0.0005F, 0.0005F};
  for (std::size_t axis = 0; axis < 6; ++axis) {
    for (const int sign : {1, -1}) {
      Script script(exact);
      std::array<std::int16_t, 6> gauges{};
      gauges[axis] = static_cast<std::int16_t>(sign * (axis < 3 ? 64 : 63));
      script.say(gauges);
      auto sensor = script.open();
      CHECK(fault_id_of([&] { (void)sensor.read(1); }) == "none");
      script.line.stream.clear();
      script.say({});
      gauges[axis] = static_cast<std::int16_t>(sign * 65);
      script.say(gauges);
      constexpr std::array<const char*, 6> kWords{"Fx", "Fy", "Fz", "Tx", "Ty", "Tz"};
      check_fault([&] { (void)sensor.read(2); }, "TB-FORCE-OVERLOAD", {}, kWords[axis]);
      CHECK(script.jams() == 3);  // opening, and after each reading
    }
  }
}

TEST_CASE(
    "Digital F/T line: a gauge at its count limit is a saturation fault that names it, one count less is a value") {
  for (std::size_t gauge = 0; gauge < 6; ++gauge) {
    for (const int limit : {-32768, 32767}) {
      Script script;
      std::array<std::int16_t, 6> gauges{};
      gauges[gauge] = static_cast<std::int16_t>(limit);
      script.say(gauges);
      auto sensor = script.open();
      check_fault([&] { (void)sensor.read(1); }, "TB-FORCE-SATURATED", {}, "G" + std::to_string(gauge) + " ");
      gauges[gauge] = static_cast<std::int16_t>(limit < 0 ? limit + 1 : limit - 1);
      script.line.stream.clear();
      script.say(gauges);
      CHECK(sensor.read(1).raw[gauge] == gauges[gauge]);
    }
  }
}

TEST_CASE("Digital F/T line: damaged bytes lose only the samples they belong to") {
  const std::array<std::int16_t, 6> right{1, 2, 3, 4, 5, 6};
  const auto reading_of = [&](const Bytes& damage, std::size_t chunk) {
    Script script;
    script.say(right);
    script.line.stream.insert(script.line.stream.end(), damage.begin(), damage.end());
    for (int i = 0; i < 4; ++i) script.say(right);
    auto sensor = script.open();
    script.line.chunk = chunk;
    const auto reading = sensor.read(4);
    CHECK(reading.raw == SixAxes{1, 2, 3, 4, 5, 6});
    return reading.lost;
  };
  auto torn = encode(DigitalSample{right, false});
  for (const std::size_t chunk : {1U, 13U, 1000U}) {
    CHECK(reading_of({}, chunk) == 0);
    CHECK(reading_of(Bytes(torn.begin(), torn.begin() + 12), chunk) == 1);
    CHECK(reading_of(Bytes{0x31}, chunk) == 1);
    torn[3] ^= 0x10U;
    CHECK(reading_of(Bytes(torn.begin(), torn.end()), chunk) == 1);
    torn[3] ^= 0x10U;
    // Thirteen zeros have the right sum, off the track as on it: between other bytes they are no sample.
    Bytes chance(torn.begin(), torn.begin() + 5);
    chance.insert(chance.end(), 13, 0);
    chance.insert(chance.end(), {0x31, 0x32, 0x33});
    CHECK(reading_of(chance, chunk) == 1);
  }
}

TEST_CASE("Digital F/T line: an error bit ends the reading, and the fault states the status register") {
  Script script;
  script.line.registers[0x001D] = 0xA55A;
  script.say({1, 2, 3, 4, 5, 6});
  script.say({1, 2, 3, 4, 5, 6}, true);
  auto sensor = script.open();
  CHECK(sensor.read(1).records == 1);
  check_fault([&] { (void)sensor.read(2); }, "TB-FORCE-STATUS", {}, "0xA55A");
  CHECK(script.line.written.back() == rtu_read_holding(kUnit, 0x001D, 1));
  CHECK(script.jams() == 3);  // the line is quiet before the register is asked for
}

TEST_CASE("Digital F/T line: a stream that stops early times out after the reply time plus the sample time") {
  Script script;
  script.options.reply_timeout = 300ms;
  script.options.samples_per_second = 1000.0;
  for (int i = 0; i < 3; ++i) script.say({1, 2, 3, 4, 5, 6});
  auto sensor = script.open();
  check_fault([&] { (void)sensor.read(50); }, "TB-FORCE-TIMEOUT", {}, "3 came");
  CHECK(script.clock.now() == 350ms);
  CHECK(script.jams() == 2);
  script.line.torn = true;
  script.line.stream.clear();
  CHECK(fault_id_of([&] { (void)sensor.read(1); }) == "TB-SERIAL-LOST");
  CHECK(script.jams() == 2);  // nobody is there to hear one
}

TEST_CASE("Digital F/T line: short, damaged, refused and foreign replies are distinguished") {
  const auto check_opened = [](const std::function<Bytes(Bytes)>& change, const std::string& id,
                               const std::string& number = {}) {
    Script script;
    script.options.reply_timeout = 300ms;
    script.line.change = [&](const Bytes&, const Bytes& answer) { return change(answer); };
    check_fault([&] { (void)script.open(); }, id, {}, number);
    CHECK(script.clock.now() == (id == "TB-FORCE-TIMEOUT" ? Nanoseconds(300ms) : Nanoseconds(0)));
  };
  const std::string late = "TB-FORCE-TIMEOUT", wrong = "TB-FORCE-PROTOCOL";
  check_opened([](Bytes answer) { return Bytes(answer.begin(), answer.end() - 1); }, late, "254 of 255");
  check_opened([](Bytes answer) { return Bytes(answer.begin(), answer.begin() + 4); }, late, "4 of 255");
  check_opened([](const Bytes&) { return Bytes{kUnit, 0x83, 2, 0}; }, late, "4 of 255");
  check_opened([](const Bytes&) { return Bytes(); }, late, "0 of 255");
  for (const std::uint8_t exception : {std::uint8_t{1}, std::uint8_t{2}, std::uint8_t{4}}) {
    const Bytes refusal = rtu_frame(Bytes{kUnit, 0x83, exception});
    check_opened([&](const Bytes&) { return refusal; }, wrong, "exception " + std::to_string(exception));
  }
  for (const std::size_t at : {100U, 253U, 254U}) {
    check_opened(
        [&](Bytes answer) {
          answer[at] ^= 1U;
          return answer;
        },
        wrong);
  }
  check_opened([](const Bytes&) { return rtu_frame(Bytes{kUnit + 1, 0x83, 2}); }, wrong);
  check_opened(
      [](const Bytes& answer) {
        Bytes body(answer.begin(), answer.end() - 2);
        body[0] = kUnit + 1;
        return rtu_frame(body);
      },
      wrong);
  check_opened(
      [](const Bytes&) {
        Bytes refusal = rtu_frame(Bytes{kUnit, 0x83, 2});
        refusal[4] ^= 1U;
        return refusal;
      },
      wrong);
}

TEST_CASE("Digital F/T line: a sensor that keeps sending is jammed again after 64 reads") {
  for (const std::size_t waiting : {63U, 64U}) {
    Script script;
    script.line.coming.assign(waiting, 0x41);
    script.line.deaf = true;
    script.line.chunk = 1;
    auto sensor = script.open();
    CHECK(script.jams() == (waiting == 63 ? 1 : 2));
  }
}

TEST_CASE("Digital F/T line: an invalid number of records is refused without a request") {
  Script script;
  auto sensor = script.open();
  const std::size_t before = script.line.written.size();
  CHECK(fault_id_of([&] { (void)sensor.read(0); }) == "TB-FORCE-RECORDS");
  CHECK(fault_id_of([&] { (void)sensor.bias(kMaxForceRecords + 1); }) == "TB-FORCE-RECORDS");
  CHECK(script.line.written.size() == before);
}

TEST_CASE(
    "Digital F/T line: each wait lasts for the quiet time, the reply time, or the reply time plus the sample time") {
  Script script;
  script.options.quiet = 30s;
  script.options.reply_timeout = 100s;
  script.options.samples_per_second = 0.5;
  script.line.chunk = 50;  // answers of more bytes come in pieces
  script.line.coming = {1, 2, 3};
  script.line.deaf = true;
  auto sensor = script.open();
  auto& waits = script.line.waits;
  // The rest of an old stream and then nothing; 255, 93 and 29 bytes of answers.
  REQUIRE(waits.size() == 2 + 6 + 2 + 1);
  for (std::size_t i = 0; i < waits.size(); ++i) {
    INFO(i);
    CHECK((waits[i] <= (i < 2 ? 30s : 100s) && waits[i] > (i < 2 ? 20s : 90s)));
  }
  waits.clear();
  for (int i = 0; i < 8; ++i) script.say({1, 2, 3, 4, 5, 6});
  (void)sensor.read(8);  // 16 s of samples
  REQUIRE(waits.size() == 1 + 3 + 1);
  CHECK((waits[0] <= 100s && waits[0] > 90s));
  for (std::size_t i = 1; i < 4; ++i) CHECK((waits[i] <= 116s && waits[i] > 106s));
  CHECK((waits[4] <= 30s && waits[4] > 20s));
}

TEST_CASE("Digital F/T line: a busy sensor is asked again until the reply time is over") {
  for (const std::uint8_t exception : {std::uint8_t{5}, std::uint8_t{6}}) {
    Script script;
    script.options.reply_timeout = 300ms;
    int left = 3;
    script.line.change = [&](const Bytes& request, const Bytes& answer) {
      return left-- > 0 ? rtu_frame(Bytes{kUnit, static_cast<std::uint8_t>(request[1] | 0x80U), exception}) : answer;
    };
    auto sensor = script.open();
    CHECK(script.clock.now() > 0ms);
    CHECK(script.clock.now() < 300ms);
    left = 1'000'000;
    const Nanoseconds begun = script.clock.now();
    check_fault([&] { (void)sensor.read(1); }, "TB-FORCE-PROTOCOL", {}, "exception " + std::to_string(exception));
    CHECK(script.clock.now() - begun >= 300ms);
    CHECK(script.clock.now() - begun < 400ms);
  }
}

TEST_CASE("Digital F/T line: a refusal of the stream start is recognised even if it arrives in pieces") {
  Script script;
  auto sensor = script.open();
  script.line.chunk = 1;
  script.line.change = [](const Bytes& request, const Bytes& answer) {
    if (request[1] == 0x46) return rtu_frame(Bytes{kUnit, 0xC6, 6});
    return answer;
  };
  check_fault([&] { (void)sensor.read(1); }, "TB-FORCE-PROTOCOL", {}, "exception 6");
  CHECK(script.jams() == 2);
  script.line.change = [](const Bytes&, const Bytes&) { return Bytes(); };
  check_fault([&] { (void)sensor.read(1); }, "TB-FORCE-TIMEOUT", {}, "0 of 5");
}

TEST_CASE("Digital F/T line: after lost synchronisation, two valid samples in a row are required") {
  // A right sample among wrong bytes, then again wrong ones, then two: the first one counts for nothing.
  const auto right = encode(DigitalSample{{1, 2, 3, 4, 5, 6}, false});
  const auto other = encode(DigitalSample{{60, 50, 40, 30, 20, 10}, false});
  Script script;
  auto sensor = script.open();
  auto& stream = script.line.stream;
  stream.insert(stream.end(), {0x31, 0x32, 0x33});
  stream.insert(stream.end(), other.begin(), other.end());
  stream.insert(stream.end(), 7, 0x35);
  for (int i = 0; i < 2; ++i) stream.insert(stream.end(), right.begin(), right.end());  // and nothing behind them
  const auto reading = sensor.read(2);
  CHECK(reading.raw == SixAxes{1, 2, 3, 4, 5, 6});
  CHECK(reading.lost == 1);
  CHECK(sensor.read(2).lost == 2);  // counted over all readings
}

TEST_CASE("Digital F/T line: endless noise ends in a timeout after the reply time plus the sample time") {
  Script script;
  script.options.reply_timeout = 20ms;
  script.options.samples_per_second = 1000.0;
  auto sensor = script.open();
  script.line.change = [&](const Bytes& request, const Bytes& answer) {
    script.line.endless = request[1] == 0x46;
    return answer;
  };
  check_fault([&] { (void)sensor.read(5); }, "TB-FORCE-TIMEOUT", {}, "25 ms");
}

TEST_CASE("Digital F/T line: forces and torques each use their own counts per unit") {
  DigitalCalibration calibration = wide();
  for (std::size_t row = 0; row < 6; ++row) {
    calibration.matrix[row] = {};
    calibration.matrix[row][row] = 2.0F;
  }
  calibration.counts_per_force = 100;
  calibration.counts_per_torque = 8000;
  calibration.range = {50.0F, 60.0F, 70.0F, 8.0F, 9.0F, 10.0F};
  Script script(calibration);
  script.say({100, 200, 300, 4, 5, 6});
  auto sensor = script.open();
  CHECK(sensor.range() == SixAxes{50, 60, 70, 8000, 9000, 10'000});
  const auto wrench = sensor.read(1).wrench;
  CHECK(wrench.force_n == std::array<double, 3>{2, 4, 6});
  CHECK(wrench.torque_nmm == std::array<double, 3>{1, 1.25, 1.5});
}
