// The driver of the Net F/T against a peer that sends what a test says: doubled, late, few, strange and wrapping
// records.
#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <fstream>
#include <functional>
#include <mutex>
#include <thread>

#include "devices/force/net_ft.h"
#include "devices/force/rdt_record.h"
#include "devices/wire/ends/end_at_work.h"
#include "devices/wire/ends/loopback.h"
#include "tests/devices/test_chamber.h"

using namespace tactbench::devices;
using namespace std::chrono_literals;

namespace {

// Answers each request with the records of `script`, called with the number of the request (from 0) and its count.
class ScriptedSensor {
 public:
  using Script = std::function<std::vector<RdtRecord>(int number, std::uint32_t count)>;
  explicit ScriptedSensor(Script script)
      : script_(std::move(script)), bound_(bind_loopback(SOCK_DGRAM, 0, "test")), stop_(::eventfd(0, 0)) {
    thread_ = work_.thread([this] { serve(); });
  }
  ~ScriptedSensor() {
    const std::uint64_t one = 1;
    [[maybe_unused]] const ssize_t written = ::write(stop_, &one, sizeof one);
    thread_.join();
    ::close(stop_);
    ::close(bound_.socket);
  }
  ScriptedSensor(const ScriptedSensor&) = delete;
  ScriptedSensor& operator=(const ScriptedSensor&) = delete;
  [[nodiscard]] int port() const { return bound_.port; }
  // How many records each request has asked for.
  [[nodiscard]] std::vector<std::uint32_t> asked() const {
    const std::lock_guard lock(mutex_);
    return asked_;
  }

 private:
  void serve() {
    for (int number = 0;;) {
      std::vector<pollfd> watched{{stop_, POLLIN, 0}, {bound_.socket, POLLIN, 0}};
      if (work_.wait(watched) < 0) continue;
      if (watched[0].revents != 0) return;
      std::array<std::uint8_t, 64> bytes{};
      sockaddr_in client{};
      socklen_t size = sizeof client;
      auto* const address = reinterpret_cast<sockaddr*>(&client);
      const ssize_t got = ::recvfrom(bound_.socket, bytes.data(), bytes.size(), 0, address, &size);
      const auto request =
          decode_rdt_request(std::span(bytes).first(static_cast<std::size_t>(std::max(got, ssize_t{0}))));
      if (!request) continue;
      {
        const std::lock_guard lock(mutex_);
        asked_.push_back(request->count);
      }
      for (const RdtRecord& record : script_(number++, request->count)) {
        const auto encoded = encode(record);
        const std::size_t length = record.status == kShort ? encoded.size() - 1 : encoded.size();
        ::sendto(bound_.socket, encoded.data(), length, 0, address, size);
      }
    }
  }

 public:
  static constexpr std::uint32_t kShort = 0xFFFFFFFF;  // a status that stands for a torn datagram

 private:
  Script script_;
  BoundSocket bound_;
  int stop_;
  mutable std::mutex mutex_;
  std::vector<std::uint32_t> asked_;
  EndAtWork work_;
  std::thread thread_;
};

// A sensor that has sent `sample` samples so far, the counts of Fx alike.
RdtRecord record_of(std::uint32_t sequence, std::uint32_t sample, std::uint32_t status = 0) {
  return {sequence, sample, status, {static_cast<std::int32_t>(sample & 0xFFFFU), 0, 0, 0, 0, 0}};
}

struct Bench {
  explicit Bench(ScriptedSensor::Script script, Nanoseconds reply_timeout = 20s) : server(std::move(script)) {
    NetFtPage page;
    page.product = "scripted";
    page.range = SixAxes{25, 25, 35, 250, 250, 250};
    options.page_file = folder.path("page.xml");
    std::ofstream(options.page_file) << format_netft_page(page);
    options.host = "127.0.0.1";
    options.port = server.port();
    options.reply_timeout = reply_timeout;
    sensor = std::make_unique<NetFt>(options, clock);
  }
  TemporaryFolder folder;
  ScriptedSensor server;
  NetFtOptions options;
  TurnedClock clock;
  std::unique_ptr<NetFt> sensor;
};

}  // namespace

