// `devices check` and related verbs on the simulated rig, and their messages when something is absent or wrong.

#include <fmt/format.h>
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <filesystem>
#include <sstream>
#include <string>
#include <vector>

#include "analysis/compensate/compensator.h"
#include "bench/common/error.h"
#include "bench/config/config_calibration.h"
#include "bench/instruments/check.h"
#include "bench/instruments/live.h"
#include "bench/instruments/reference_calibration.h"
#include "bench/reporting/evaluation.h"
#include "bench/rig/rig.h"
#include "bench/simulation/plant.h"
#include "devices/device.h"
#include "tests/bench/cli/verb_here.h"
#include "tests/support/paths.h"
#include "tests/support/process.h"
#include "tests/support/refusal.h"
#include "tests/support/small_run.h"
#include "tests/support/text.h"

using namespace tactbench;
using namespace tactbench::tests;
using State = bench::DeviceCheck::State;

namespace {

const char* const kSurroundings =
    "[{quantity = 'temperature_c', unit = 9, address = 7, type = 'i16', raw_span = [-1000, 1000], span_c = [-100, "
    "100], model = 'T 1', serial = '77'}, {quantity = 'supply_bar', unit = 9, address = 20, type = 'f32'}]";

// With these faults of the simulation.
std::vector<bench::DeviceCheck> check(
    const std::vector<sequences::Override>& overrides,
    const std::vector<std::pair<bench::FaultKind, std::optional<double>>>& faults = {}, bool independent = true) {
  bench::BenchConfig config = small_request(overrides).bench;
  config.reference_independent = independent;
  bench::Rig rig(config);
  for (const auto& [kind, value] : faults) rig.plant()->inject(kind, value, 0);
  return bench::check_devices(rig, "2026-06-01");
}

const bench::DeviceCheck& of(const std::vector<bench::DeviceCheck>& checks, const std::string& role) {
  for (const bench::DeviceCheck& each : checks) {
    if (each.role == role) return each;
  }
  throw std::runtime_error("no check of " + role);
}

bool says(const bench::DeviceCheck& device, const std::string& text) {
  for (const std::string& note : device.notes) {
    if (note.find(text) != std::string::npos) return true;
  }
  return false;
}

std::string answers_of_host(const std::string& host) {
  for (const bench::ScanEntry& entry : bench::scan_devices({host}))
    if (entry.kind == "Modbus TCP") return entry.where + ": " + entry.what;
  return "(none)";
}

}  // namespace

TEST_CASE("devices check: each instrument of the simulated rig is ok, identified and near zero, and nothing is armed") {
  bench::Rig rig(small_request({{"reference.due", "\"2026-05-31\""}}).bench);
  const auto checks = bench::check_devices(rig, "2026-06-01");
  CHECK(checks.size() == 6);
  for (const bench::DeviceCheck& device : checks) {
    INFO(device.role << " " << device.remedy);
    const bool overdue = device.role == "pressure reference";
    CHECK(device.state == (overdue ? State::kWarning : State::kOk));
    CHECK_FALSE(device.found.empty());
    CHECK_FALSE(device.reading.empty());
    CHECK(device.remedy.empty() != overdue);
    CHECK_THAT(device.found, Catch::Contains("simulated"));
  }
  CHECK(says(of(checks, "pressure reference"), "2026-05-31"));
  CHECK_THAT(of(checks, "stage").found, Catch::Contains("5082"));
  CHECK_FALSE(rig.source().armed());
  CHECK_FALSE(rig.stage()->armed());
}

