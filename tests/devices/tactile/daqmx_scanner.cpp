#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <numeric>

#include "devices/tactile/daqmx_scanner.h"
#include "devices/tactile/scan_report.h"
#include "tests/devices/daqmx_card.h"
#include "tests/devices/fault_of.h"
#include "tests/support/paths.h"

using namespace tactbench::devices;
using namespace std::chrono_literals;
using tactbench::tests::FakeDaqmx;
using Levels = FakeDaqmx::Levels;

namespace {

constexpr int kRowsColumns = 16;

int closed_row(const Levels& lines) {
  const auto first = std::find(lines.begin(), lines.end(), 1);
  return first == lines.end() ? -1 : static_cast<int>(first - lines.begin());
}

struct DaqmxRig : DaqmxCard {
  DaqmxRig() { options.library = tactbench::tests::fake_nidaqmx_path(); }
  [[nodiscard]] bool all_open() const {
    return card.lines.size() == kRowsColumns && std::count(card.lines.begin(), card.lines.end(), 0) == kRowsColumns;
  }
  DaqmxScannerOptions options;
};

}  // namespace

TEST_CASE("daqmx scanner: closes one relay at a time, each with its settling time, and opens all at the end") {
  DaqmxRig rig;
  std::vector<std::pair<int, Nanoseconds>> seen;  // row closed when the first sample was taken, and when that was
  rig.card.volts = [&](const Levels& lines, int channel, int sample) {
    if (channel == 0 && sample == 0) seen.emplace_back(closed_row(lines), rig.clock.now());
    return 0.5;
  };
  DaqmxScanner scanner(rig.options, rig.clock);
  REQUIRE(rig.card.writes.size() == 1);
  CHECK(rig.all_open());  // before anything else
  rig.clock.wait_until(1s);
  const auto set = scanner.read(3);
  CHECK(set.time == 1s);
  CHECK(set.device_time_us == 1'000'000);
  REQUIRE(seen.size() == 48);
  for (int i = 0; i < 48; ++i) {
    CHECK(seen[static_cast<std::size_t>(i)] == std::pair{i % 16, Nanoseconds(1s + (i + 1) * 5ms)});
  }
  CHECK(rig.clock.now() == 1s + 48 * 5ms);
  CHECK(scanner.volts_per_count().value() == Approx(10.0 / 65535));
  CHECK((rig.card.terminal == 10083 && rig.card.minimum == -10.0 && rig.card.maximum == 10.0));
  CHECK((rig.card.rate == 10'000 && rig.card.timeout == Approx(0.501) && rig.card.convert_rate == 0));
  REQUIRE(rig.card.writes.size() == 1 + 48 + 1);
  for (const Levels& levels : rig.card.writes) CHECK(std::accumulate(levels.begin(), levels.end(), 0) <= 1);
  CHECK(rig.all_open());
  CHECK(scanner.relay_operations() == std::vector<std::uint64_t>(16, 3));
}

TEST_CASE("daqmx scanner: supports active-low relays, another shape, range, wiring and rates") {
  DaqmxRig rig;
  rig.options.relays_active_low = true;
  rig.options.rows = 3;
  rig.options.columns = 5;
  rig.options.row_lines = "Dev1/port0/line4:6";
  rig.options.column_channels = "Dev1/ai0:2,Dev1/ai8,Dev1/ai9";
  rig.options.range = Volts(2.0);
  rig.options.terminal = DaqmxTerminal::kDifferential;
  rig.options.samples_per_row = 1;
  rig.options.convert_rate_hz = 200'000;
  rig.card.volts = [](const Levels& lines, int channel, int) {
    return std::count(lines.begin(), lines.end(), 0) == 1 ? 0.1 * channel + lines[0] : -1.0;
  };
  {
    DaqmxScanner scanner(rig.options, rig.clock);
    CHECK(rig.card.lines == Levels{1, 1, 1});
    const auto set = scanner.read(1);
    REQUIRE(set.counts.size() == 15);
    CHECK(set.counts[4] * scanner.volts_per_count().value() == Approx(0.4).margin(2e-5));
    CHECK(set.counts[9] * scanner.volts_per_count().value() == Approx(1.4).margin(2e-5));
    CHECK(rig.card.maximum == 2.0);
    CHECK(rig.card.terminal == 10106);
    CHECK(rig.card.convert_rate == 200'000);
  }
  CHECK(rig.card.lines == Levels{1, 1, 1});
}

TEST_CASE("daqmx scanner: a card that disappears during a scan is a lost-scanner fault") {
  DaqmxRig rig;
  DaqmxScanner scanner(rig.options, rig.clock);
  rig.fail("WriteDigitalLines", -200045, 2);
  CHECK(fault_id_of([&] { (void)scanner.read(1); }) == "TB-SCANNER-LOST");
}

TEST_CASE("daqmx scanner: reports the card's identity, and does not switch a card with another serial number") {
  DaqmxRig rig;
  for (const char* serial : {"", "1a2b3c4"}) {
    rig.options.expected_serial = serial;
    const DaqmxScanner scanner(rig.options, rig.clock);
    CHECK(scanner.identity().model == "NI USB-6259");
    CHECK(scanner.identity().serial == "01A2B3C4");
    CHECK(scanner.identity().origin == Origin::kHardware);
  }
  rig.options.expected_serial = "01A2B3C5";
  CHECK(fault_id_of([&] { DaqmxScanner(rig.options, rig.clock); }) == "TB-DAQMX-SERIAL");
  CHECK(rig.card.writes.size() == 2 * 2);
  rig.options.expected_serial.clear();
  rig.card.devices[0].simulated = true;
  CHECK(DaqmxScanner(rig.options, rig.clock).identity().origin == Origin::kSimulated);
}

namespace {

// Two rows, two columns, four samples of each, 0 to 8 V.
struct SmallCard : DaqmxCard {
  SmallCard() {
    card.volts = [this](const FakeDaqmx::Levels& lines, int channel, int sample) {
      const auto closed = std::find(lines.begin(), lines.end(), 1);
      return closed == lines.end() ? 0.0 : volts(static_cast<int>(closed - lines.begin()), channel, sample);
    };
    options.library = tactbench::tests::fake_nidaqmx_path();
    options.rows = options.columns = 2;
    options.row_lines = "Dev1/port0/line0:1";
    options.column_channels = "Dev1/ai0:1";
    options.samples_per_row = 4;
    options.sample_rate_hz = 100;
    options.range = Volts(8.0);
    options.frame_timeout = 200ms;
    options.settle = 3ms;
  }
  [[nodiscard]] std::string opened() {
    return fault_id_of([&] { DaqmxScanner(options, clock); });
  }
  std::function<double(int row, int column, int sample)> volts = [](int, int, int) { return 1.0; };
  DaqmxScannerOptions options;
};

constexpr const char* kGeometry = "TB-SCANNER-GEOMETRY";

}  // namespace

TEST_CASE("daqmx scanner: rows, columns, samples, rate and range must be above 0") {
  const auto said = [](const std::function<void(DaqmxScannerOptions&)>& change) {
    SmallCard rig;
    change(rig.options);
    const std::string words = rig.opened();
    if (words != "none") CHECK(rig.card.writes.empty());  // nothing was switched
    return words;
  };
  CHECK(said([](DaqmxScannerOptions&) {}) == "none");
  for (const int none : {0, -1}) {
    CHECK(said([&](DaqmxScannerOptions& o) { o.rows = none; }) == kGeometry);
    CHECK(said([&](DaqmxScannerOptions& o) { o.columns = none; }) == kGeometry);
    CHECK(said([&](DaqmxScannerOptions& o) { o.samples_per_row = none; }) == kGeometry);
    CHECK(said([&](DaqmxScannerOptions& o) { o.sample_rate_hz = none; }) == kGeometry);
    CHECK(said([&](DaqmxScannerOptions& o) { o.range = Volts(none); }) == kGeometry);
  }
  CHECK(said([](DaqmxScannerOptions& o) {
          o.rows = o.columns = o.samples_per_row = 1;
          o.row_lines = "Dev1/port0/line0";
          o.column_channels = "Dev1/ai0";
          o.sample_rate_hz = 0.5;
          o.range = Volts(0.5);
        }) == "none");
}

TEST_CASE("daqmx scanner: relay lines and input channels must match the rows and columns") {
  SmallCard rig;
  rig.options.rows = 3;
  CHECK(rig.opened() == kGeometry);
  rig.options.rows = 1;
  CHECK(rig.opened() == kGeometry);
  rig.options.rows = 2;
  CHECK(rig.card.writes.empty());
  for (const int columns : {1, 3}) {
    rig.options.columns = columns;
    CHECK(rig.opened() == kGeometry);
  }
  CHECK(rig.card.lines == FakeDaqmx::Levels{0, 0});
  rig.options.columns = 2;
  rig.options.convert_rate_hz = -1;  // the driver chooses
  CHECK(rig.opened() == "none");
  CHECK(rig.card.convert_rate == 0);
  rig.options.convert_rate_hz = 0.5;
  CHECK(rig.opened() == "none");
  CHECK(rig.card.convert_rate == 0.5);
}

TEST_CASE("daqmx scanner: counts are the mean of the samples, per taxel") {
  SmallCard rig;
  rig.volts = [](int row, int column, int sample) {
    return 1.0 + 2.0 * row + 0.5 * column + (sample == 3 ? 0.4 : 0.0);
  };
  DaqmxScanner scanner(rig.options, rig.clock);
  CHECK(rig.called("TaskControl") == 1);  // the inputs are reserved once, so that each row starts quickly
  rig.clock.wait_until(1s + 1'999ns);
  const ScanSet set = scanner.read(2);
  // 65535 counts are 8 V; the mean lies 0.1 V above each first sample.
  const std::vector<std::uint16_t> scan{9011, 13107, 25395, 29491};
  std::vector<std::uint16_t> both = scan;
  both.insert(both.end(), scan.begin(), scan.end());
  CHECK(set.counts == both);
  CHECK((set.rows == 2 && set.columns == 2 && set.scans == 2 && set.status == 0));
  CHECK(set.frame_counters == std::vector<std::uint32_t>{0, 1});
  CHECK((set.time == 1s + 1'999ns && set.device_time_us == 1'000'001));
  CHECK(rig.clock.now() == set.time + 4 * 3ms);
  CHECK(rig.card.timeout == Approx(0.24).epsilon(1e-12));
  CHECK(scanner.exchanges() == 1 + 2 * 2 * 2 + 1);
  CHECK(scanner.relay_operations() == std::vector<std::uint64_t>{2, 2});
  CHECK(scanner.read(1).frame_counters == std::vector<std::uint32_t>{2});
  const auto writes = rig.card.writes.size();
  for (const int none : {0, -1}) {
    const ScanSet empty = scanner.read(none);
    CHECK((empty.counts.empty() && empty.frame_counters.empty() && empty.scans == none));
  }
  CHECK(rig.called("TaskControl") == 1);
  CHECK(rig.card.writes.size() == writes + 2);  // the relays are opened all the same
}

TEST_CASE("daqmx scanner: saturation is judged on each sample at the range limit, and on the mean below zero") {
  SmallCard rig;
  std::array<double, 4> samples{};
  rig.volts = [&](int row, int column, int sample) {
    return row == 1 && column == 0 ? samples[static_cast<std::size_t>(sample)] : 1.0;
  };
  DaqmxScanner scanner(rig.options, rig.clock);
  const auto read = [&](std::array<double, 4> values) {
    samples = values;
    const ScanSet set = scanner.read(1);
    return std::pair{int{set.counts[2]}, int{set.status}};
  };
  const double below = std::nextafter(8.0, 0.0);
  CHECK(read({below, below, below, below}) == std::pair{65535, 0});
  for (std::size_t at = 0; at < 4; ++at) {
    std::array<double, 4> one{};
    one[at] = 8.0;
    CHECK(read(one) == std::pair{16384, int{kStatusAtLimit}});  // 2 V: 16383.75
  }
  CHECK(read({9.0, 9.0, 9.0, 9.0}) == std::pair{65535, int{kStatusAtLimit}});
  // One hundredth of 8 V below zero is noise, and so is more of a single sample.
  CHECK(read({-0.08, -0.08, -0.08, -0.08}) == std::pair{0, 0});
  CHECK(read({-0.2, 0.0, 0.0, -0.12}) == std::pair{0, 0});
  CHECK(read({-0.0801, -0.0801, -0.0801, -0.0801}) == std::pair{0, int{kStatusAtLimit}});
  CHECK(read({0.0, 0.0, 0.0, 0.0}) == std::pair{0, 0});
  CHECK(read({0.000061, 0.000061, 0.000061, 0.000061}) == std::pair{0, 0});  // half a count is 0.00006104 V
  CHECK(read({0.0000611, 0.0000611, 0.0000611, 0.0000611}) == std::pair{1, 0});
}

TEST_CASE("daqmx scanner: each driver error maps to a fault and a time cost, and leaves all relays open") {
  for (const auto& [function, code, id, cost] : {std::tuple{"ReadAnalogF64", -200284, "TB-SCANNER-TIMEOUT", 243ms},
                                                 {"ReadAnalogF64", -200279, "TB-SCANNER-CORRUPT", 3ms},
                                                 {"ReadAnalogF64", -201003, "TB-SCANNER-LOST", 3ms},
                                                 {"ReadAnalogF64", -200324, "TB-SCANNER-LOST", 3ms},
                                                 {"ReadAnalogF64", -999999, "TB-DAQMX-ERROR", 3ms},
                                                 {"ReadAnalogF64", -50103, "TB-DAQMX-ERROR", 3ms},
                                                 {"StartTask", -200284, "TB-SCANNER-TIMEOUT", 3ms},
                                                 {"StartTask", -201003, "TB-SCANNER-LOST", 3ms}}) {
    INFO(function << " " << code);
    SmallCard rig;
    DaqmxScanner scanner(rig.options, rig.clock);
    rig.card.fail_function = function;
    rig.card.fail_code = code;
    const auto stops = rig.called("StopTask");
    check_fault([&] { (void)scanner.read(1); }, id, "tactile scanner");
    CHECK(rig.clock.now() == cost);
    CHECK(rig.card.lines == FakeDaqmx::Levels{0, 0});
    CHECK(rig.called("StopTask") == stops + 1);
    CHECK(rig.card.writes.size() == 1 + 1 + 1);
    rig.card.fail_function.clear();
    CHECK(scanner.read(1).counts.size() == 4);
    CHECK(rig.called("StopTask") == stops + 3);
    CHECK(scanner.relay_operations() == std::vector<std::uint64_t>{2, 1});
  }
  SmallCard rig;
  DaqmxScanner scanner(rig.options, rig.clock);
  rig.card.short_by = 1;
  check_fault([&] { (void)scanner.read(1); }, "TB-SCANNER-CORRUPT", "tactile scanner", "3 came");
  CHECK(rig.clock.now() == 3ms);
  rig.card.short_by = 0;
  rig.volts = [](int, int column, int) { return column == 1 ? std::nan("") : 1.0; };
  CHECK(fault_id_of([&] { (void)scanner.read(1); }) == "TB-SCANNER-CORRUPT");
  CHECK(rig.card.lines == FakeDaqmx::Levels{0, 0});
}
