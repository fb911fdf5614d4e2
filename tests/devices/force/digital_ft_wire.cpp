#include "devices/force/digital_ft.h"

#include <catch2/catch.hpp>
#include <mutex>

#include "devices/force/simulated_digital_ft.h"
#include "devices/wire/byte_stream.h"
#include "tests/devices/force/invented_digital.h"
#include "tests/devices/test_chamber.h"

using namespace tactbench::devices;
using namespace std::chrono_literals;

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