TEST_CASE("devices check: a silent device is absent, another serial or model is wrong, the others are still checked") {
  const auto silent =
      check({{"simulation.wire_faults.module_silent_after_requests", "0"}, {"module.response_timeout_ms", "300"}});
  CHECK(of(silent, "analog module").state == State::kAbsent);
  CHECK(of(silent, "regulator").state == State::kAbsent);
  CHECK(of(silent, "tactile scanner").state == State::kOk);
  CHECK_FALSE(of(silent, "analog module").remedy.empty());

  const auto serial = check({{"scanner.serial", "\"OTHER\""}, {"force.serial", "\"FT-7\""}});
  CHECK(of(serial, "tactile scanner").state == State::kWrong);
  CHECK(says(of(serial, "tactile scanner"), "OTHER"));
  CHECK(of(serial, "force sensor").state == State::kOk);  // the simulated sensor takes the serial of the file

  const auto model = check({{"stage.z.low_mm", "1"}, {"stage.x.device_id", "5082"}, {"stage.x.high_mm", "20"}});
  CHECK(of(model, "stage").state == State::kOk);  // the simulated chain is made of the models in the file

  const auto others = check({{"scanner.kind", "frame-source"}, {"force.kind", "digital"}});
  CHECK(of(others, "tactile scanner").state == State::kOk);
  CHECK(of(others, "force sensor").state == State::kOk);
  CHECK_THAT(of(others, "force sensor").found, Catch::Contains("SIMFT2"));
}

TEST_CASE("devices check: a chamber away from zero and an overdue stage are reported with their values") {
  const auto checks = check({{"reference.correction.reading_psi", "[0, 60]"},
                             {"reference.correction.correction_psi", "[0.5, 3.0]"},
                             {"reference.correction.expanded_uncertainty_psi", "[0.02, 0.05]"},
                             {"stage.due", "\"2026-05-31\""},
                             {"environment.sensor", kSurroundings},
                             {"simulation.temperature_c", "25.5"}},
                            {{bench::FaultKind::kFeedbackOffset, 2.5}, {bench::FaultKind::kReferenceOffset, -3.0}});
  CHECK(of(checks, "regulator").state == State::kWrong);
  CHECK(says(of(checks, "regulator"), "2.53 psi"));
  const bench::DeviceCheck& reference = of(checks, "pressure reference");
  CHECK(reference.state == State::kWrong);
  CHECK(says(reference, "-2.51 psi"));
  CHECK((says(reference, "0.500 psi") && says(reference, "0.020 psi")));  // its correction, and U of that
  CHECK_FALSE(reference.remedy.empty());
  CHECK(of(checks, "stage").state == State::kWarning);
  CHECK(says(of(checks, "stage"), "2026-05-31"));
  CHECK_THAT(of(checks, "temperature_c sensor").reading, Catch::Contains("25.50"));
  CHECK_THAT(of(checks, "temperature_c sensor").found, Catch::Contains("77"));
  CHECK_THAT(of(checks, "supply_bar sensor").reading, Catch::Contains("8.00"));
}

TEST_CASE(
    "devices check: instruments that refuse or are silent are reported with their fault, the others are checked") {
  const auto checks = check({{"scanner.frame_timeout_ms", "200"}},
                            {{bench::FaultKind::kScannerSilent, {}},
                             {bench::FaultKind::kModuleException, {}},
                             {bench::FaultKind::kStageSilent, {}}},
                            false);
  CHECK(of(checks, "analog module").state == State::kWrong);
  CHECK(says(of(checks, "analog module"), "TB-MODBUS-EXCEPTION"));
  CHECK(of(checks, "tactile scanner").state == State::kAbsent);
  CHECK(says(of(checks, "tactile scanner"), "TB-SCANNER-TIMEOUT"));
  CHECK(of(checks, "stage").state == State::kAbsent);
  for (const char* axis : {"axis x", "axis y", "axis z"}) CHECK(says(of(checks, "stage"), axis));
  CHECK(of(checks, "force sensor").state == State::kOk);
}

