#include <catch2/catch.hpp>
#include <chrono>
#include <fstream>

#include "bench/config/config_profile.h"
#include "devices/wire/modbus/modbus_value.h"
#include "sequences/toml/strict_toml.h"
#include "tests/support/process.h"

using namespace tactbench;
using bench::read_module_profile;

namespace {

std::string error_of(const std::string& name) {
  try {
    (void)read_module_profile(name);
  } catch (const sequences::FileError& error) {
    return error.id() + " " + error.what() + " " + error.remedy();
  }
  return "none";
}

}  // namespace

TEST_CASE("module profiles: the addresses of the EK9000") {
  const auto profile = read_module_profile("beckhoff-ek9000");
  CHECK(profile.tcp);
  CHECK_FALSE(profile.rtu);
  CHECK(profile.inputs.address == 0x0000);
  CHECK(profile.outputs.address == 0x0800);
  CHECK(profile.outputs.function == 23);
  CHECK(profile.fail_safe.watchdog_address == 0x1120);
  CHECK(profile.fail_safe.fallbacks_address == 0x1021);
  CHECK(profile.fail_safe.layers.size() == 2);
}

TEST_CASE("module profiles: each shipped one is read, and has outputs or inputs") {
  const auto names = bench::shipped_profiles();
  CHECK(names.size() >= 7);
  for (const std::string& name : names) {
    INFO(name);
    const auto profile = read_module_profile(name);
    CHECK(profile.name == name);
    CHECK(profile.outputs.channels + profile.inputs.channels > 0);
  }
}

TEST_CASE("module profiles: ADAM, Moxa and Waveshare have the addresses of the manuals") {
  const auto adam = read_module_profile("advantech-adam-6024");
  CHECK(adam.outputs.address == 40011 - 40001);
  CHECK(adam.inputs.address + adam.inputs.status_offset == 40021 - 40001);
  const auto moxa = read_module_profile("moxa-iologik-e1241");
  CHECK(moxa.outputs.address == 41025 - 40001);
  CHECK(moxa.fail_safe.safe_mode_address == 0x1010);
  CHECK(moxa.fail_safe.safe_mode_clear_address == 0x1020);
  const auto waveshare = read_module_profile("waveshare-analog-output-8ch-b");
  CHECK_FALSE(waveshare.tcp);
  CHECK(waveshare.outputs.volts.raw(1.0) == 1000.0);  // 01 06 00 00 03 E8: 1 V
  CHECK(waveshare.fail_safe.layers.empty());
}

TEST_CASE("module profiles: an unknown name, an invalid function and an unknown key are reported") {
  CHECK_THAT(error_of("beckhof-ek9000"), Catch::Contains("TB-MODULE-PROFILE"));
  const tests::TemporaryFolder folder;
  const auto write = [&](const std::string& text) {
    const std::string path = folder.path() + "/mine.toml";
    std::ofstream(path) << "schema = 1\nmodel = \"mine\"\ntransport = \"any\"\n" << text;
    return path;
  };
  CHECK_THAT(error_of(write("[outputs]\nchannels = 1\nfunction = 15\n")), Catch::Contains("6, 16, 23"));
  CHECK_THAT(error_of(write("[outputs]\nchannels = 1\nadress = 3\n")), Catch::Contains("adress"));
  CHECK_THAT(error_of(write("[outputs]\nchannels = 1\nvolts_span = [2, 10]\n")), Catch::Contains("0 V"));
  CHECK_THAT(error_of(write("[outputs]\nchannels = 1\nfunction = 23\n")), Catch::Contains("23"));
  CHECK(error_of(write("[inputs]\nchannels = 1\n")) == "none");
}

TEST_CASE("module profiles: defaults, and values that are rejected") {
  const tests::TemporaryFolder folder;
  const std::string path = folder.path("mine.toml");
  const auto told = [&](const std::string& text) {
    std::ofstream(path) << "schema = 1\nmodel = \"mine\"\ntransport = \"any\"\n" << text;
    return error_of(path);
  };
  REQUIRE(told("[outputs]\nchannels = 1\n[inputs]\nchannels = 2\n") == "none");
  const auto profile = read_module_profile(path);
  CHECK(profile.tcp);
  CHECK(profile.rtu);
  CHECK(profile.max_reply_delay == std::chrono::seconds(1));
  CHECK(profile.outputs.function == 16);
  CHECK(profile.outputs.address == 0);
  CHECK(profile.outputs.readback == 3);
  CHECK(profile.outputs.volts.raw(10.0) == 32767.0);
  CHECK(profile.outputs.volts.raw(0.0) == 0.0);
  CHECK(profile.inputs.function == 4);
  CHECK(profile.inputs.address == 0);
  CHECK(profile.fail_safe.watchdog_address == -1);
  CHECK(profile.fail_safe.fallbacks_address == -1);
  CHECK(profile.fail_safe.safe_mode_address == -1);
  CHECK(profile.fail_safe.safe_mode_clear_address == -1);
  const std::string outputs = "[outputs]\nchannels = 1\n", inputs = "[inputs]\nchannels = 1\n";
  for (const std::string& wrong :
       {outputs + "readback_function = 6", inputs + "function = 16", outputs + "volts_span = [-10, 0]",
        outputs + "volts_span = [0.1, 10]", outputs + "raw_span = [-1, 100]", outputs + "raw_span = [0, 65536]",
        std::string("[outputs]\nchannels = 121"), std::string("[inputs]\nchannels = 61"), inputs + "spare = 9",
        outputs + "address = 65536", outputs + "deadline_ms = 0.5", "max_reply_delay_ms = 60001\n" + outputs}) {
    INFO(wrong);
    CHECK(told(wrong + "\n") != "none");
  }
  CHECK(told(outputs + "volts_span = [-10, 10]\nraw_span = [0, 65535]\n") == "none");
  CHECK(told(inputs + "raw_span = [-32768, 32767]\nvolts_span = [-10, 10]\n") == "none");
  REQUIRE(told("max_reply_delay_ms = 20\n" + outputs + "deadline_ms = 30\n") == "none");
  CHECK(read_module_profile(path).max_reply_delay == std::chrono::milliseconds(20));
  CHECK(read_module_profile(path).outputs.deadline == std::chrono::milliseconds(30));
}
