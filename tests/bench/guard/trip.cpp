#include <fmt/format.h>
#include <unistd.h>
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <system_error>

#include "bench/common/error.h"
#include "bench/common/process_time.h"
#include "bench/guard/dead_man_process.h"
#include "bench/guard/guard.h"
#include "bench/guard/trip.h"
#include "bench/guard/witness.h"
#include "tests/bench/config/bench_text.h"
#include "tests/devices/fault_of.h"
#include "tests/support/process.h"
#include "tests/support/variable.h"

using namespace tactbench;
using namespace tactbench::bench;
using namespace tactbench::tests;

namespace {

std::string refusal(const BenchConfig& config) {
  try {
    refuse_tripped(config);
    return {};
  } catch (const Error& error) {
    CHECK(error.code() == ExitCode::kStopped);
    CHECK_THAT(error.remedy(), Catch::Contains("devices reset"));
    return error.id() + " " + error.what();
  }
}

}  // namespace

TEST_CASE("trip: is stored, blocks commands, keeps its first cause, and ends only by a logged reset") {
  const TemporaryFolder folder;
  const Variable state("XDG_STATE_HOME", folder.path());
  BenchConfig config;
  config.id = "b1";
  const TripFile file(config.id);
  CHECK(file.path() == folder.path("tactbench/b1.trip"));
  CHECK(file.log_path() == folder.path("tactbench/b1.log"));
  CHECK(file.dead_man_path() == folder.path("tactbench/b1.dead-man.json"));
  CHECK_FALSE(file.read());
  CHECK(refusal(config).empty());
  REQUIRE(file.store({"TB-X", "67.0 psi", 12, "ignored"}));
  REQUIRE(file.store({"TB-DEADMAN-FIRED", "later", 12, {}}));
  const auto json = nlohmann::json::parse(read_file(file.path()));
  CHECK((json["id"] == "TB-X" && json["what"] == "67.0 psi" && json["run"] == 12 && json["utc"] != "ignored"));
  const auto trip = TripFile(config.id).read();
  REQUIRE(trip);
  CHECK((trip->id == "TB-X" && trip->what == "67.0 psi" && trip->run == 12));
  CHECK(trip->utc == json["utc"].get<std::string>());
  CHECK_THAT(refusal(config), Catch::StartsWith("TB-BENCH-TRIPPED") && Catch::Contains("67.0 psi"));
  config.in_process = true;
  CHECK(refusal(config).empty());
  file.reset(*trip, "A. Person");
  CHECK_FALSE(std::filesystem::exists(file.path()));
  CHECK_FALSE(file.read());
  REQUIRE(file.store({"TB-Y", "again", 0, {}}));
  file.reset(*file.read(), "Q");
  const std::string log = read_file(file.log_path());
  for (const char* part : {" A. Person", "TB-X", "12", "67.0 psi", " Q", "TB-Y"})
    CHECK(log.find(part) != std::string::npos);
  CHECK(std::count(log.begin(), log.end(), '\n') == 2);
  const std::filesystem::directory_iterator files(folder.path("tactbench"));
  CHECK(std::distance(begin(files), end(files)) == 1);  // no partial one
}

TEST_CASE("trip: a bench id that cannot be a file name gets a trip file, too") {
  const TripFile file("bench 1/left");
  REQUIRE(file.store({"TB-X", "said", 12, {}}));
  REQUIRE(TripFile("bench 1/left").read());
  file.reset(*file.read(), "P");
}

TEST_CASE("trip: a trip file that cannot be read counts as a trip") {
  const TripFile file("b");
  write_file(file.path(), GENERATE("", "{", "[1]", "null"));
  REQUIRE(file.read());
  CHECK(file.read()->id == "TB-TRIP-UNREADABLE");
}