TEST_CASE("live: prints the requested number of readings, each with all instruments, in the selected unit") {
  const auto watched = [](bool terminal, analysis::PressureUnit unit) {
    bench::WatchOptions options;
    options.interval_s = 0.01;
    options.count = 2;
    options.terminal = terminal;
    options.unit = unit;
    return printed_by([&] {
      bench::watch_devices(small_request({{"environment.sensor", kSurroundings},
                                          {"simulation.defect", "[{kind = 'saturated', row = 2, column = 5}]"}})
                               .bench,
                           options);
    });
  };
  const auto count = [](const std::string& text, const std::string& part) {
    int found = 0;
    for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++found;
    return found;
  };
  const std::string lines = watched(false, analysis::PressureUnit::kPsi);
  CHECK(count(lines, " psi") == 4);  // feedback and reference
  CHECK((count(lines, "temperature_c 23.00") == 2 && count(lines, "supply_bar 8.00") == 2));
  CHECK(count(lines, "z 0.0000 mm") == 2);
  CHECK(count(lines, "\x1b") == 0);
  const std::string screens = watched(true, analysis::PressureUnit::kKilopascal);
  CHECK(count(screens, "\x1b[H") == 2);
  CHECK((count(screens, " kPa") == 4 && count(screens, " psi") == 0));
  CHECK(count(screens, "\n") >= count(lines, "\n") + 2 * 16);  // and a picture of 16 rows
}

TEST_CASE("frame source: a run through it gives the same frames as a run through HID reports") {
  const TemporaryFolder folder;
  db::RunStore hid = db::RunStore::open(folder.path("hid.db"), db::Durability::kNormal);
  db::RunStore tcp = db::RunStore::open(folder.path("tcp.db"), db::Durability::kNormal);
  const auto one = run_small(small_request(), hid);
  const auto two = run_small(small_request({{"scanner.kind", "frame-source"}}), tcp);
  if (two.error) FAIL(two.error->what());
  const auto first = hid.frames(one.run);
  const auto second = tcp.frames(two.run);
  REQUIRE(first.size() == second.size());
  for (std::size_t i = 0; i < first.size(); ++i) CHECK(first[i].counts == second[i].counts);
}

TEST_CASE("simulated contact: force is zero above the surface, and stiffness times depth below it") {
  bench::Rig rig(small_request({{"simulation.contact.surface_z_mm", "20"},
                                {"simulation.contact.stiffness_n_per_mm", "10"},
                                {"simulation.contact.stiffening_n_per_mm2", "0"},
                                {"simulation.contact.friction_share", "0"},
                                {"simulation.contact.relaxation_share", "0"}})
                     .bench);
  devices::Stage& stage = *rig.stage();
  devices::ForceSensor& force = rig.open_force();
  stage.arm();
  stage.home(devices::Axis::kZ);
  stage.start_move_to(devices::Axis::kZ, devices::Millimetres(19.9), std::nullopt);
  CHECK(stage.wait(devices::Axis::kZ).value() == Approx(19.9).margin(0.001));
  CHECK(force.read(20).wrench.force_n[2] == Approx(0.0).margin(0.02));
  stage.start_move_to(devices::Axis::kZ, devices::Millimetres(21.0), std::nullopt);
  stage.wait(devices::Axis::kZ);
  CHECK(force.read(20).wrench.force_n[2] == Approx(-10.0).margin(0.02));
  CHECK(stage.halt());
}

TEST_CASE("reference calibration: corrections by level, residuals, and U from gauge, hysteresis and resolution") {
  const std::vector<bench::GaugePoint> points = {{0.0, true, 0.0, 0.1},     {30.0, true, 30.0, 30.2},
                                                 {60.0, true, 60.0, 60.5},  {60.0, false, 60.0, 60.5},
                                                 {30.0, false, 30.0, 30.4}, {0.0, false, 0.0, 0.1}};
  const auto result = bench::calibrate_reference(points, 0.06, 0.1);
  CHECK(result.correction.reading_psi == std::vector<double>{0.0, 30.0, 60.0});
  CHECK(result.correction.correction_psi[1] == Approx(0.3));
  CHECK(result.correction.corrected(devices::Psi(60.0)).value() == Approx(60.5));
  CHECK(result.hysteresis_psi == Approx(0.2));
  CHECK(result.largest_residual_psi == Approx(0.1));
  // u² = 0.03² + 0.1²/3 + 0.1²/12 at 30 psi.
  CHECK(result.correction.expanded_uncertainty_psi[1] == Approx(2.0 * std::sqrt(0.0009 + 0.01 / 3.0 + 0.01 / 12.0)));
  CHECK(result.correction.expanded_uncertainty_psi[0] == Approx(2.0 * std::sqrt(0.0009 + 0.01 / 12.0)));
  CHECK_THROWS_AS(bench::calibrate_reference({points[0]}, 0.06, 0.1), std::invalid_argument);
  for (const double second : {4.0, 5.0}) {
    try {
      bench::calibrate_reference({{0, true, 5.0, 0}, {10, true, second, 9}}, 0.06, 0.1);
      FAIL("readings of 5 psi and " << second << " psi");
    } catch (const bench::Error& error) {
      CHECK(error.id() == "TB-REFERENCE-FLAT");
      CHECK_THAT(error.what(),
                 Catch::Contains("5.000 psi") && Catch::Contains(second < 5.0 ? "4.000 psi" : "5.000 psi"));
    }
  }
}

