// The driver of the HID scanner against reports that a test makes: its faults, every field at its edges.

#include "devices/tactile/hid_scanner.h"

#include <catch2/catch.hpp>

#include <deque>
#include <functional>
#include <limits>
#include <stdexcept>
#include <vector>

#include "devices/tactile/scan_report.h"
#include "tests/devices/check_codec.h"
#include "tests/devices/fault_of.h"

using namespace std::chrono_literals;
using namespace tactbench::devices;

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

namespace {

RowReport some_row() {
  RowReport report{0xFFFE, 0x01020304, 0xA55A, 15, kStatusAtLimit | kStatusSupply, 0xFEDCBA98, {}};
  for (std::size_t i = 0; i < report.samples.size(); ++i)
    report.samples[i] = static_cast<std::uint16_t>(65535 - 257 * i);
  return report;
}

IdentityReport some_identity() { return {7, 16, 16, 7.62939453125e-5F, "SIM-0123456789AB", "1.0"}; }

template <class Encoded, class Decode>
void every_other_length_is_refused(const Encoded& good, Decode decode) {
  std::vector<std::uint8_t> bytes(good.begin(), good.end());
  bytes.push_back(0);
  CHECK_FALSE(decode(bytes).has_value());
  for (std::size_t size = 0; size < good.size(); ++size) {
    CHECK_FALSE(decode(std::span(good).first(size)).has_value());
  }
}

template <std::size_t N>
void reseal(std::array<std::uint8_t, N>& bytes) {
  const std::uint16_t crc = crc16_ccitt(std::span(bytes).first(N - 2));
  bytes[N - 2] = static_cast<std::uint8_t>(crc & 0xFFU);
  bytes[N - 1] = static_cast<std::uint8_t>(crc >> 8U);
}

}  // namespace

TEST_CASE("scan report: CRC-16/CCITT-FALSE has its published check value") {
  const std::string text = "123456789";
  const std::vector<std::uint8_t> bytes(text.begin(), text.end());
  CHECK(crc16_ccitt(bytes) == 0x29B1);
  CHECK(crc16_ccitt({}) == 0xFFFF);
}

TEST_CASE("scan report: fields are at the offsets of the format, little-endian") {
  const auto row = encode(some_row());
  CHECK(row[0] == 0x01);
  CHECK((row[1] == 0xFE && row[2] == 0xFF));
  CHECK((row[3] == 0x04 && row[6] == 0x01));
  CHECK((row[7] == 0x5A && row[8] == 0xA5));
  CHECK((row[9] == 15 && row[10] == 5));
  CHECK((row[11] == 0x98 && row[14] == 0xFE));
  CHECK((row[15] == 0xFF && row[17] == 0xFE && row[18] == 0xFE));
  CHECK(row[47] == 0);
  const auto command = encode(CommandReport{ScanCommand::kScan, 0x1234});
  CHECK((command[0] == 0x02 && command[1] == 1 && command[2] == 0x34 && command[3] == 0x12 && command[4] == 0));
  const auto identity = encode(some_identity());
  CHECK((identity[0] == 0x03 && identity[1] == 7 && identity[3] == 16 && identity[9] == 'S' && identity[25] == '1'));
  CHECK((identity[5] == 0 && identity[8] == 0x38));  // 7.62939453125e-5 = 2^-13.68: 0x38A00000
}

TEST_CASE("scan report: reports survive encoding and decoding, and every single flipped bit is refused") {
  const auto check = [](const auto& report, auto decode) {
    check_codec(
        encode(report), report, [](const auto& one) { return encode(one); }, decode, Sum::kAll);
  };
  for (const RowReport& row : {some_row(), RowReport{}}) check(row, [](auto bytes) { return decode_row(bytes); });
  for (const IdentityReport& identity : {some_identity(), IdentityReport{}})
    check(identity, [](auto bytes) { return decode_identity(bytes); });
  for (const auto command : {ScanCommand::kScan, ScanCommand::kIdentify})
    check(CommandReport{command, 0xBEEF}, [](auto bytes) { return decode_command(bytes); });
}

