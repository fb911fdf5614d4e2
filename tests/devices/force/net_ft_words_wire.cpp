// The driver of the Net F/T against a peer that sends what a test says (scripted_net_ft.h): every word of its
// complaints, what it counts, and from which port it asks.
#include <catch2/catch.hpp>

#include "tests/devices/force/scripted_net_ft.h"

using namespace tactbench::devices;
using namespace std::chrono_literals;

namespace {

using Records = std::vector<RdtRecord>;

// What an action says, with the sensor's address taken out.
template <class Act>
std::string net_words(const ScriptedBench& bench, Act&& act) {
  const auto fault = fault_of(act);
  if (!fault) return "";
  std::string words = fault->id() + ": " + fault->what();
  const std::string peer = "127.0.0.1 port " + std::to_string(bench.server.port()) + " (UDP)";
  const auto at = words.find(peer);
  if (at != std::string::npos) words.replace(at, peer.size(), "S");
  return words;
}

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

TEST_CASE("Net F/T told: a request that ended well is followed from its port, any other from a new one") {
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

TEST_CASE("Net F/T told: what is missing is counted, asked for again, and said") {
  for (const std::uint32_t few : {0U, 1U, 2U}) {
    GoodRecords good;
    ScriptedBench bench([&](int, std::uint32_t count) { return good(std::min(few, count)); }, 30ms);
    const Nanoseconds limit = 30ms + Nanoseconds(static_cast<Nanoseconds::rep>(1e9 * 9 / 7000.0));
    const std::string words = net_words(bench, [&] { (void)bench.sensor->read(9); });
    const auto came = std::to_string(3 * few);
    CHECK(words == "TB-FORCE-TIMEOUT: requesting 9 records from the sensor at S: " + came + " came within 31.2857 ms");
    using Asked = std::vector<std::uint32_t>;
    CHECK(bench.server.asked() == (few == 0 ? Asked{9} : few == 1 ? Asked{9, 8, 7} : Asked{9, 7, 5}));
    CHECK(bench.clock.now() == (few == 0 ? limit : 3 * limit));
    CHECK(bench.sensor->exchanges() == (few == 0 ? 1 : 3));
    if (few == 0) continue;
    CHECK(bench.sensor->read(1).lost == (few == 1 ? 8U + 7 + 6 : 7U + 5 + 3));
  }
  ScriptedBench bench([](int, std::uint32_t) { return Records(); }, 30ms);
  CHECK(net_words(bench, [&] { (void)bench.sensor->read(1); }) ==
        "TB-FORCE-TIMEOUT: requesting 1 record from the sensor at S: 0 came within 30.1429 ms");
}

TEST_CASE("Net F/T told: records behind a newer one are counted one by one") {
  ScriptedBench bench([](int, std::uint32_t) {
    return Records{record_of(1, 11), record_of(4, 14), record_of(2, 12), record_of(3, 13), record_of(5, 15)};
  });
  const ForceReading reading = bench.sensor->read(5);
  CHECK((reading.reordered == 2 && reading.lost == 0 && reading.raw[0] == 13.0));
}

TEST_CASE("Net F/T told: a sample counter that stands, within a reading, between two, and beside silence") {
  const auto said = [](const Records& second) {
    ScriptedBench bench(
        [&](int number, std::uint32_t) {
          if (number == 0) return Records{record_of(1, 50), record_of(2, 51)};
          return number == 1 ? second : Records();
        },
        30ms);
    CHECK(bench.sensor->read(2).records == 2);
    return net_words(bench, [&] { (void)bench.sensor->read(3); });
  };
  const std::string stands =
      "TB-FORCE-STALL: requesting records from the sensor at S: its sample counter does not go beyond ";
  CHECK(said({record_of(1, 51), record_of(2, 51), record_of(3, 51)}) == stands + "51");
  CHECK(said({record_of(1, 49), record_of(2, 50), record_of(3, 51)}) == stands + "51");
  CHECK(said({record_of(1, 51)}) == stands + "51");
  CHECK(said({record_of(1, 60), record_of(2, 60)}) == stands + "60");
  CHECK(said({record_of(1, 52), record_of(2, 53), record_of(3, 54)}).empty());
  CHECK(said({record_of(1, 51), record_of(2, 50), record_of(3, 52), record_of(4, 53), record_of(5, 54)}).empty());
  // One old record and one new one, then nothing: records are missing.
  CHECK(said({record_of(1, 51), record_of(2, 52)})
            .starts_with("TB-FORCE-TIMEOUT: requesting 3 records from the sensor at S: 1 came"));
}

TEST_CASE("Net F/T told: datagrams of another length, errors and overload are said") {
  const auto said = [](const RdtRecord& record) {
    ScriptedBench bench([&](int, std::uint32_t) { return Records{record}; }, 30ms);
    return net_words(bench, [&] { (void)bench.sensor->read(1); });
  };
  CHECK(said(record_of(1, 1, ScriptedSensor::kShort)) ==
        "TB-FORCE-PROTOCOL: a datagram of 35 bytes came from S; a record has 36");
  CHECK(said(record_of(1, 1, ScriptedSensor::kLonger)) ==
        "TB-FORCE-PROTOCOL: a datagram of 37 bytes came from S; a record has 36");
  CHECK(said(record_of(1, 1, 0x80020000U)) ==
        "TB-FORCE-SATURATED: the sensor at S reports status 0x80020000: error summary, saturation or A/D error");
  CHECK(said(record_of(1, 1, 0x00020000U)) ==
        "TB-FORCE-SATURATED: the sensor at S reports status 0x00020000: saturation or A/D error");
  CHECK(said(record_of(1, 1, 0x80000004U)) ==
        "TB-FORCE-STATUS: the sensor at S reports status 0x80000004: error summary, temperature");
  CHECK(said({1, 1, 0, {0, 0, 0, 0, -251'000'000, 0}}) ==
        "TB-FORCE-OVERLOAD: the transducer is overloaded: Ty is -251 N*mm, beyond 250 (100 % of the calibration's "
        "range)");
}

TEST_CASE("Net F/T told: each axis has its unit, its mean and its bias") {
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
  const Wrench bias = sensor.bias(2);
  CHECK(bias.force_n[0] == Approx(1.000001).epsilon(1e-12));
  CHECK(bias.torque_nmm[2] == Approx(12.000004).epsilon(1e-12));
  const ForceReading reading = sensor.read(4);
  CHECK(reading.raw == SixAxes{2'000'001, 4'000'000, 6'000'000, 8'000'000, 10'000'000, 12'000'002});
  for (std::size_t i = 0; i < 3; ++i) {
    CHECK(reading.wrench.force_n[i] == Approx(1.0 + static_cast<double>(i)).epsilon(1e-9));
    CHECK(reading.wrench.torque_nmm[i] == Approx(8.0 + 2.0 * static_cast<double>(i)).epsilon(1e-9));
  }
}

TEST_CASE("Net F/T told: what is wrong with its page is said, and the bench file's range counts before the page's") {
  ScriptedBench bench([](int, std::uint32_t) { return Records(); });
  const std::string file = bench.options.page_file;
  const auto opened = [&] { return net_words(bench, [&] { NetFt(bench.options, bench.clock); }); };
  CHECK(opened().empty());
  bench.options.range = SixAxes{1, 2, 3, 4, 5, 6};
  CHECK(NetFt(bench.options, bench.clock).range() == SixAxes{1, 2, 3, 4, 5, 6});
  bench.options.range.reset();
  CHECK(NetFt(bench.options, bench.clock).range() == SixAxes{25, 25, 35, 250, 250, 250});
  bench.options.expected_serial = "FT1";
  CHECK(opened() ==
        "TB-FORCE-SERIAL: the calibration of transducer 'FT1' was expected, the sensor at S has that of ''");
  bench.options.expected_serial.clear();
  NetFtPage page;
  page.product = "scripted";
  std::ofstream(file) << format_netft_page(page);
  CHECK(opened() == "TB-FORCE-CALIBRATION: the configuration of the sensor at S names no range (cfgmr)");
  std::ofstream(file) << "<netft/>";
  CHECK(opened() == "TB-FORCE-CALIBRATION: reading the configuration " + file + ": prodname is missing");
  std::ofstream(file) << "x";  // a single byte is something to read
  CHECK_THAT(opened(),
             Catch::StartsWith("TB-FORCE-CALIBRATION: reading the configuration " + file + ": it is not XML"));
  std::ofstream(file) << "";
  CHECK_THAT(opened(), Catch::EndsWith("it is not a regular file, is empty or cannot be read"));
  bench.options.page_file = bench.folder.path("absent.xml");
  CHECK(opened() == "TB-FORCE-CALIBRATION: reading the configuration " + bench.options.page_file +
                        ": it is not a regular file, is empty or cannot be read");
}