TEST_CASE("reference calibration: the file has the readings in both directions, and the values for the bench file") {
  const std::vector<bench::GaugePoint> points = {
      {0.0, true, 0.1, 0.2}, {30.0, true, 30.0, 30.3}, {30.0, false, 30.2, 30.4}, {0.0, false, 0.0, 0.2}};
  const bench::ReferenceCalibration calibration = bench::calibrate_reference(points, 0.06, 0.1);
  CHECK(calibration.hysteresis_psi == Approx(0.1));
  CHECK(calibration.largest_residual_psi == Approx(0.3 - 0.25 + 0.1 * 0.1 / 30.05));  // beside a straight line
  const std::string file = correction_toml(calibration, points, "head");
  for (const char* line :
       {"\nschema = 1\n", "\nreading_psi = [0.0500, 30.1000]\n", "\ncorrection_psi = [0.1500, 0.2500]\n",
        "\nexpanded_uncertainty_psi = [0.1013, 0.1013]\n", "\ncoverage_factor = 2.0\n"})
    CHECK(file.find(line) != std::string::npos);
  const std::string readings = file.substr(0, file.find("\nschema"));
  CHECK(std::ranges::count(readings, '\n') >= 5);  // a line for each, behind the head
  CHECK_THAT(readings, Catch::StartsWith("# head\n") && Catch::Contains("30.2000"));
}

TEST_CASE("calibration text: the stated values are printed, overdue from the day after the due date") {
  const auto words = [](const std::string& json, const std::string& day) {
    return bench::calibration_text(analysis::calibration_of({"force sensor", "M", "1", "", "hardware", json}), day,
                                   analysis::PressureUnit::kPsi);
  };
  const char* stated =
      R"({"certificate":"C-1","calibrated":"2025-06-01","due":"2026-06-01","expanded_uncertainty_n":0.1})";
  const std::string valid = words(stated, "2026-06-01");
  CHECK_THAT(valid, Catch::Contains("C-1") && Catch::Contains("2025-06-01") && Catch::Contains("2026-06-01") &&
                        Catch::Contains("0.1 N"));
  CHECK_THAT(valid, !Catch::Contains("OVERDUE"));
  CHECK_THAT(words(stated, "2026-06-02"), Catch::Contains("OVERDUE") && Catch::Contains("2026-06-01"));
  CHECK_THAT(words("{}", "2026-06-01"), !Catch::Contains("OVERDUE"));
  CHECK_THAT(words(R"({"due":"soon"})", "2026-06-02"), Catch::Contains("soon"));
}

TEST_CASE("devices scan: a host that answers, refuses or is not there is reported as such") {
  bench::Rig rig(small_request().bench);
  const std::string host = fmt::format("127.0.0.1:{}", rig.config().module.endpoint.port);
  const std::string answers = answers_of_host(host);
  CHECK_THAT(answers, Catch::StartsWith(host + ": ") && Catch::Contains("register 0"));
  rig.plant()->inject(bench::FaultKind::kModuleException, std::nullopt, 0);
  CHECK_THAT(answers_of_host(host), Catch::StartsWith(host + ": "));
  CHECK(answers_of_host(host) != answers);
  for (const char* none : {"127.0.0.1:1", "127.0.0.1:65535"})
    CHECK_THAT(answers_of_host(none), Catch::Contains("refused"));
}

