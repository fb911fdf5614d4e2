// The driver of the Digital F/T against a line in memory (scripted_digital.h).
#include <algorithm>
#include <catch2/catch.hpp>

#include "devices/force/digital_ft.h"
#include "tests/devices/fault_of.h"
#include "tests/devices/force/scripted_digital.h"

using namespace tactbench::devices;
using namespace tactbench::tests;
using namespace std::chrono_literals;

TEST_CASE(
    "Digital F/T line: opening jams with 14 bytes, then reads the calibration and the gains, and writes nothing") {
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

TEST_CASE("Digital F/T line: each gain and offset has to be the calibration's") {
  for (int i = 0; i < 12; ++i) {
    Script script;
    script.line.registers[i] = static_cast<std::uint16_t>(0x4000 + i);
    check_fault([&] { (void)script.open(); }, "TB-FORCE-CALIBRATION", {}, "G" + std::to_string(i % 6) + " ");
  }
}

TEST_CASE("Digital F/T line: a reading is the mean of its samples, however they come") {
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

TEST_CASE("Digital F/T line: samples that lie on the line are taken by a program that was held up, in one look more") {
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

TEST_CASE("Digital F/T line: bytes received before a request are not taken for its reply") {
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

TEST_CASE("Digital F/T line: the bias is what was measured, and overload is judged from it on") {
  Script script;
  script.say({0, 1000, 0, 0, 0, 0});  // Fx 4 N
  auto sensor = script.open();
  CHECK(sensor.bias(1).force_n[0] == Approx(4.0));
  script.line.stream.clear();
  script.say({0, 1500, 0, 0, 1000, 0});
  const auto reading = sensor.read(1);
  CHECK(reading.wrench.force_n[0] == Approx(2.0));
  CHECK(reading.wrench.torque_nmm[0] == Approx(-8.0));
  CHECK(reading.raw[1] == 1500.0);
}

TEST_CASE("Digital F/T line: the range itself is no overload, a count beyond it is, of any sample") {
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

TEST_CASE("Digital F/T line: a gauge at its limit is named, one count off it is a value") {
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
