// The driver of the HID scanner against reports that a test makes: its faults, every field at its edges.
#include "devices/tactile/hid_scanner.h"

#include <catch2/catch.hpp>
#include <deque>
#include <functional>
#include <limits>

#include "tests/devices/fault_of.h"

using namespace tactbench::devices;
using namespace std::chrono_literals;
using Report = std::vector<std::uint8_t>;

namespace {

template <class Message>
Report packed(const Message& message) {
  const auto bytes = encode(message);
  return {bytes.begin(), bytes.end()};
}

// The reports on the wire, and the scripted scanner's answer to a command.
struct Wire {
  std::deque<Report> coming;
  std::vector<CommandReport> commands;
  std::function<std::vector<Report>(const CommandReport&)> answers;
  std::string lost;  // the id of the fault that every write ends in
  std::vector<Nanoseconds> waits;
};

class WireLink final : public ReportLink {
 public:
  explicit WireLink(Wire& wire) : wire_(wire) {}
  void write(std::span<const std::uint8_t> report) override {
    if (!wire_.lost.empty()) throw Fault(wire_.lost, "hidraw", "no such device", "Plug it in.");
    const CommandReport command = decode_command(report).value();
    wire_.commands.push_back(command);
    for (const Report& answer : wire_.answers(command)) wire_.coming.push_back(answer);
  }
  std::size_t read(std::span<std::uint8_t> into, Nanoseconds timeout) override {
    wire_.waits.push_back(timeout);
    if (wire_.coming.empty()) return 0;
    const Report report = wire_.coming.front();
    wire_.coming.pop_front();
    const std::size_t size = std::min(report.size(), into.size());
    std::copy_n(report.begin(), size, into.begin());
    return size;
  }
  std::size_t drain() override {
    const std::size_t size = wire_.coming.size();
    wire_.coming.clear();
    return size;
  }
  [[nodiscard]] std::string description() const override { return "wire W"; }

 private:
  Wire& wire_;
};

// A scanner of 3 rows and 2 columns.
struct Told {
  Told() {
    options.rows = 3;
    options.columns = 2;
    options.model = "model M";
    options.frame_timeout = 20s;
    wire.answers = [this](const CommandReport& command) {
      if (command.command == ScanCommand::kIdentify) {
        identity.tag = command.tag;
        return std::vector<Report>{packed(identity)};
      }
      std::vector<Report> reports;
      auto rows = scan(command.tag);
      for (const RowReport& row : rows) reports.push_back(packed(row));
      return reports;
    };
  }
  HidScanner open() { return {std::make_unique<WireLink>(wire), options, clock}; }
  [[nodiscard]] std::string opened() {
    return fault_id_of([&] { (void)open(); });
  }
  // The fault of a reading of one scan whose rows come so.
  std::string read(std::function<std::vector<RowReport>(std::uint16_t tag)> rows) {
    auto scanner = open();
    scan = std::move(rows);
    return fault_id_of([&] { (void)scanner.read(1); });
  }
  static RowReport row(std::uint16_t tag, int number, std::uint16_t sequence, std::uint32_t frame = 7) {
    RowReport report{sequence, frame, tag, static_cast<std::uint8_t>(number), 0, 1000U + sequence, {}};
    report.samples[0] = static_cast<std::uint16_t>(10 * number);
    report.samples[1] = static_cast<std::uint16_t>(10 * number + 1);
    report.samples[2] = 999;  // beyond the columns
    return report;
  }

  Wire wire;
  ManualClock clock;
  HidScannerOptions options;
  IdentityReport identity{0, 3, 2, 0.5F, "S1", "F1"};
  std::function<std::vector<RowReport>(std::uint16_t tag)> scan = [](std::uint16_t tag) {
    return std::vector{row(tag, 0, 5), row(tag, 1, 6), row(tag, 2, 7)};
  };
};

}  // namespace

