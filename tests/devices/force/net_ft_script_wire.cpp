// The driver of the Net F/T against a peer that sends what a test says (scripted_net_ft.h): doubled, late, few, strange
// and wrapping records.
#include <catch2/catch.hpp>
#include <cmath>

#include "tests/devices/force/scripted_net_ft.h"

using namespace tactbench::devices;
using namespace std::chrono_literals;

TEST_CASE("Net F/T: 100 records are one request, 101 are two") {
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

TEST_CASE("Net F/T: duplicate records are counted once, in any order") {
  ScriptedBench bench([](int, std::uint32_t) {
    return std::vector<RdtRecord>{record_of(1, 10), record_of(1, 10), record_of(2, 20), record_of(1, 10),
                                  record_of(3, 30)};
  });
  const ForceReading reading = bench.sensor->read(3);
  CHECK(reading.raw[0] == 20.0);
  CHECK((reading.records == 3 && reading.lost == 0 && reading.reordered == 0));
}

TEST_CASE("Net F/T: the sample counter may wrap, and a late record from before the wrap is ignored") {
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

TEST_CASE("Net F/T: reordered records are used and counted, and a record of an earlier reading is ignored") {
  ScriptedBench bench([](int number, std::uint32_t) {
    if (number == 0) return std::vector<RdtRecord>{record_of(1, 5), record_of(4, 8), record_of(2, 6), record_of(3, 7)};
    return std::vector<RdtRecord>{record_of(1, 8), record_of(2, 9), record_of(3, 10)};  // 8 was seen already
  });
  const ForceReading first = bench.sensor->read(4);
  CHECK((first.raw[0] == 6.5 && first.reordered == 2 && first.lost == 0));
  CHECK(bench.sensor->read(2).raw[0] == 9.5);
}

TEST_CASE("Net F/T: a reading with only old samples is a stall fault, and the next reading succeeds") {
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

TEST_CASE(
    "Net F/T: a reading keeps the status of all its records, and saturation with another error is a status fault") {
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

TEST_CASE("Net F/T: refuses a page file that is empty, not a regular file or longer than 1000000 bytes") {
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

namespace {

using Records = std::vector<RdtRecord>;

// As many good records as were asked for, sample by sample.
struct GoodRecords {
  Records operator()(std::uint32_t count) {
    Records records;
    for (std::uint32_t i = 1; i <= count; ++i) records.push_back(record_of(i, ++sample));
    return records;
  }
  std::uint32_t sample = 0;
};

}  // namespace

TEST_CASE("Net F/T: a request after a failed one uses a new local port, any other keeps the port") {
  GoodRecords good;
  ScriptedBench bench(
      [&](int number, std::uint32_t count) {
        Records records = good(count);
        if (number == 2) records[0].status = 0x80000004U;
        if (number == 5) records.pop_back();
        if (number == 9) records[0].status = ScriptedSensor::kShort;
        if (number == 12) records.clear();
        return records;
      },
      30ms);
  const auto read = [&](int records) { return fault_id_of([&] { (void)bench.sensor->read(records); }); };
  CHECK((read(2) == "none" && read(2) == "none"));                                  // requests 0 and 1
  CHECK((read(2) == "TB-FORCE-STATUS" && read(2) == "none" && read(2) == "none"));  // 2, 3, 4
  CHECK((read(2) == "none" && read(2) == "none" && read(1) == "none"));  // 5 lacks a record, asked for by 6; 7, 8
  CHECK((read(2) == "TB-FORCE-PROTOCOL" && read(2) == "none" && read(1) == "none"));  // 9, 10, 11
  CHECK((read(2) == "TB-FORCE-TIMEOUT" && read(2) == "none"));                        // 12, 13
  const auto ports = bench.server.ports();
  REQUIRE(ports.size() == 14);
  for (std::size_t i = 1; i < ports.size(); ++i) {
    INFO("request " << i);
    const bool anew = i == 3 || i == 6 || i == 10 || i == 13;
    CHECK((ports[i] != ports[i - 1]) == anew);
  }
}

TEST_CASE("Net F/T: missing records are counted, requested again and reported") {
  for (const std::uint32_t few : {0U, 1U, 2U}) {
    GoodRecords good;
    ScriptedBench bench([&](int, std::uint32_t count) { return good(std::min(few, count)); }, 30ms);
    const Nanoseconds limit = 30ms + Nanoseconds(static_cast<Nanoseconds::rep>(1e9 * 9 / 7000.0));
    check_fault([&] { (void)bench.sensor->read(9); }, "TB-FORCE-TIMEOUT", {}, std::to_string(3 * few) + " came");
    using Asked = std::vector<std::uint32_t>;
    CHECK(bench.server.asked() == (few == 0 ? Asked{9} : few == 1 ? Asked{9, 8, 7} : Asked{9, 7, 5}));
    CHECK(bench.clock.now() == (few == 0 ? limit : 3 * limit));
    CHECK(bench.sensor->exchanges() == (few == 0 ? 1 : 3));
    if (few == 0) continue;
    CHECK(bench.sensor->read(1).lost == (few == 1 ? 8U + 7 + 6 : 7U + 5 + 3));
  }
}

TEST_CASE("Net F/T: a sample counter that does not advance is a stall fault, too few new records are a timeout") {
  const auto read_after_51 = [](const Records& second) {
    ScriptedBench bench(
        [&](int number, std::uint32_t) {
          if (number == 0) return Records{record_of(1, 50), record_of(2, 51)};
          return number == 1 ? second : Records();
        },
        30ms);
    CHECK(bench.sensor->read(2).records == 2);
    return fault_id_of([&] { (void)bench.sensor->read(3); });
  };
  const std::string stands = "TB-FORCE-STALL";
  CHECK(read_after_51({record_of(1, 51), record_of(2, 51), record_of(3, 51)}) == stands);
  CHECK(read_after_51({record_of(1, 49), record_of(2, 50), record_of(3, 51)}) == stands);
  CHECK(read_after_51({record_of(1, 51)}) == stands);
  CHECK(read_after_51({record_of(1, 60), record_of(2, 60)}) == stands);
  CHECK(read_after_51({record_of(1, 52), record_of(2, 53), record_of(3, 54)}) == "none");
  const Records late{record_of(1, 51), record_of(2, 50), record_of(3, 52), record_of(4, 53), record_of(5, 54)};
  CHECK(read_after_51(late) == "none");
  // One old record and one new one, then nothing: records are missing.
  CHECK(read_after_51({record_of(1, 51), record_of(2, 52)}) == "TB-FORCE-TIMEOUT");
}

TEST_CASE("Net F/T: wrong datagram lengths, error bits and overload are faults that state their value") {
  struct Told {
    RdtRecord record;
    std::string id, number;
  };
  for (const Told& one :
       std::vector<Told>{{record_of(1, 1, ScriptedSensor::kShort), "TB-FORCE-PROTOCOL", "35 bytes"},
                         {record_of(1, 1, ScriptedSensor::kLonger), "TB-FORCE-PROTOCOL", "37 bytes"},
                         {record_of(1, 1, 0x80020000U), "TB-FORCE-SATURATED", "0x80020000"},
                         {record_of(1, 1, 0x00020000U), "TB-FORCE-SATURATED", "0x00020000"},
                         {record_of(1, 1, 0x80000004U), "TB-FORCE-STATUS", "0x80000004"},
                         {{1, 1, 0, {0, 0, 0, 0, -251'000'000, 0}}, "TB-FORCE-OVERLOAD", "Ty is -251"}}) {
    ScriptedBench bench([&](int, std::uint32_t) { return Records{one.record}; }, 30ms);
    check_fault([&] { (void)bench.sensor->read(1); }, one.id, {}, one.number);
  }
}

TEST_CASE("Net F/T: each axis has its own unit, mean and bias") {
  std::uint32_t sample = 0;
  ScriptedBench bench([&](int number, std::uint32_t count) {
    Records records;
    for (std::uint32_t i = 1; i <= count; ++i) {
      const auto step = static_cast<std::int32_t>(1'000'000 * (number + 1)), odd = static_cast<std::int32_t>(i % 2);
      records.push_back({i, ++sample, 0, {step + odd * 2, 2 * step, 3 * step, step * 4, step * 5, step * 6 + odd * 4}});
    }
    return records;
  });
  NetFtPage page;
  page.product = "scripted";
  page.torque_unit = "Nmm";
  page.counts_per_force = 1e6;
  page.counts_per_torque = 5e5;
  page.range = SixAxes{25, 25, 35, 250, 250, 250};
  std::ofstream(bench.options.page_file) << format_netft_page(page);
  NetFt sensor(bench.options, bench.clock);
  const ForceReading bias = sensor.bias(2);
  CHECK(bias.wrench.force_n[0] == Approx(1.000001).epsilon(1e-12));
  CHECK(bias.wrench.torque_nmm[2] == Approx(12.000004).epsilon(1e-12));
  CHECK(bias.spread_n == Approx(std::sqrt(2.0) * 1e-6));
  const ForceReading reading = sensor.read(4);
  CHECK(reading.raw == SixAxes{2'000'001, 4'000'000, 6'000'000, 8'000'000, 10'000'000, 12'000'002});
  for (std::size_t i = 0; i < 3; ++i) {
    CHECK(reading.wrench.force_n[i] == Approx(1.0 + static_cast<double>(i)).epsilon(1e-9));
    CHECK(reading.wrench.torque_nmm[i] == Approx(8.0 + 2.0 * static_cast<double>(i)).epsilon(1e-9));
  }
}

TEST_CASE("Net F/T: refuses an unusable page, and the range in the bench file overrides the page's") {
  ScriptedBench bench([](int, std::uint32_t) { return Records(); });
  const std::string file = bench.options.page_file;
  const auto opened = [&] { return fault_id_of([&] { NetFt(bench.options, bench.clock); }); };
  CHECK(opened() == "none");
  bench.options.range = SixAxes{1, 2, 3, 4, 5, 6};
  CHECK(NetFt(bench.options, bench.clock).range() == SixAxes{1, 2, 3, 4, 5, 6});
  bench.options.range.reset();
  CHECK(NetFt(bench.options, bench.clock).range() == SixAxes{25, 25, 35, 250, 250, 250});
  bench.options.expected_serial = "FT1";
  CHECK(opened() == "TB-FORCE-SERIAL");
  bench.options.expected_serial.clear();
  NetFtPage page;  // of no range
  page.product = "scripted";
  for (const std::string& text : {format_netft_page(page), std::string("<netft/>"), std::string("x")}) {
    std::ofstream(file) << text;
    CHECK(opened() == "TB-FORCE-CALIBRATION");
  }
  for (const std::string& no_file : {bench.folder.path("absent.xml"), std::string("/dev/zero"), std::string("/dev")}) {
    bench.options.page_file = no_file;
    CHECK(opened() == "TB-FORCE-CALIBRATION");
  }
}