TEST_CASE("trip: missing fields are unknown, a file that cannot be written is an error, an existing file is replaced") {
  const TemporaryFolder folder;
  const TripFile file("lacking");
  write_file(file.path(), R"({"id":"TB-Z"})");
  CHECK((file.read()->id == "TB-Z" && file.read()->utc == "unknown" && file.read()->run == 0));
  std::filesystem::remove(file.path());
  CHECK_THROWS_AS(write_durably(folder.path("no/such/folder"), "x"), std::system_error);
  CHECK_THROWS_WITH(write_durably(folder.path("missing/trip"), "text"),
                    Catch::Contains(fmt::format("{}.{}", folder.path("missing/trip"), getpid())));
  write_durably(folder.path("text"), "one");
  write_durably(folder.path("text"), "two");
  CHECK(read_file(folder.path("text")) == "two");
}

TEST_CASE("state folder: is in XDG_STATE_HOME, or else in the home folder if there is none of the machine") {
  const TemporaryFolder folder;
  {
    const Variable given("XDG_STATE_HOME", folder.path("given"));
    CHECK(state_folder("/no/machine") == folder.path("given/tactbench"));
    CHECK(std::filesystem::is_directory(folder.path("given/tactbench")));
  }
  const Variable none("XDG_STATE_HOME", "");
  const Variable home("HOME", folder.path());
  CHECK(state_folder("/no/machine") == folder.path(".local/state/tactbench"));
}

// Which readings of a pressure instrument can be true, and when it is frozen.

namespace {

constexpr double kNoNumber = std::numeric_limits<double>::quiet_NaN();

PressureWitness seen(const TrueRange& range, const std::vector<double>& readings) {
  PressureWitness witness(range);
  double time_s = 0.0;
  for (const double psi : readings) witness.see(psi, seconds(time_s += 0.5));
  return witness;
}

}  // namespace

TEST_CASE("witness: the possible range follows from span, live zero, safe_psi and uncertainty") {
  struct Row {
    tests::Changes reference;
    double low_psi, high_psi;
  };
  const std::string stated = "reference.expanded_uncertainty_psi";
  const std::string span_v = "reference.span_v", span = "reference.span_psi";
  const Row rows[] = {
      {{{span, "[0, 100]"}, {stated, "0.05"}}, -1.05, 101.05},
      {{{span, "[0, 100]"}, {stated, "0.05"}, {span_v, "[1, 5]"}}, -1.05, 101.05},  // a dead one reads -25
      {{{span, "[0, 20]"}, {stated, "0.05"}, {span_v, "[0.4, 2]"}}, -1.0, 21.0},    // a dead one reads -5
      {{{span, "[0, 20]"}, {stated, "0.05"}, {"limits.safe_psi", "0.2"}}, -0.25, 20.25},
      {{{span, "[0, 100]"}, {stated, "1.5"}}, -2.5, 102.5},
      {{{span, "[0, 100]"}, {stated, "0"}}, -1.25, 101.25},           // 0.25 % of the span where none is stated
      {{{span, "[-14.5, 100]"}, {stated, "0.05"}}, -1.195, 101.195},  // the chamber cannot be below the air outside
      {{{span, "[2, 102]"}, {stated, "0.05"}}, 0.95, 103.05},
  };
  for (const Row& row : rows) {
    const TrueRange range = reference_range(tests::simulated_bench(row.reference));
    CHECK(range.low_psi == Approx(row.low_psi));
    CHECK(range.high_psi == Approx(row.high_psi));
    CHECK((range.holds(range.low_psi) && range.holds(0.96) && range.holds(range.high_psi)));
    CHECK_FALSE((range.holds(std::nextafter(range.low_psi, -1e9)) || range.holds(std::nextafter(range.high_psi, 1e9))));
    CHECK_FALSE((range.holds(kNoNumber) || range.holds(-std::numeric_limits<double>::infinity())));
  }
  const BenchConfig sound = tests::simulated_bench({});
  const double regulator_psi = sound.regulator.feedback_span.high.value();
  CHECK(feedback_range(sound).low_psi == Approx(-0.0125 * regulator_psi));
  // A gauge's scale is no span.
  const TrueRange gauge = reference_range(
      tests::simulated_bench({{"reference.gauge.unit", "2"}, {"reference.gauge.address", "7"}, {stated, "0.05"}}));
  CHECK(gauge.low_psi == Approx(-1.0));
  CHECK(std::isinf(gauge.high_psi));
}