TEST_CASE("devices scan: an invalid address is rejected before any host is contacted") {
  for (const char* address : {"host:0", "host:-1", "host:65536", ":502", "", "host:abc"}) {
    INFO(address);
    const auto refused = refusal_by([&] { (void)bench::scan_devices({address}); });
    REQUIRE(refused);
    CHECK((refused->id() == "TB-USAGE" && refused->code() == bench::ExitCode::kUsage));
    CHECK_THAT(refused->where(), Catch::EndsWith(std::string(" ") + address));
  }
}

// `live` over the simulated scanner's wire: its pressures, its lost frames, its end.

namespace {

// A fitted run of the small recipe up to 60 psi.
std::int64_t fitted_run(const std::string& path, const std::vector<sequences::Override>& overrides = {}) {
  db::RunStore store = db::RunStore::open(path, db::Durability::kNormal);
  bench::RunRequest request = small_request(overrides);
  request.recipes = {
      recipe_of("unit = \"psi\"\nturning_points = [0, 60, 20, 60, 0]\nstep = 10\nrepeats = 1\n"
                "[conditioning]\ncycles = 1\npeak = 60\n")};
  const bench::RunResult result = run_small(request, store);
  if (result.error) FAIL(result.error->what());
  bench::fit_run(store, analysis::load_dataset(store, result.run));
  return result.run;
}

// Of the last frame in the table that `live --csv` wrote, what its lines say.
struct LastFrame {
  int flat = 0, unknown = 0, out_of_range = 0, dead = 0, outside = 0, lost = 0, taxels = 0;
  double sum_psi = 0.0, highest_psi = 0.0;
};
LastFrame last_frame_of(const std::string& table, int frame) {
  LastFrame last;
  for (const std::vector<std::string>& cells : cells_of(table)) {
    if (cells.at(0) != std::to_string(frame)) continue;
    const unsigned bits = static_cast<unsigned>(std::stoul(cells.at(5)));
    const double psi = std::stod(cells.at(3));
    const auto has = [&](unsigned bit) { return (bits & bit) != 0 ? 1 : 0; };
    last.flat += has(analysis::kTaxelFlat);
    last.unknown += has(analysis::kTaxelUnknown);
    last.out_of_range += has(analysis::kTaxelOutOfRange);
    last.dead += has(analysis::kTaxelDead);
    last.outside += has(analysis::kTaxelOutside);
    last.lost += has(analysis::kTaxelLost);
    if (has(analysis::kTaxelDead) != 0) continue;
    ++last.taxels;
    last.sum_psi += psi;
    last.highest_psi = last.taxels == 1 ? psi : std::max(last.highest_psi, psi);
  }
  return last;
}

}  // namespace

