// The driver of the Digital F/T against a line in memory (scripted_digital.h) whose bytes are damaged, late or missing.
#include <algorithm>
#include <catch2/catch.hpp>

#include "devices/force/digital_ft.h"
#include "tests/devices/fault_of.h"
#include "tests/devices/force/scripted_digital.h"

using namespace tactbench::devices;
using namespace tactbench::tests;
using namespace std::chrono_literals;

TEST_CASE("Digital F/T line: damaged bytes cost their samples and no more") {
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

TEST_CASE("Digital F/T line: an error bit ends the reading, and the status register is reported") {
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

TEST_CASE("Digital F/T line: a stream that dries up costs the reply's time and that of the samples") {
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
  for (const std::uint8_t exception : {1, 2, 4}) {
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

TEST_CASE("Digital F/T line: a sensor that keeps sending is jammed again after 64 pieces") {
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
  CHECK(fault_id_of([&] { (void)sensor.bias(kMostForceRecords + 1); }) == "TB-FORCE-RECORDS");
  CHECK(script.line.written.size() == before);
}