TEST_CASE("witness: an impossible reading is doubted immediately, and its duration is measured") {
  const TrueRange range{-1.0, 100.0};
  CHECK(seen(range, {0.0}).doubt().empty());
  CHECK_FALSE(seen(range, {}).ever_possible());
  for (const double bad : {-1.1, 100.1, kNoNumber}) {
    const PressureWitness once = seen(range, {0.0, bad});
    CHECK_FALSE((once.possible() || once.doubt().empty()));
    CHECK((once.ever_possible() && once.impossible_s() == 0.0));
    CHECK(seen(range, {bad, bad, bad}).impossible_s() == 1.0);
    CHECK_FALSE(seen(range, {bad, bad}).ever_possible());
    CHECK(seen(range, {bad, bad, 0.0, bad}).impossible_s() == 0.0);
    CHECK(seen(range, {bad, bad, 0.0}).doubt().empty());
  }
}

TEST_CASE("witness: an instrument that stays constant while the other moves by more than 5 psi is doubted") {
  const auto still = [](const std::vector<std::pair<double, double>>& readings, bool second) {
    PressureWitness first({}), other({-1.0, 100.0});
    double time_s = 0.0;
    for (const auto& [one, two] : readings) {  // as in a run: one is read, then the other
      first.see(one, seconds(time_s += 0.5));
      other.see_other(first);
      other.see(two, seconds(time_s));
      first.see_other(other);
    }
    return !(second ? other : first).doubt().empty();
  };
  CHECK(still({{0, 40}, {0, 20}, {0, 0}}, false));            // without supply: 0 V
  CHECK(still({{40, 40}, {0, 40}, {0, 39}, {0, 0}}, false));  // the supply fails under pressure
  CHECK(still({{40, 40}, {20, 40}, {0, 40}}, true));          // frozen
  CHECK(still({{0, 0}, {0, 0}, {6, 0}}, true));
  CHECK_FALSE(still({{0, 0}, {0, 0}, {5, 0}}, true));
  // Both empty from one reading to the next, and clipped at 0 from then on.
  CHECK_FALSE(still({{40, 40}, {0, 0}, {0, 0}, {0, 0}}, false));
  CHECK_FALSE(still({{40, 40}, {0, 0}, {0, 0}, {0, 0}}, true));
  CHECK_FALSE(still({{40, 40}, {20, 40}, {0, 40}, {0, 1}}, true));  // a slow gauge that follows in the end
  CHECK_FALSE(still({{0, 40}, {0, -50}, {0, -50}}, false));         // what cannot be true shows nothing
}

TEST_CASE("witness: an impossible reading prevents a pressure rise, and ends the run if it persists") {
  devices::ManualClock clock;
  GuardLimits limits = guard_limits(tests::simulated_bench({}));
  Guard guard(limits, clock);
  guard.arm();
  guard.source_armed();
  const auto see = [&](double feedback, double reference) {
    clock.wait_until(clock.now() + seconds(0.25));
    guard.note_feedback(devices::Psi(feedback), clock.now());
    guard.note_reference(devices::Psi(reference), clock.now());
  };
  const auto rise = [&] { return devices::fault_id_of([&] { guard.check_pressure(devices::Psi(1.0)); }); };
  const auto goes_on = [&] { return devices::fault_id_of([&] { guard.check_witnesses(); }); };
  see(0.0, -25.0);  // from the beginning: no leniency
  CHECK(rise() == "TB-CHAMBER-WITNESS");
  CHECK(goes_on() == "none");
  see(0.0, 0.0);
  CHECK(rise() == "none");
  for (int i = 0; i < 4; ++i) {
    see(-25.0, 0.0);  // a shock on a line may last less than disagreement_s, 1 s
    CHECK(rise() == "none");
    CHECK(goes_on() == "none");
  }
  see(-25.0, 0.0);
  CHECK(rise() == "TB-CHAMBER-WITNESS");
  CHECK(goes_on() == "TB-CHAMBER-WITNESS");
  CHECK(devices::fault_id_of([&] { guard.check_pressure(devices::Psi(0.0)); }) == "none");  // down is always open
  see(0.0, 0.0);
  CHECK((rise() == "none" && goes_on() == "none"));
  for (int i = 0; i < 5; ++i) see(0.0, -25.0);
  CHECK(goes_on() == "TB-CHAMBER-WITNESS");
}