TEST_CASE("hid scanner: identity and scans have the values of the reports") {
  Told told;
  auto scanner = told.open();
  const Identity identity = scanner.identity();
  CHECK((identity.role == "tactile scanner" && identity.model == "model M" && identity.serial == "S1"));
  CHECK((identity.firmware == "F1" && identity.origin == Origin::kHardware));
  CHECK(scanner.volts_per_count().value() == 0.5);
  CHECK((scanner.rows() == 3 && scanner.columns() == 2 && scanner.exchanges() == 1));
  std::uint16_t sequence = 0xFFFE;  // wraps in mid-scan
  std::uint32_t frame = 0xFFFFFFFF;
  told.scan = [&](std::uint16_t tag) {
    std::vector<RowReport> rows;
    for (const int number : {2, 0, 1}) rows.push_back(Told::row(tag, number, sequence++, frame));
    rows[1].status = frame == 0 ? kStatusSupply : kStatusAtLimit;
    ++frame;
    return rows;
  };
  const ScanSet set = scanner.read(2);
  CHECK((set.rows == 3 && set.columns == 2 && set.scans == 2 && set.time == 0s));
  CHECK(set.counts == std::vector<std::uint16_t>{0, 1, 10, 11, 20, 21, 0, 1, 10, 11, 20, 21});
  CHECK(set.frame_counters == std::vector<std::uint32_t>{0xFFFFFFFF, 0});
  CHECK(set.status == (kStatusAtLimit | kStatusSupply));
  CHECK(set.device_time_us == 1000 + 0xFFFE);  // of the first report
  CHECK(scanner.exchanges() == 3);
  CHECK(told.wire.commands ==
        std::vector<CommandReport>{{ScanCommand::kIdentify, 1}, {ScanCommand::kScan, 2}, {ScanCommand::kScan, 3}});
  for (const Nanoseconds wait : told.wire.waits) CHECK((wait > 10s && wait <= 20s));
  for (const int none : {0, -1}) {
    const ScanSet empty = scanner.read(none);
    CHECK((empty.counts.empty() && empty.frame_counters.empty() && empty.scans == none && empty.status == 0));
  }
  CHECK(scanner.exchanges() == 3);
}

TEST_CASE("hid scanner: the shape must match the sensor file, and shape and scale must be valid") {
  const auto opened = [](int rows, int columns, IdentityReport identity) {
    Told told;
    told.options.rows = rows;
    told.options.columns = columns;
    told.identity = std::move(identity);
    return told.opened();
  };
  CHECK(opened(3, 2, {0, 3, 2, 0.5F, "", ""}) == "none");
  CHECK(opened(1, 1, {0, 1, 1, 1e-30F, "", ""}) == "none");
  CHECK(opened(255, 16, {0, 255, 16, 1e30F, "", ""}) == "none");
  const std::string geometry = "TB-SCANNER-GEOMETRY";
  CHECK(opened(3, 2, {0, 4, 2, 0.5F, "", ""}) == geometry);
  CHECK(opened(3, 2, {0, 3, 1, 0.5F, "", ""}) == geometry);
  CHECK(opened(0, 2, {0, 0, 2, 0.5F, "", ""}) == geometry);
  CHECK(opened(3, 0, {0, 3, 0, 0.5F, "", ""}) == geometry);
  CHECK(opened(3, 17, {0, 3, 17, 0.5F, "", ""}) == geometry);
  constexpr float kInfinite = std::numeric_limits<float>::infinity();
  for (const float scale : {0.0F, -0.5F, kInfinite, -kInfinite, std::numeric_limits<float>::quiet_NaN()})
    CHECK(opened(3, 2, {0, 3, 2, scale, "", ""}) == geometry);
}

TEST_CASE("hid scanner: another serial number, a lost scanner and a silent one are distinct faults") {
  {
    Told told;
    told.options.expected_serial = "S2";
    CHECK(told.opened() == "TB-SCANNER-SERIAL");
    told.options.expected_serial = "S1";
    CHECK(told.opened() == "none");
  }
  for (const auto& [id, becomes] : {std::pair{"TB-HID-LOST", "TB-SCANNER-LOST"},
                                    {"TB-HID-WRITE", "TB-SCANNER-LOST"},
                                    {"TB-HID-OTHER", "TB-HID-OTHER"}}) {
    Told told;
    auto scanner = told.open();
    told.wire.lost = id;
    CHECK(told.opened() == becomes);
    CHECK(fault_id_of([&] { (void)scanner.read(1); }) == becomes);
    CHECK(scanner.exchanges() == 1);
  }
  Told told;
  told.options.frame_timeout = 250ms;
  told.scan = [](std::uint16_t) { return std::vector<RowReport>{}; };
  auto scanner = told.open();
  CHECK(fault_id_of([&] { (void)scanner.read(1); }) == "TB-SCANNER-TIMEOUT");
  CHECK(told.clock.now() == 250ms);
  told.wire.answers = [](const CommandReport&) { return std::vector<Report>{}; };
  CHECK(told.opened() == "TB-SCANNER-TIMEOUT");
  CHECK(told.clock.now() == 500ms);
}

