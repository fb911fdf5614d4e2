// NI-DAQmx call by call: what each is asked, each error that is named, each serial number that is the same.
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "devices/wire/daqmx/daqmx_api.h"
#include "tests/devices/daqmx_card.h"
#include "tests/devices/fault_of.h"
#include "tests/support/paths.h"

using namespace tactbench::devices;
using namespace std::chrono_literals;
using tactbench::tests::FakeDaqmx;

namespace {

struct DaqmxBench : DaqmxCard {
  DaqmxApi api{tactbench::tests::fake_nidaqmx_path()};
  // Whether the failure of this function is the driver's own error, told by its number.
  template <class Act>
  void check_failure(const std::string& function, Act&& act) {
    fail(function, -200088);
    INFO(function);
    check_fault(act, "TB-DAQMX-ERROR", {}, "-200088");
    card.fail_function.clear();
  }
};

double channel_and_sample(const FakeDaqmx::Levels&, int channel, int sample) { return 10.0 * sample + channel; }

}  // namespace

TEST_CASE("daqmx errors: each states its number, and is classified as timeout, device gone or samples lost") {
  const struct {
    int code;
    bool timed_out, gone, lost;
  } errors[] = {{-200284, true, false, false}, {-200279, false, false, true},  {-200221, true, false, false},
                {-200220, false, true, false}, {-200170, false, false, false}, {-200324, false, true, false},
                {-200045, false, true, false}, {-200088, false, false, false}, {-200019, false, false, true},
                {-50103, false, false, false}, {-88709, false, false, false},  {-201003, false, true, false},
                {-1, false, false, false},     {-200278, false, false, false}, {-200285, false, false, false}};
  DaqmxBench bench;
  for (const auto& error : errors) {
    INFO("error " << error.code);
    try {
      bench.api.check(error.code, "asking");
      FAIL("no error");
    } catch (const DaqmxError& fault) {
      CHECK(fault.code() == error.code);
      CHECK_FALSE(fault.remedy().empty());
      CHECK_THAT(fault.what(), Catch::Contains(std::to_string(error.code)));
      CHECK(fault.timed_out() == error.timed_out);
      CHECK(fault.device_gone() == error.gone);
      CHECK(fault.samples_lost() == error.lost);
    }
  }
  CHECK(bench.api.warnings().empty());
}

TEST_CASE("daqmx devices: a device is found by name, with its serial number in any notation") {
  DaqmxBench bench;
  bench.card.devices = {{"Dev1", "USB-6259", 0x01A2B3C4, false},
                        {"", "", 0, false},
                        {"cDAQ1Mod2", "NI 9205", 0, true},
                        {"Dev2", "USB-6003", 0xFFFFFFFF, false}};
  CHECK(bench.api.device("Dev2", "ffffffff").serial == "FFFFFFFF");
  CHECK_FALSE(bench.api.device("Dev2", "").simulated);
  for (const char* separator : {",", ", ", ",   "}) {
    bench.card.separator = separator;
    const auto devices = bench.api.list_devices();
    REQUIRE(devices.size() == 3);
    CHECK((devices[0].name == "Dev1" && devices[1].name == "cDAQ1Mod2" && devices[2].name == "Dev2"));
  }
  for (const char* serial : {"", "01A2B3C4", "1a2b3c4", "001A2B3C4"}) {
    CHECK(bench.api.device("Dev1", serial).product_type == "USB-6259");
  }
  CHECK(bench.api.device("cDAQ1Mod2", "0").simulated);
  CHECK(bench.api.device("cDAQ1Mod2", "0").serial == "00000000");
  for (const char* serial : {"01A2B3C5", "01A2B3C4 ", "x", "01A2B3C4F0"}) {
    const auto fault = fault_of([&] { (void)bench.api.device("Dev1", serial); });
    CHECK((fault && fault->id() == "TB-DAQMX-SERIAL"));
  }
  check_fault([&] { (void)bench.api.device("Dev", ""); }, "TB-DAQMX-DEVICE", {}, "01A2B3C4");
  bench.card.devices.clear();
  CHECK(bench.api.list_devices().empty());
  CHECK(fault_id_of([&] { (void)bench.api.device("Dev1", ""); }) == "TB-DAQMX-DEVICE");
  CHECK(bench.api.warnings().empty());
}

TEST_CASE("daqmx devices: each failing call of the listing is the driver's error") {
  for (const char* function : {"GetSysDevNames", "GetDevProductType", "GetDevSerialNum", "GetDevIsSimulated"}) {
    for (const int later : {0, 1}) {  // asked for a length, and for the text
      if (later == 1 && std::string(function).find("Names") == std::string::npos &&
          std::string(function).find("Type") == std::string::npos)
        continue;
      INFO(function << ", call " << later);
      DaqmxBench bench;
      bench.fail(function, -200324, later);
      CHECK(fault_id_of([&] { (void)bench.api.list_devices(); }) == "TB-DAQMX-ERROR");
    }
  }
}