// How the sequencer evaluates its dead-man's answers. The processes themselves: dead_man_realtime.cpp.

namespace {

const devices::Nanoseconds kTimeout = seconds(0.4);

std::string lost_id(const DeadManReports& reports) { return reports.lost() ? reports.lost()->id : ""; }

}  // namespace

TEST_CASE("dead-man reports: an answer later than the timeout makes it silent permanently") {
  DeadManReports reports(kTimeout, true);
  reports.judge(seconds(9.0));  // nothing was asked
  reports.asked(seconds(10.0));
  reports.asked(seconds(10.2));  // the oldest counts
  reports.judge(seconds(10.4));
  CHECK(lost_id(reports) == "");
  reports.heard("fed");
  reports.judge(seconds(20.0));
  CHECK(lost_id(reports) == "");
  reports.asked(seconds(30.0));
  reports.excuse();
  reports.judge(seconds(31.0));
  CHECK(lost_id(reports) == "");
  reports.asked(seconds(40.0));
  reports.judge(seconds(40.4));
  CHECK(lost_id(reports) == "");
  reports.judge(seconds(40.4) + devices::Nanoseconds(1));
  REQUIRE(lost_id(reports) == "TB-DEADMAN-SILENT");
  CHECK_THAT(reports.lost()->what, Catch::Contains(" 0.40 s") && Catch::Contains(" 0.4 s"));
  reports.heard("fed");
  CHECK(lost_id(reports) == "TB-DEADMAN-SILENT");
  CHECK_FALSE(reports.fired());
}

TEST_CASE("dead-man reports: blind is reported once, and ends the run at the second report if configured") {
  const bool ends = GENERATE(true, false);
  DeadManReports reports(kTimeout, ends);
  reports.heard("sees");
  CHECK(reports.take_notices().empty());  // it saw before
  reports.heard("blind: nobody answers at 192.168.0.10:502");
  CHECK(lost_id(reports) == "");
  auto news = reports.take_notices();
  REQUIRE(news.size() == 1);
  CHECK(news[0].id == "TB-DEADMAN-BLIND");
  CHECK_THAT(news[0].what, Catch::Contains("nobody answers at 192.168.0.10:502"));
  reports.heard("sees");
  reports.heard("sees");
  news = reports.take_notices();
  REQUIRE(news.size() == 1);
  CHECK(news[0].id == "");
  reports.heard("busy: for 20 ms");
  news = reports.take_notices();
  REQUIRE(news.size() == 1);
  CHECK((news[0].id == "TB-MODBUS-BUSY" && news[0].what == "for 20 ms"));
  CHECK(lost_id(reports) == "");
  reports.heard("blind: a");  // not in a row with the first
  CHECK(lost_id(reports) == "");
  reports.heard("blind: b");
  CHECK(lost_id(reports) == (ends ? "TB-DEADMAN-BLIND" : ""));
  if (ends) CHECK_THAT(reports.lost()->what, Catch::Contains("b") && Catch::Contains("2 "));
  reports.heard("blind: c");
  CHECK(reports.take_notices().size() == 1);
  reports.ended();
  CHECK(lost_id(reports) == (ends ? "TB-DEADMAN-BLIND" : "TB-DEADMAN-ENDED"));  // the first cause stays
  reports.heard("something else");
  CHECK_FALSE(reports.fired());
}

TEST_CASE("dead-man reports: a dead-man that ends by itself is lost, one that ends after firing is not") {
  DeadManReports gone(kTimeout, true), fired(kTimeout, true);
  gone.ended();
  CHECK(lost_id(gone) == "TB-DEADMAN-ENDED");
  fired.heard("fired");
  fired.ended();
  fired.asked(seconds(1.0));
  fired.judge(seconds(9.0));
  CHECK(fired.fired());
  CHECK(lost_id(fired) == "");
}
