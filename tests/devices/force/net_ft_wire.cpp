#include "devices/force/net_ft.h"

#include <sys/socket.h>
#include <unistd.h>
#include <catch2/catch.hpp>

#include <atomic>
#include <cmath>
#include <functional>
#include <limits>
#include <mutex>
#include <stdexcept>
#include <thread>

#include "devices/force/rdt_record.h"
#include "devices/force/simulated_net_ft.h"
#include "devices/wire/ends/stream_end.h"
#include "devices/wire/udp_link.h"
#include "tests/devices/fault_of.h"
#include "tests/devices/force/scripted_net_ft.h"
#include "tests/devices/test_chamber.h"
#include "tests/devices/timeouts.h"

using namespace std::chrono_literals;
using namespace tactbench::devices;

namespace {

// The n-th wrench requested (from 0) is the base and n steps on Fx.
class SteppedLoad final : public ForcePort {
 public:
  Wrench wrench() override {
    const std::lock_guard lock(mutex_);
    Wrench wrench = base_;
    wrench.force_n[0] += step * asked++;
    return wrench;
  }
  void force(std::size_t axis, double newtons) {
    const std::lock_guard lock(mutex_);
    base_.force_n[axis] = newtons;
  }
  std::atomic<double> step = 0.0;
  std::atomic<int> asked = 0;

 private:
  std::mutex mutex_;
  Wrench base_{{1.0, -2.0, 3.0}, {10.0, -20.0, 30.0}};
};

struct NetFtRig {
  explicit NetFtRig(SimulatedNetFtFaults faults = {}, Nanoseconds reply_timeout = 20s)
      : server({0, 0, page(), faults}, load) {
    options.host = "127.0.0.1";
    options.port = server.rdt_port();
    options.http_port = server.http_port();
    options.reply_timeout = reply_timeout;
    options.page_timeout = 20s;
    options.origin = Origin::kSimulated;
    sensor = std::make_unique<NetFt>(options, clock);
  }
  static NetFtPage page() {
    NetFtPage page;
    page.product = "simulated Net F/T";
    page.calibration_serial = "FT99901";
    page.firmware = "1.0";
    page.range = SixAxes{25, 25, 35, 250, 250, 250};
    return page;
  }
  ManualClock clock;
  SteppedLoad load;
  SimulatedNetFt server;
  NetFtOptions options;
  std::unique_ptr<NetFt> sensor;
};

}  // namespace

TEST_CASE("Net F/T: a reading is the mean of the requested records, and includes their raw counts") {
  NetFtRig rig;
  rig.load.step = 0.5;
  rig.clock.wait_until(7s);
  const auto reading = rig.sensor->read(5);
  CHECK(reading.records == 5);
  CHECK(reading.wrench.force_n[0] == Approx(2.0));
  CHECK(reading.wrench.force_n[1] == Approx(-2.0));
  CHECK(reading.wrench.force_n[2] == Approx(3.0));
  CHECK(reading.wrench.torque_nmm == std::array<double, 3>{10.0, -20.0, 30.0});
  CHECK(reading.raw == SixAxes{2e6, -2e6, 3e6, 10e6, -20e6, 30e6});
  CHECK(reading.time == 7s);
  CHECK(reading.status == 0);
  CHECK(rig.clock.now() == 7s);
  CHECK(rig.load.asked == 5);  // nothing flows unasked
  CHECK(rig.sensor->exchanges() == 1);
  CHECK(rig.sensor->range() == SixAxes{25, 25, 35, 250, 250, 250});
  CHECK(rig.sensor->calibration_serial() == "FT99901");
  CHECK(rig.sensor->identity().firmware == "1.0");
}

TEST_CASE("Net F/T: a load beyond the set share of the range is a fault, and the next reading succeeds") {
  NetFtRig rig;
  rig.load.force(2, -35.1);
  check_fault([&] { (void)rig.sensor->read(3); }, "TB-FORCE-OVERLOAD", {}, "-35.1 N");
  rig.load.force(2, -34.9);
  CHECK(rig.sensor->read(3).records == 3);
  rig.options.overload_share = 0.5;
  NetFt careful(rig.options, rig.clock);
  CHECK(fault_id_of([&] { (void)careful.read(3); }) == "TB-FORCE-OVERLOAD");
}

