#include "devices/wire/daqmx/daqmx_api.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <stdexcept>

#include "devices/force/daqmx_gauges.h"
#include "tests/devices/test_chamber.h"
#include "tests/support/fake_nidaqmx/fake_nidaqmx.h"
#include "tests/support/paths.h"

using namespace tactbench::devices;
using namespace std::chrono_literals;
using tactbench::tests::fake_daqmx;
using tactbench::tests::FakeDaqmx;

namespace {

FakeDaqmx& fresh_card() { return fake_daqmx() = FakeDaqmx{}; }

DaqmxGaugesOptions gauge_options() {
  DaqmxGaugesOptions options;
  options.library = tactbench::tests::fake_nidaqmx_path();
  return options;
}

double gauge_volts(const FakeDaqmx::Levels&, int channel, int sample) { return channel + 0.001 * sample; }

}  // namespace

TEST_CASE("daqmx api: an absent library, and a wrong one") {
  for (const char* library : {"/no/such/libnidaqmx.so", "libm.so.6"})
    check_fault([&] { DaqmxApi api(library); }, "TB-DAQMX-LIBRARY", {}, library);
}

TEST_CASE("daqmx api: the devices that the driver sees") {
  auto& card = fresh_card();
  card.devices = {{}, {"Dev2", "USB-6003", 0xFFFFFFFF, true}};
  DaqmxApi api(tactbench::tests::fake_nidaqmx_path());
  const auto devices = api.list_devices();
  REQUIRE(devices.size() == 2);
  CHECK(devices[0].name == "Dev1");
  CHECK(devices[0].product_type == "USB-6259");
  CHECK(devices[0].serial == "01A2B3C4");
  CHECK_FALSE(devices[0].simulated);
  CHECK(devices[1].name == "Dev2");
  CHECK(devices[1].serial == "FFFFFFFF");
  CHECK(devices[1].simulated);

  check_fault([&] { (void)api.device("Dev3", ""); }, "TB-DAQMX-DEVICE", {}, "01A2B3C4");
  card.devices.clear();
  CHECK(api.list_devices().empty());
  CHECK(fault_id_of([&] { (void)api.device("Dev1", ""); }) == "TB-DAQMX-DEVICE");
  CHECK(card.misuse.empty());
}

TEST_CASE("daqmx api: warnings are kept, each once") {
  fresh_card();
  DaqmxApi api(tactbench::tests::fake_nidaqmx_path());
  api.check(0, "nothing");
  for (int i = 0; i < 3; ++i) api.check(200010, "stopping");
  api.check(200015, "stopping");
  REQUIRE(api.warnings().size() == 2);
  CHECK_THAT(api.warnings()[0], Catch::Contains("200010"));
  CHECK_THAT(api.warnings()[1], Catch::Contains("200015"));
}

TEST_CASE("daqmx gauges: six or seven channels, sample by sample") {
  auto& card = fresh_card();
  card.volts = gauge_volts;
  TurnedClock clock;
  clock.wait_until(3s);
  auto options = gauge_options();
  for (const int channels : {6, 7}) {
    options.channels = channels == 6 ? "Dev1/ai16:21" : "Dev1/ai16:21,Dev1/ai30";
    DaqmxGauges gauges(options, clock);
    CHECK(gauges.channels() == channels);
    for (const int samples : {4, 4, 1, 100}) {
      const auto read = gauges.read(samples);
      CHECK(read.samples == samples);
      CHECK(read.channels == channels);
      CHECK(read.time == 3s);
      REQUIRE(read.volts.size() == static_cast<std::size_t>(samples * channels));
      CHECK(read.volts.back() == gauge_volts({}, channels - 1, samples - 1));
      CHECK(read.volts.front() == 0.0);
    }
    CHECK(gauges.exchanges() == 4);
    CHECK(gauges.identity().serial == "01A2B3C4");
    CHECK(card.terminal == 10106);
    CHECK_THROWS_AS(gauges.read(0), std::invalid_argument);
  }
  CHECK(std::count(card.calls.begin(), card.calls.end(), "CfgSampClkTiming") == 2 * 3);
  CHECK(card.tasks == 0);
  CHECK(card.misuse.empty());
}