TEST_CASE("Net F/T: a hundred records are one request, one more is two") {
  std::uint32_t sample = 0;
  Bench bench([&](int, std::uint32_t count) {
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
  Bench bench([](int, std::uint32_t) {
    return std::vector<RdtRecord>{record_of(1, 10), record_of(1, 10), record_of(2, 20), record_of(1, 10),
                                  record_of(3, 30)};
  });
  const ForceReading reading = bench.sensor->read(3);
  CHECK(reading.raw[0] == 20.0);
  CHECK((reading.records == 3 && reading.lost == 0 && reading.reordered == 0));
}

TEST_CASE("Net F/T: the sample counter wraps, and what comes late from before the wrap is old") {
  std::uint32_t sample = 0xFFFFFFFCU;
  Bench bench([&](int number, std::uint32_t count) {
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
  Bench bench([](int number, std::uint32_t) {
    if (number == 0) return std::vector<RdtRecord>{record_of(1, 5), record_of(3, 7), record_of(2, 6)};
    return std::vector<RdtRecord>{record_of(1, 7), record_of(2, 8), record_of(3, 9)};  // 7 was seen already
  });
  const ForceReading first = bench.sensor->read(3);
  CHECK((first.raw[0] == 6.0 && first.reordered == 1));
  CHECK(bench.sensor->read(2).raw[0] == 8.5);
}

TEST_CASE("Net F/T: lost records are requested three times, then reported as a fault") {
  std::uint32_t sample = 0;
  const auto half = [&](int, std::uint32_t count) {
    std::vector<RdtRecord> records;
    for (std::uint32_t i = 1; i <= (count + 1) / 2; ++i) records.push_back(record_of(i, ++sample));
    return records;
  };
  Bench bench(half, 30ms);
  const ForceReading reading = bench.sensor->read(4);  // 2, then 1, then 1
  CHECK((reading.records == 4 && reading.lost == 3));
  CHECK(bench.server.asked() == std::vector<std::uint32_t>{4, 2, 1});
  const auto fault = fault_of([&] { (void)bench.sensor->read(8); });  // 4, 2, 1: one is missing
  REQUIRE(fault);
  CHECK(fault->id() == "TB-FORCE-TIMEOUT");
  CHECK_THAT(fault->what(), Catch::Contains("8 records") && Catch::Contains("7 came"));
  CHECK(bench.server.asked() == std::vector<std::uint32_t>{4, 2, 1, 8, 4, 2});
  CHECK(bench.sensor->read(1).lost == 3 + 4 + 2 + 1);
}

TEST_CASE("Net F/T: samples that are all old mean a stalled sensor, or one that restarted") {
  Bench bench([](int number, std::uint32_t count) {
    const std::uint32_t first = number == 0 ? 100 : 1;  // then it was switched off and on
    std::vector<RdtRecord> records;
    for (std::uint32_t i = 0; i < count; ++i) records.push_back(record_of(i + 1, first + i));
    return records;
  });
  CHECK(bench.sensor->read(2).records == 2);
  const auto fault = fault_of([&] { (void)bench.sensor->read(2); });
  REQUIRE(fault);
  CHECK(fault->id() == "TB-FORCE-STALL");
  CHECK_THAT(fault->what(), Catch::Contains("101"));
  CHECK(bench.clock.now() == 0ns);
  CHECK(bench.sensor->read(2).raw[0] == 1.5);  // the next reading goes with it
}

TEST_CASE("Net F/T: fewer old samples than were asked for, and then silence, is standing still, too") {
  int number = 0;
  Bench bench(
      [&](int, std::uint32_t count) {
        std::vector<RdtRecord> records;
        for (std::uint32_t i = 1; i <= (number == 0 ? count : 1U); ++i) records.push_back(record_of(i, i));
        ++number;
        return records;
      },
      30ms);
  CHECK(bench.sensor->read(3).records == 3);
  CHECK(fault_id_of([&] { (void)bench.sensor->read(3); }) == "TB-FORCE-STALL");
}

TEST_CASE("Net F/T: a datagram that is no record is a fault") {
  Bench bench([](int, std::uint32_t) { return std::vector<RdtRecord>{record_of(1, 1, ScriptedSensor::kShort)}; });
  const auto fault = fault_of([&] { (void)bench.sensor->read(1); });
  REQUIRE(fault);
  CHECK(fault->id() == "TB-FORCE-PROTOCOL");
  CHECK_THAT(fault->what(), Catch::Contains("35 bytes") && Catch::Contains("36"));
}

TEST_CASE("Net F/T: the status of all records is kept, an error with another beside saturation is no saturation") {
  std::uint32_t sample = 0;
  Bench bench([&](int number, std::uint32_t) {
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
  Bench bench([](int, std::uint32_t) { return std::vector<RdtRecord>(); });
  const auto opened = [&](const std::string& path) {
    bench.options.page_file = path;
    const auto fault = fault_of([&] { NetFt(bench.options, bench.clock); });
    return fault ? fault->id() + ": " + fault->what() : std::string();
  };
  const std::string empty = bench.folder.path("empty.xml"), long_one = bench.folder.path("long.xml");
  std::ofstream(empty) << "";
  std::ofstream(long_one) << std::string(1'000'005, ' ');
  using Catch::Contains;
  CHECK_THAT(opened(empty), Contains("TB-FORCE-CALIBRATION") && Contains("empty"));
  for (const char* kernels : {"/proc/self/mem", "/proc/kmsg"})  // as root, the last one would be waited for
    CHECK_THAT(opened(kernels), Contains("TB-FORCE-CALIBRATION") && Contains("empty"));
  CHECK_THAT(opened(long_one), Contains("TB-FORCE-CALIBRATION") && Contains("1000000 bytes"));
}