TEST_CASE("live: its summary of the last frame agrees with the written table") {
  const TemporaryFolder folder;
  const std::int64_t run =
      fitted_run(folder.path("runs.db"), {{"simulation.defect", "[{kind=\"dead\",row=2,column=5}]"}});
  const auto live = [&](const std::vector<std::string>& more) {
    std::vector<std::string> words = {"live",    "--bench", "simulated.toml", "--model", std::to_string(run),
                                      "--db",    "runs.db", "--interval",     "0",       "--csv",
                                      "live.csv"};
    words.insert(words.end(), more.begin(), more.end());
    return run_program(program_path(), words, folder.path());
  };
  for (const bool elsewhere : {false, true}) {
    std::vector<std::string> words = {"--frames", "3", "--json"};
    if (elsewhere) words.insert(words.end(), {"--set", "simulation.scanner_serial=\"ANOTHER\""});
    const Finished done = live(words);
    INFO(done.err);
    REQUIRE(done.code == 0);
    const std::string table = read_file(folder.path("live.csv"));
    CHECK(table.starts_with("frame,time_s,taxel,pressure_psi,uncertainty_psi,status\n0,"));
    const LastFrame last = last_frame_of(table, 2);
    CHECK(last.dead == 1);
    CHECK(last.taxels == 255);
    CHECK((last.outside > 0) == elsewhere);
    const auto printed = nlohmann::json::parse(done.out);
    CHECK(printed.at("frames") == 3);
    CHECK(printed.at("lost_frames") == 0);
    CHECK(printed.at("origin") == "simulated");
    CHECK(printed.at("outside_validity").empty() == !elsewhere);
    const auto& frame = printed.at("last_frame");
    CHECK(frame.at("mean_psi").get<double>() == Approx(last.sum_psi / 255).margin(1e-3));
    CHECK(frame.at("highest_psi").get<double>() == Approx(last.highest_psi).margin(1e-3));
    CHECK(frame.at("flat") == last.flat);
    CHECK(frame.at("unknown") == last.unknown);
    CHECK(frame.at("out_of_range") == last.out_of_range);
    CHECK(frame.at("dead") == 1);
    CHECK(frame.at("outside_validity") == last.outside);
    CHECK(frame.at("lost") == last.lost);
  }
  const Finished by_integers = live({"--frames", "3", "--json", "--as", "fixed"});
  REQUIRE(by_integers.code == 0);
  const std::string table = read_file(folder.path("live.csv"));
  const LastFrame last = last_frame_of(table, 2);
  CHECK(last.dead == 1);
  CHECK(last.unknown == 0);  // unloaded, at its zero
  CHECK(last.sum_psi / 255 == Approx(0.0).margin(1.0));
  CHECK_THAT(table, Catch::Contains(",nan,"));  // without uncertainty
  const Finished elsewhere = live({"--frames", "1", "-q", "--set", "simulation.scanner_serial=\"ANOTHER\""});
  CHECK_THAT(elsewhere.err, Catch::Contains("ANOTHER"));
  const Finished wrong = run_program(
      program_path(), {"live", "--bench", "simulated.toml", "--model", "seven", "--db", "runs.db"}, folder.path());
  CHECK(wrong.code == 2);
}

TEST_CASE("live: Ctrl-C ends it cleanly") {
  const TemporaryFolder folder;
  const std::int64_t run = fitted_run(folder.path("runs.db"));
  const Finished stopped = run_program(
      program_path(),
      {"live", "--bench", "simulated.toml", "--model", std::to_string(run), "--db", "runs.db", "--csv", "endless.csv"},
      folder.path(), {SIGINT, [&] {
                        std::error_code not_yet;
                        const auto size = std::filesystem::file_size(folder.path("endless.csv"), not_yet);
                        return !not_yet && size > 10'000;  // frames, not the heading alone
                      }});
  INFO(stopped.out << stopped.err);
  CHECK(stopped.code == 0);
}