TEST_CASE("Net F/T: a host name, a port without a listener and a port in use are faults") {
  NetFtRig rig;
  rig.options.host = "sensor.example";
  CHECK(fault_id_of([&] { NetFt(rig.options, rig.clock); }) == "TB-HTTP-OPEN");
  rig.options.host = "127.0.0.1";
  const auto nobody = bind_loopback(SOCK_DGRAM, 0, "test");
  ::close(nobody.socket);
  rig.options.port = nobody.port;
  NetFt sensor(rig.options, rig.clock);
  CHECK(fault_id_of([&] { (void)sensor.read(1); }) == "TB-UDP-LOST");
  CHECK(fault_id_of([&] {
          SimulatedNetFt({rig.server.rdt_port(), 0, NetFtRig::page(), {}}, rig.load);
        }) == "TB-SIM-LISTEN");
}

// The driver of the Net F/T against a peer that sends what a test says (scripted_net_ft.h): doubled, late, few, strange
// and wrapping records.

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

// The simulated Net F/T by its records: what each request starts and ends, what its counts and counters are, and each
// of its faults.

namespace {

using Counts = std::array<std::int32_t, 6>;

// Number n: n counts of Fx, and fixed ones of the others, at 100 counts a newton and 10 a N*mm.
Wrench numbered(int number) { return {{number / 100.0, -2.0, 0.03}, {4.0, -0.5, 0.6}}; }
Counts counts_of(int number) { return {number, -200, 3, 40, -5, 6}; }

struct NetClient {
  explicit NetClient(std::function<Wrench(int)> told = numbered, SimulatedNetFtFaults faults = {}, double rate = 7000.0)
      : load(std::move(told)), server({0, 0, page_of(rate), std::move(faults)}, load) {}
  static NetFtPage page_of(double rate) {
    NetFtPage page;
    page.product = "simulated";
    page.force_unit = "N";
    page.torque_unit = "Nmm";
    page.counts_per_force = 100;
    page.counts_per_torque = 10;
    page.records_per_second = rate;
    return page;
  }
  void send(RdtCommand command, std::uint32_t count = 0) { link.send(encode(RdtRequest{command, count})); }
  std::optional<RdtRecord> next() { return next_of(link); }
  static std::optional<RdtRecord> next_of(UdpLink& from) {
    std::array<std::uint8_t, 64> bytes{};
    return decode_rdt_record(std::span(bytes).first(from.receive(bytes, kPatient)));
  }
  // The next record is the only one of a new request: nothing else was on its way.
  RdtRecord expect_calm() {
    send(RdtCommand::kStartRealtime, 1);
    const auto record = next();
    REQUIRE(record);
    CHECK(record->rdt_sequence == 1);
    return *record;
  }
  void expect(std::uint32_t sequence, std::uint32_t sample, int number, std::uint32_t status = 0) {
    CHECK(next() == RdtRecord{sequence, sample, status, counts_of(number)});
  }
  NumberedLoad load;
  SimulatedNetFt server;
  UdpLink link{"127.0.0.1", server.rdt_port(), "client"};
};

}  // namespace

TEST_CASE("simulated Net F/T: a request gets the counted records, and the sample counter runs on over all requests") {
  NetClient client;
  int number = 0;
  for (const RdtCommand start : {RdtCommand::kStartRealtime, RdtCommand::kStartBuffered, RdtCommand::kStartMultiUnit}) {
    for (const std::uint32_t count : {1U, 2U, 64U, 65U, 130U}) {
      client.send(start, count);
      for (std::uint32_t i = 1; i <= count; ++i, ++number) {
        client.expect(i, static_cast<std::uint32_t>(number + 1), number);
      }
    }
  }
  CHECK(client.load.asked == number);
  client.send(RdtCommand::kResetLatch);
  client.send(RdtCommand::kStop);
  client.link.send(std::vector<std::uint8_t>{0x12, 0x34, 0, 1, 0, 0, 0, 5});     // no such command
  client.link.send(std::vector<std::uint8_t>{0x12, 0x34, 0, 2, 0, 0, 0});        // too short
  client.link.send(std::vector<std::uint8_t>{0x12, 0x34, 0, 2, 0, 0, 0, 5, 0});  // too long
  client.link.send(std::vector<std::uint8_t>{0x12, 0x35, 0, 2, 0, 0, 0, 5});     // another header
  CHECK(client.expect_calm().counts == counts_of(number));
}