TEST_CASE("daqmx task: terminal configuration, range, rate and timeout are passed to the driver unchanged") {
  const std::pair<DaqmxTerminal, int> terminals[] = {
      {DaqmxTerminal::kRse, 10083}, {DaqmxTerminal::kNrse, 10078}, {DaqmxTerminal::kDifferential, 10106}};
  for (const auto& [terminal, number] : terminals) {
    DaqmxBench bench;
    bench.card.volts = channel_and_sample;
    {
      DaqmxTask task(bench.api);
      CHECK(bench.card.tasks == 1);
      task.add_voltages("Dev1/ai0:1,Dev1/ai4", terminal, Volts(2.5));
      CHECK(bench.card.terminal == number);
      CHECK(bench.card.minimum == -2.5);
      CHECK(bench.card.maximum == 2.5);
      CHECK(task.channels() == 3);
      task.finite_samples(1250.0, 4);
      CHECK(bench.card.rate == 1250.0);
      task.convert_rate(40'000.0);
      CHECK(bench.card.convert_rate == 40'000.0);
      task.commit();
      task.start();
      std::array<double, 12> volts{};
      task.read(4, 1'250ms, volts);
      CHECK(bench.card.timeout == 1.25);
      CHECK(volts == std::array<double, 12>{0, 1, 2, 10, 11, 12, 20, 21, 22, 30, 31, 32});
      task.stop();
      task.start();  // stopped, it starts again
    }
    CHECK(bench.card.tasks == 0);
    REQUIRE(bench.card.calls.size() >= 2);
    CHECK(bench.card.calls[bench.card.calls.size() - 2] == "StopTask");
    CHECK(bench.card.calls.back() == "ClearTask");
  }
}

TEST_CASE("daqmx task: lines are written at once, with a timeout of one second") {
  DaqmxBench bench;
  DaqmxTask task(bench.api);
  task.add_output_lines("Dev1/port0/line0:2");
  CHECK(task.channels() == 3);
  task.write_lines(std::array<std::uint8_t, 3>{1, 0, 1});
  CHECK(bench.card.lines == FakeDaqmx::Levels{1, 0, 1});
  CHECK(bench.card.write_timeout == 1.0);
}

TEST_CASE("daqmx task: too few or non-finite samples are a fault") {
  DaqmxBench bench;
  bench.card.volts = channel_and_sample;
  DaqmxTask task(bench.api);
  task.add_voltages("Dev1/ai0:1", DaqmxTerminal::kRse, Volts(10.0));
  task.finite_samples(1000.0, 5);
  task.start();
  std::array<double, 10> volts{};
  const auto read = [&] { return fault_id_of([&] { task.read(5, 1s, volts); }); };
  CHECK(read() == "none");
  bench.card.short_by = 1;
  CHECK(read() == "TB-DAQMX-SHORT");
  CHECK(std::isnan(volts[8]));  // what did not come is no number of an earlier reading
  bench.card.short_by = 5;
  CHECK(read() == "TB-DAQMX-SHORT");
  bench.card.short_by = 0;
  for (const double bad : {std::nan(""), std::numeric_limits<double>::infinity()}) {
    for (const int at : {0, 7, 9}) {
      bench.card.volts = [&](const FakeDaqmx::Levels&, int channel, int sample) {
        return 2 * sample + channel == at ? bad : 1.0;
      };
      CHECK(read() == "TB-DAQMX-SHORT");
    }
  }
}

TEST_CASE("daqmx task: each failing call is the driver's error") {
  DaqmxBench bench;
  bench.check_failure("CreateTask", [&] { DaqmxTask(bench.api); });
  DaqmxTask task(bench.api);
  const auto add = [&] { task.add_voltages("Dev1/ai0:1", DaqmxTerminal::kRse, Volts(10.0)); };
  bench.check_failure("CreateAIVoltageChan", add);
  add();
  bench.check_failure("GetTaskNumChans", [&] { (void)task.channels(); });
  bench.check_failure("CfgSampClkTiming", [&] { task.finite_samples(1500.0, 10); });
  task.finite_samples(1500.0, 10);
  bench.check_failure("SetAIConvRate", [&] { task.convert_rate(50'000.0); });
  bench.check_failure("TaskControl", [&] { task.commit(); });
  bench.check_failure("StartTask", [&] { task.start(); });
  task.start();
  std::array<double, 20> volts{};
  bench.check_failure("ReadAnalogF64", [&] { task.read(10, 1s, volts); });
  DaqmxTask lines(bench.api);
  bench.check_failure("CreateDOChan", [&] { lines.add_output_lines("Dev1/port0/line0:1"); });
  lines.add_output_lines("Dev1/port0/line0:1");
  bench.check_failure("WriteDigitalLines", [&] { lines.write_lines(std::array<std::uint8_t, 2>{1, 0}); });
}

TEST_CASE("daqmx api: a missing library and a wrong one are a fault that names the library") {
  for (const char* library : {"/no/such/libnidaqmx.so", "libm.so.6"})
    check_fault([&] { DaqmxApi api(library); }, "TB-DAQMX-LIBRARY", {}, library);
}

TEST_CASE("daqmx api: each warning is kept once") {
  DaqmxBench bench;
  bench.api.check(0, "nothing");
  for (int i = 0; i < 3; ++i) bench.api.check(200010, "stopping");
  bench.api.check(200015, "stopping");
  REQUIRE(bench.api.warnings().size() == 2);
  CHECK_THAT(bench.api.warnings()[0], Catch::Contains("200010"));
  CHECK_THAT(bench.api.warnings()[1], Catch::Contains("200015"));
}