TEST_CASE("live: an unloaded array reads near zero, latency is measured, lost frames are counted") {
  const TemporaryFolder folder;
  const std::int64_t run = fitted_run(folder.path("runs.db"));
  const db::RunStore store = db::RunStore::open_read_only(folder.path("runs.db"));
  const analysis::SensorModel model = analysis::load_model(std::to_string(run), &store);
  CHECK(model.taxels.size() == 257);
  CHECK(model.scans == 2);
  long shown = 0;
  double highest = 0.0;
  const auto see = [&](const bench::LiveFrame& frame) {
    CHECK(frame.number == shown++);
    CHECK(frame.latency_us > 0.0);
    for (std::size_t t = 0; t < frame.status.size(); ++t)
      if ((frame.status[t] & analysis::kTaxelValid) != 0)
        highest = std::max(highest, static_cast<double>(frame.pressure_psi[t]));
    return true;
  };
  const bench::LiveSummary summary =
      bench::live_frames(small_request().bench, model, {.frames = 50, .interval_s = 0.0}, see);
  CHECK(summary.frames == 50);
  CHECK(shown == 50);
  CHECK(summary.lost == 0);
  CHECK_FALSE(summary.other_scanner);
  CHECK(highest < 5.0);
  CHECK(summary.median_us > 0.0);
  CHECK(summary.median_us <= summary.p99_us);
  CHECK(summary.p99_us <= summary.worst_us);
  CHECK(summary.compensation_median_us < summary.median_us);

  shown = 0;
  const bench::BenchConfig silent =
      small_request({{"simulation.wire_faults.scanner_silent_after_scans", "3"}, {"scanner.frame_timeout_ms", "200"}})
          .bench;
  CHECK_THROWS_AS(bench::live_frames(silent, model, {.frames = 50, .interval_s = 0.0}, see), devices::Fault);
  CHECK(shown == 3 + 9);  // the tenth loss in a row ends it

  analysis::SensorModel other = analysis::load_model(std::to_string(run), &store);
  other.scanner_serial = "ANOTHER";
  bool valid = false;
  const auto outside = bench::live_frames(small_request().bench, other, {.frames = 2, .interval_s = 0.0},
                                          [&](const bench::LiveFrame& frame) {
                                            for (const unsigned bits : frame.status)
                                              valid = valid || (bits & analysis::kTaxelValid) != 0;
                                            return true;
                                          });
  CHECK(outside.other_scanner);
  CHECK_FALSE(valid);
  // Nobody looks any more.
  const auto once = [](const bench::LiveFrame&) { return false; };
  CHECK(bench::live_frames(small_request().bench, model, {.frames = 0, .interval_s = 0.0}, once).frames == 1);
  other.rows = 8;
  try {
    (void)bench::live_frames(small_request().bench, other, {}, see);
    FAIL("a model of another array was taken");
  } catch (const bench::Error& error) {
    CHECK(error.id() == "TB-LIVE-SHAPE");
    CHECK(error.code() == bench::ExitCode::kUsage);
  }
}

TEST_CASE("live: a damaged scan is a lost frame, and a temperature is valid within the model's range and the U") {
  const TemporaryFolder folder;
  const std::int64_t run = fitted_run(folder.path("runs.db"));
  const db::RunStore store = db::RunStore::open_read_only(folder.path("runs.db"));
  analysis::SensorModel model = analysis::load_model(std::to_string(run), &store);
  const auto carried = [&](const std::vector<sequences::Override>& changes, const bench::LiveOptions& options,
                           bench::LiveSummary& summary) {
    std::vector<int> valid;
    double last_s = -1.0;
    summary = bench::live_frames(small_request(changes).bench, model, options, [&](const bench::LiveFrame& frame) {
      CHECK(frame.time_s > last_s);
      last_s = frame.time_s;
      valid.push_back(static_cast<int>(
          std::ranges::count_if(frame.status, [](unsigned bits) { return (bits & analysis::kTaxelValid) != 0; })));
      return true;
    });
    return valid;
  };
  bench::LiveSummary summary;
  CHECK(carried({{"simulation.wire_faults.scanner_corrupt_scan", "1"}, {"scanner.frame_timeout_ms", "2000"}},
                {.frames = 4, .interval_s = 0.0}, summary) == std::vector<int>{256, 0, 256, 256});
  CHECK((summary.frames == 4 && summary.lost == 1 && summary.outside.empty()));
  CHECK(carried({}, {.frames = 2, .interval_s = 0.001, .scans = 4}, summary) == std::vector<int>{256, 256});
  const std::vector<sequences::Override> warm = {
      {"environment.sensor", "[{quantity = 'temperature_c', unit = 9, address = 7, type = 'f32'}]"},
      {"simulation.temperature_c", "25.5"}};
  model.validity.temperature_c = analysis::Range{20.0, 25.0};  // within what a thermometer may differ by
  CHECK(carried(warm, {.frames = 1, .interval_s = 0.0}, summary) == std::vector<int>{256});
  model.validity.temperature_c = analysis::Range{20.0, 21.0};
  CHECK(carried(warm, {.frames = 1, .interval_s = 0.0}, summary) == std::vector<int>{0});
  REQUIRE(summary.outside.size() == 1);
  CHECK_THAT(summary.outside[0], Catch::Contains("25.5") && Catch::Contains("21.0"));
}