TEST_CASE("scan report: any other length is refused") {
  every_other_length_is_refused(encode(some_row()), [](auto bytes) { return decode_row(bytes); });
  every_other_length_is_refused(encode(some_identity()), [](auto bytes) { return decode_identity(bytes); });
  every_other_length_is_refused(encode(CommandReport{}), [](auto bytes) { return decode_command(bytes); });
}

TEST_CASE("scan report: invalid content with a correct CRC is refused") {
  auto row = encode(some_row());
  row[0] = 0x03;  // another report's id
  reseal(row);
  CHECK_FALSE(decode_row(row).has_value());
  auto command = encode(CommandReport{});
  command[1] = 3;  // unknown command
  reseal(command);
  CHECK_FALSE(decode_command(command).has_value());
}

TEST_CASE("scan report: every padding byte must be 0") {
  const auto refused_at = [](auto sound, std::size_t at, auto decode) {
    REQUIRE(decode(sound));
    sound[at] = 1;
    reseal(sound);
    return !decode(sound);
  };
  for (std::size_t at = 47; at < 62; ++at)
    CHECK(refused_at(encode(some_row()), at, [](auto bytes) { return decode_row(bytes).has_value(); }));
  for (std::size_t at = 41; at < 62; ++at)
    CHECK(refused_at(encode(some_identity()), at, [](auto bytes) { return decode_identity(bytes).has_value(); }));
  for (std::size_t at = 4; at < 6; ++at)
    CHECK(refused_at(encode(CommandReport{}), at, [](auto bytes) { return decode_command(bytes).has_value(); }));
  // The bytes next to the padding are values: the last sample, the last letter, the tag.
  RowReport row = some_row();
  row.samples.back() = 0xFFFF;
  CHECK(decode_row(encode(row)) == row);
  const IdentityReport longest{7, 1, 2, 1.0F, "SIXTEEN-LETTERS!", "sixteen-letters?"};
  CHECK(decode_identity(encode(longest)) == longest);
  CHECK(decode_command(encode(CommandReport{ScanCommand::kIdentify, 0xFFFF})).value().tag == 0xFFFF);
}

TEST_CASE("scan report: texts are at most sixteen printable ASCII characters, padded with zeros") {
  const auto written = [](const std::string& serial, const std::string& firmware) {
    try {
      (void)encode(IdentityReport{1, 16, 16, 1.0F, serial, firmware});
      return true;
    } catch (const std::invalid_argument&) {
      return false;
    }
  };
  for (std::size_t at = 0; at < 16; ++at) {
    for (const auto& [character, good] : {std::pair{' ', true}, {'~', true}, {'\x1F', false}, {'\x7F', false}}) {
      std::string text(16, 'm');
      text[at] = character;
      CHECK(written(text, "") == good);
      CHECK(written("", text) == good);
      for (const std::size_t field : {9U, 25U}) {
        auto bytes = encode(IdentityReport{1, 16, 16, 1.0F, std::string(16, 'm'), std::string(16, 'm')});
        bytes[field + at] = static_cast<std::uint8_t>(character);
        reseal(bytes);
        const auto identity = decode_identity(bytes);
        CHECK(identity.has_value() == good);
        if (identity) CHECK((field == 9 ? identity->serial : identity->firmware) == text);
      }
    }
  }
  CHECK_FALSE(written(std::string(17, 'm'), ""));
  CHECK_FALSE(written("", std::string(17, 'm')));
  // Behind the first 0 there are only zeros.
  for (const std::size_t field : {9U, 25U}) {
    auto bytes = encode(IdentityReport{1, 16, 16, 1.0F, std::string(16, 'm'), std::string(16, 'm')});
    for (std::size_t at = 16; at-- > 0;) {
      bytes[field + at] = 0;
      reseal(bytes);
      const auto identity = decode_identity(bytes);
      REQUIRE(identity);
      CHECK((field == 9 ? identity->serial : identity->firmware) == std::string(at, 'm'));
      if (at == 15) continue;
      auto behind = bytes;
      behind[field + 15] = 'x';
      reseal(behind);
      CHECK_FALSE(decode_identity(behind));
    }
  }
}
