// The simulated Net F/T by its records: what each request starts and ends, what its counts and counters are, and each
// of its faults.
#include "devices/force/simulated_net_ft.h"

#include <atomic>
#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <limits>
#include <stdexcept>
#include <thread>

#include "devices/force/rdt_record.h"
#include "devices/wire/udp_link.h"
#include "tests/devices/fault_at.h"
#include "tests/devices/fault_of.h"
#include "tests/devices/timeouts.h"

using namespace tactbench::devices;
using namespace std::chrono_literals;

namespace {

using Counts = std::array<std::int32_t, 6>;

// Gives what `load` says at the n-th request (from 0).
class NumberedLoad final : public ForcePort {
 public:
  explicit NumberedLoad(std::function<Wrench(int)> load) : load_(std::move(load)) {}
  Wrench wrench() override { return load_(asked++); }
  std::atomic<int> asked{0};

 private:
  std::function<Wrench(int)> load_;
};

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