TEST_CASE("simulated Net F/T: counts are rounded and limited to 32 bits, and NaN is the lowest count") {
  constexpr auto kLow = std::numeric_limits<std::int32_t>::min(), kHigh = std::numeric_limits<std::int32_t>::max();
  const auto counted = [](const Wrench& wrench) {
    NetClient client([&](int) { return wrench; });
    return client.expect_calm().counts;
  };
  CHECK(counted({{0.0049, 0.0051, -0.0049}, {-0.051, 0.149, 0.151}}) == Counts{0, 1, 0, -1, 1, 2});
  CHECK(counted({{1e9, -1e9, 0}, {1e12, -1e12, 0}}) == Counts{kHigh, kLow, 0, kHigh, kLow, 0});
  CHECK(counted({{std::nan(""), HUGE_VAL, -HUGE_VAL}, {0, 0, std::nan("")}}) == Counts{kLow, kHigh, kLow, 0, 0, kLow});
  CHECK(counted({{21474836.46, -21474836.47, 0}, {}}) == Counts{kHigh - 1, kLow + 1, 0, 0, 0, 0});
}

TEST_CASE("simulated Net F/T: the bias is the load at that time, and a failed load reading keeps the earlier bias") {
  NetClient client([](int number) {
    if (number == 1 || number == 3) throw std::runtime_error("no physics");
    return numbered(number);
  });
  client.send(RdtCommand::kSetBias);  // number 0
  client.send(RdtCommand::kSetBias);  // fails: the older bias stays
  CHECK(client.expect_calm().counts == Counts{2, 0, 0, 0, 0, 0});
  client.send(RdtCommand::kStartRealtime, 2);  // the first of the two fails
  const auto record = client.next();
  REQUIRE(record);
  CHECK((record->rdt_sequence == 2 && record->counts[0] == 4 && record->ft_sequence == 2));
}

