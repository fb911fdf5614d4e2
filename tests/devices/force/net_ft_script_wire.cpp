// The driver of the Net F/T against a peer that sends what a test says (scripted_net_ft.h): doubled, late, few, strange
// and wrapping records.
#include <catch2/catch.hpp>

#include "tests/devices/force/scripted_net_ft.h"

using namespace tactbench::devices;
using namespace std::chrono_literals;

TEST_CASE("Net F/T: a hundred records are one request, one more is two") {
  std::uint32_t sample = 0;
  ScriptedBench bench([&](int, std::uint32_t count) {
    std::vector<RdtRecord> records;
    for (std::uint32_t i = 1; i <= count; ++i) records.push_back(record_of(i, ++sample));
    return records;
  });
  CHECK(bench.sensor->read(100).records == 100);
  CHECK(bench.sensor->exchanges() == 1);
  CHECK(bench.sensor->read(101).records == 101);
  CHECK(bench.sensor->exchanges() == 3);
  CHECK(bench.server.asked() == std::vector<std::uint32_t>{100, 100, 1});
}

TEST_CASE("Net F/T: a record that the network doubled counts once, wherever it comes") {
  ScriptedBench bench([](int, std::uint32_t) {
    return std::vector<RdtRecord>{record_of(1, 10), record_of(1, 10), record_of(2, 20), record_of(1, 10),
                                  record_of(3, 30)};
  });
  const ForceReading reading = bench.sensor->read(3);
  CHECK(reading.raw[0] == 20.0);
  CHECK((reading.records == 3 && reading.lost == 0 && reading.reordered == 0));
}

TEST_CASE("Net F/T: the sample counter wraps, and what comes late from before the wrap is old") {
  std::uint32_t sample = 0xFFFFFFFCU;
  ScriptedBench bench([&](int number, std::uint32_t count) {
    std::vector<RdtRecord> records;
    if (number == 1) records.push_back(record_of(9, 0xFFFFFFFDU));  // a straggler
    for (std::uint32_t i = 1; i <= count; ++i) records.push_back(record_of(i, ++sample));
    return records;
  });
  CHECK(bench.sensor->read(2).raw[0] == (0xFFFD + 0xFFFE) / 2.0);
  CHECK(bench.sensor->read(3).raw[0] == (0xFFFF + 0 + 1) / 3.0);
  CHECK(bench.sensor->read(2).raw[0] == 2.5);
}

TEST_CASE("Net F/T: the newest sample is the newest that came, in whatever order") {
  ScriptedBench bench([](int number, std::uint32_t) {
    if (number == 0) return std::vector<RdtRecord>{record_of(1, 5), record_of(3, 7), record_of(2, 6)};
    return std::vector<RdtRecord>{record_of(1, 7), record_of(2, 8), record_of(3, 9)};  // 7 was seen already
  });
  const ForceReading first = bench.sensor->read(3);
  CHECK((first.raw[0] == 6.0 && first.reordered == 1));
  CHECK(bench.sensor->read(2).raw[0] == 8.5);
}

TEST_CASE("Net F/T: samples that are all old mean a stalled sensor, or one that restarted") {
  ScriptedBench bench([](int number, std::uint32_t count) {
    const std::uint32_t first = number == 0 ? 100 : 1;  // then it was switched off and on
    std::vector<RdtRecord> records;
    for (std::uint32_t i = 0; i < count; ++i) records.push_back(record_of(i + 1, first + i));
    return records;
  });
  CHECK(bench.sensor->read(2).records == 2);
  check_fault([&] { (void)bench.sensor->read(2); }, "TB-FORCE-STALL", {}, "101");
  CHECK(bench.clock.now() == 0ns);
  CHECK(bench.sensor->read(2).raw[0] == 1.5);  // the next reading goes with it
}

TEST_CASE("Net F/T: the status of all records is kept, an error with another beside saturation is no saturation") {
  std::uint32_t sample = 0;
  ScriptedBench bench([&](int number, std::uint32_t) {
    // Then saturation and a monitor that tripped, then saturation and temperature.
    const std::vector<std::vector<std::uint32_t>> statuses = {
        {0x80010000U, 0, 0x00010000U}, {0x80030000U}, {0x80020004U}};
    std::vector<RdtRecord> records;
    for (const std::uint32_t status : statuses.at(static_cast<std::size_t>(number))) {
      const auto sequence = static_cast<std::uint32_t>(records.size() + 1);
      records.push_back(record_of(sequence, ++sample, status));
    }
    return records;
  });
  CHECK(bench.sensor->read(3).status == 0x80010000U);
  CHECK(fault_id_of([&] { (void)bench.sensor->read(1); }) == "TB-FORCE-SATURATED");
  CHECK(fault_id_of([&] { (void)bench.sensor->read(1); }) == "TB-FORCE-STATUS");
}

TEST_CASE("Net F/T: a page file is a regular file with something in it, of which a million bytes are read") {
  ScriptedBench bench([](int, std::uint32_t) { return std::vector<RdtRecord>(); });
  const auto check_refused = [&](const std::string& path, const std::string& number) {
    bench.options.page_file = path;
    check_fault([&] { NetFt(bench.options, bench.clock); }, "TB-FORCE-CALIBRATION", {}, number);
  };
  const std::string empty = bench.folder.path("empty.xml"), long_one = bench.folder.path("long.xml");
  std::ofstream(empty) << "";
  std::ofstream(long_one) << std::string(1'000'005, ' ');
  for (const std::string& nothing : {empty, std::string("/proc/self/mem"), std::string("/proc/kmsg")})
    check_refused(nothing, "");  // as root, the last one would be waited for
  check_refused(long_one, "1000000");
}