TEST_CASE("hid scanner: reports with other ids are ignored, of any length, and do not extend the timeout") {
  Told told;
  const auto usual = told.wire.answers;
  const auto among_others = [&](const CommandReport& command) {
    std::vector<Report> reports;
    for (const Report& own : usual(command)) {
      reports.push_back({0x05});
      reports.push_back(Report(kScanReportBytes + 9, std::uint8_t{0x7F}));
      reports.push_back(own);
      reports.push_back({command.command == ScanCommand::kScan ? kIdentityId : kRowId, 1, 2});
    }
    return reports;
  };
  told.wire.answers = among_others;
  auto scanner = told.open();
  CHECK(scanner.read(2).counts == std::vector<std::uint16_t>{0, 1, 10, 11, 20, 21, 0, 1, 10, 11, 20, 21});
  CHECK(told.clock.now() == 0s);
  told.options.frame_timeout = 20ms;
  auto impatient = told.open();
  told.wire.answers = [](const CommandReport&) { return std::vector<Report>(1'000'000, Report{0x05}); };
  CHECK(fault_id_of([&] { (void)impatient.read(1); }) == "TB-SCANNER-TIMEOUT");
  CHECK(told.clock.now() == 20ms);
  CHECK_FALSE(told.wire.coming.empty());
}

TEST_CASE("hid scanner: only an intact answer with the tag of the request is the identity") {
  Told told;
  told.wire.answers = [&](const CommandReport& command) {
    IdentityReport other = told.identity, own = told.identity;
    other.tag = static_cast<std::uint16_t>(command.tag + 1);
    own.tag = command.tag;
    other.serial = "other";
    Report damaged = packed(own), longer = packed(own);
    damaged[20] ^= 1U;
    longer.push_back(0);
    return std::vector<Report>{packed(other), damaged, longer, Report{3}, packed(Told::row(command.tag, 0, 1)),
                               packed(own)};
  };
  CHECK(told.open().identity().serial == "S1");
  CHECK(told.clock.now() == 0s);
}

TEST_CASE("hid scanner: an invalid, repeated, out-of-sequence, foreign or missing row is a corrupt-scan fault") {
  using RowReports = std::vector<RowReport>;
  const auto row = &Told::row;
  struct Placed {
    int number;
    std::uint16_t sequence;
    std::uint32_t frame;
  };
  for (const std::vector<Placed>& wrong : std::vector<std::vector<Placed>>{{{0, 5, 7}, {3, 6, 7}},
                                                                           {{1, 5, 7}, {1, 6, 7}},
                                                                           {{1, 5, 7}, {2, 7, 7}},
                                                                           {{1, 5, 7}, {2, 5, 7}},
                                                                           {{0, 5, 7}, {1, 6, 8}},
                                                                           {{0, 5, 7}, {2, 6, 7}},
                                                                           {{2, 5, 7}}})
    CHECK(Told().read([&](auto tag) {
      RowReports rows;
      for (const Placed& one : wrong) rows.push_back(row(tag, one.number, one.sequence, one.frame));
      return rows;
    }) == "TB-SCANNER-CORRUPT");
  // A late answer to another command is nothing; the rows around it still follow one another.
  CHECK(Told().read([&](auto tag) {
    const auto late = static_cast<std::uint16_t>(tag - 1);
    return RowReports{row(late, 9, 1, 1), row(tag, 0, 5, 7), row(late, 0, 1, 1), row(tag, 1, 6, 7), row(tag, 2, 7, 7)};
  }) == "none");
  Told part;
  auto scanner = part.open();
  part.options.frame_timeout = 20s;
  part.scan = [&](auto tag) { return RowReports{row(tag, 0, 5, 7)}; };
  CHECK(fault_id_of([&] { (void)scanner.read(2); }) == "TB-SCANNER-CORRUPT");
  CHECK(part.clock.now() == 20s);
  for (const std::size_t size : {std::size_t{1}, kScanReportBytes - 1, kScanReportBytes, kScanReportBytes + 1}) {
    Told told;
    auto damaged = told.open();
    told.wire.answers = [&](const CommandReport& command) {
      Report second = packed(row(command.tag, 1, 6, 7));
      second.resize(size);
      if (size == kScanReportBytes) second[30] ^= 1U;
      return std::vector<Report>{packed(row(command.tag, 0, 5, 7)), second};
    };
    CHECK(fault_id_of([&] { (void)damaged.read(1); }) == "TB-SCANNER-CORRUPT");
    CHECK(told.clock.now() == 0s);
  }
}