TEST_CASE(
    "simulated Net F/T: an endless stream counts its records, keeps its rate, and ends at a stop or the next start") {
  NetClient client(numbered, {}, 1000.0);
  const auto begin = std::chrono::steady_clock::now();
  client.send(RdtCommand::kStartRealtime);
  for (int number = 0; number < 50; ++number) {
    client.expect(static_cast<std::uint32_t>(number + 1), static_cast<std::uint32_t>(number + 1), number);
  }
  CHECK(std::chrono::steady_clock::now() - begin >= 50ms);
  client.send(RdtCommand::kResetLatch);  // ends nothing
  for (int i = 0; i < 60; ++i) REQUIRE(client.next());
  UdpLink other("127.0.0.1", client.server.rdt_port(), "other");
  other.send(encode(RdtRequest{RdtCommand::kStartBuffered, 0}));  // the last that asked is served, from the beginning
  for (std::uint32_t sequence = 1; sequence <= 5; ++sequence) {
    const auto record = NetClient::next_of(other);
    REQUIRE(record);
    CHECK(record->rdt_sequence == sequence);
  }
  client.link.drain();
  other.send(encode(RdtRequest{RdtCommand::kStartRealtime, 1}));
  auto last = NetClient::next_of(other);
  for (int i = 0; i < 10'000 && last && last->rdt_sequence != 1; ++i) last = NetClient::next_of(other);
  REQUIRE(last);
  CHECK(last->rdt_sequence == 1);
  const int asked = client.load.asked;
  client.expect_calm();
  CHECK(client.load.asked == asked + 1);  // nothing flows any more
  client.send(RdtCommand::kStartRealtime);
  REQUIRE(client.next());
  client.send(RdtCommand::kStop);
  std::array<std::uint8_t, 64> bytes{};
  const auto end = std::chrono::steady_clock::now() + kPatient;
  while (client.link.receive(bytes, 50ms) > 0) REQUIRE(std::chrono::steady_clock::now() < end);
}

TEST_CASE("simulated Net F/T: an endless stream has the record rate of its page") {
  NetClient client([](int) { return Wrench{}; }, {}, 500.0);
  // The ninth record is due after 18 ms, the tenth after 20. On a busy machine one of many streams is on time.
  const auto end = std::chrono::steady_clock::now() + kPatient;
  bool in_time = false;
  while (!in_time && std::chrono::steady_clock::now() < end) {
    client.link.renew();
    const auto begin = std::chrono::steady_clock::now();
    client.send(RdtCommand::kStartRealtime);
    for (int i = 0; i < 9; ++i) REQUIRE(client.next());
    in_time = std::chrono::steady_clock::now() - begin < 20ms;
  }
  CHECK(in_time);
}

TEST_CASE("simulated Net F/T: records due during a pause of more than a second are skipped") {
  NetClient client(
      [](int number) {
        if (number == 3) std::this_thread::sleep_for(1100ms);
        return Wrench{};
      },
      {}, 500.0);
  const auto begin = std::chrono::steady_clock::now();
  client.send(RdtCommand::kStartRealtime);
  for (int i = 0; i < 4; ++i) REQUIRE(client.next());
  for (int i = 0; i < 30; ++i) REQUIRE(client.next());
  CHECK(std::chrono::steady_clock::now() - begin >= 1100ms + 58ms);  // 30 records of 2 ms, not 550 at once
}

TEST_CASE("simulated Net F/T: faults of single records affect the first or a later record as set") {
  struct Came {
    std::uint32_t sequence, sample, status = 0;
  };
  const auto check = [](const SimulatedNetFtFaults& faults, const std::vector<Came>& records) {
    NetClient client(numbered, faults);
    client.send(RdtCommand::kStartRealtime, 4);
    for (const Came& one : records)
      client.expect(one.sequence, one.sample, static_cast<int>(one.sequence) - 1, one.status);
    client.expect_calm();
  };
  check({.drop_record = 0}, {{2, 2}, {3, 3}, {4, 4}});
  check({.drop_record = 2}, {{1, 1}, {2, 2}, {4, 4}});
  check({.late_record = 0}, {{2, 2}, {1, 1}, {3, 3}, {4, 4}});
  check({.late_record = 2}, {{1, 1}, {2, 2}, {4, 4}, {3, 3}});
  check({.late_record = 3}, {{1, 1}, {2, 2}, {3, 3}, {4, 4}});  // with none behind it, it comes in its place
  check({.stall_from_record = 0}, {{1, 0}, {2, 0}, {3, 0}, {4, 0}});
  check({.stall_from_record = 2}, {{1, 1}, {2, 2}, {3, 2}, {4, 2}});
  check({.status_record = 0}, {{1, 1, 0x80020000U}, {2, 2}, {3, 3}, {4, 4}});
  check({.status_record = 2}, {{1, 1}, {2, 2}, {3, 3, 0x80020000U}, {4, 4}});
  check({.status_record = 1, .status_bits = 0x12345678}, {{1, 1}, {2, 2, 0x12345678}, {3, 3}, {4, 4}});
  for (const int at : {0, 2}) {
    NetClient client(numbered, {.silent_after_records = at});
    client.send(RdtCommand::kStartRealtime, 4);
    for (int i = 1; i <= at; ++i) client.expect(static_cast<std::uint32_t>(i), static_cast<std::uint32_t>(i), i - 1);
    while (client.load.asked < 4) std::this_thread::yield();
    std::array<std::uint8_t, 64> none{};
    CHECK(client.link.receive(none, 30ms) == 0);
  }
}

TEST_CASE("simulated Net F/T: an injected fault lasts for a request of up to 64 records") {
  {
    NetClient client(numbered, {.inject = fault_at(1, InjectedFault::kSaturated)});
    client.send(RdtCommand::kStartRealtime, 130);
    for (std::uint32_t i = 1; i <= 130; ++i) {
      client.expect(i, i, static_cast<int>(i) - 1, i > 64 && i <= 128 ? 0x80020000U : 0);
    }
  }
  {
    NetClient client(numbered, {.inject = fault_at(1, InjectedFault::kStale)});
    client.expect_calm();
    client.send(RdtCommand::kStartRealtime, 2);
    for (std::uint32_t i = 1; i <= 2; ++i) client.expect(i, 1, static_cast<int>(i));
    CHECK(client.expect_calm().ft_sequence == 2);
  }
  {
    NetClient client(numbered, {.inject = fault_at(1, InjectedFault::kSilent)});
    client.send(RdtCommand::kStartRealtime, 130);
    for (std::uint32_t i = 1; i <= 66; ++i) client.expect(i <= 64 ? i : i + 64, i, static_cast<int>(i) - 1);
  }
  {
    NetClient client(numbered, {.inject = fault_at(1, InjectedFault::kSilent)}, 500.0);
    client.send(RdtCommand::kStartRealtime);  // an endless stream goes on after it
    for (std::uint32_t i = 1; i <= 4; ++i) client.expect(i < 2 ? i : i + 1, i, static_cast<int>(i) - 1);
  }
  NetClient client(numbered, {.inject = fault_at(1, InjectedFault::kSilent)});
  client.expect_calm();
  client.send(RdtCommand::kStartRealtime, 2);
  CHECK(client.expect_calm().ft_sequence == 2);
  CHECK(client.load.asked == 2);
}
