// The driver of the Digital F/T against a line in memory (scripted_digital.h): how long it waits for each byte,
// and which bytes it takes for what.
#include <catch2/catch.hpp>

#include "devices/force/digital_ft.h"
#include "tests/devices/fault_of.h"
#include "tests/devices/force/scripted_digital.h"

using namespace tactbench::devices;
using namespace tactbench::tests;
using namespace std::chrono_literals;

TEST_CASE("Digital F/T line: each wait is for the quiet, for the reply, or for the reply and the samples") {
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

TEST_CASE("Digital F/T line: a refusal that comes in pieces is a refusal, to a start as to a reading") {
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

TEST_CASE("Digital F/T line: out of step, two samples in a row have to be right") {
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

TEST_CASE("Digital F/T line: noise without end is read to the end of its time, and no longer") {
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

TEST_CASE("Digital F/T line: forces and torques each have their counts") {
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
