// Whole runs on the simulated rig: in which order things happen, how many frames and attempts they take, within which
// bounds they end, and that what is told while they run fits what is stored.

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <filesystem>
#include <functional>

#include "bench/run/control/locks.h"
#include "tests/bench/run/finished_run.h"
#include "tests/bench/run/quick_store.h"
#include "tests/support/small_run.h"
#include "tests/support/variable.h"

using namespace tactbench;
using namespace tactbench::tests;
using Strings = std::vector<std::string>;
using bench::ExitCode;
using bench::FaultKind;

namespace {

const std::vector<sequences::Override> kSupplySensor = {
    {"environment.sensor", "[{quantity = 'supply_bar', unit = 9, address = 20, type = 'f32'}]"}};
const std::string kSupplyRule =
    "[[suspend]]\nquantity = \"supply_bar\"\ntrip_below = 6\nresume_above = 6.5\nhold_s = 2\n";

// One branch up and one down; `more`: the end of its recipe.
bench::RunRequest two_branches(const std::vector<sequences::Override>& overrides, const std::string& more,
                               const std::vector<bench::PlannedFault>& faults = {}) {
  bench::RunRequest request = small_request(overrides);
  request.recipes = {recipe_of("unit = \"psi\"\nturning_points = [0, 4, 2]\nstep = 2\nrepeats = 1\n" + more)};
  request.bench.simulation->plant.faults = faults;
  return request;
}

void check_settled(const FinishedRun& run, double dwell_s) {
  for (const db::FrameRecord& frame : run.frames) {
    CHECK(in_s(frame.in_band_ns) == Approx(dwell_s).margin(0.11));
    CHECK(frame.feedback_psi == Approx(frame.setpoint_psi).margin(0.1));
    CHECK(frame.reference_psi == Approx(frame.setpoint_psi).margin(0.25));
    CHECK(frame.exchanges > 0);
  }
}

}  // namespace

TEST_CASE("whole run: warm-up, seating, conditioning, suspension and a broken branch in this order, completed") {
  bench::RunRequest request = small_request({{"settling.trace_s", "0.1"}, kSupplySensor[0]});
  request.recipes = {recipe_of(
      "unit = \"psi\"\nturning_points = [0, 6, 2, 6]\nstep = 2\nrepeats = 1\n"
      "[warm_up]\ndrift_percent_per_min = 100.0\nat_most_s = 600\n" +
      kSupplyRule + "timeout_s = 100\n[conditioning]\ncycles = 3\npeak = 20\nchange_percent = 4\nleast = 2\n")};
  request.check_seating = true;
  request.bench.simulation->plant.faults = {planned_fault(FaultKind::kSupplyLost, 68.0, 8.0, 0.001),
                                            planned_fault(FaultKind::kOvershoot, 105.0, 1e6, 1.5)};
  const FinishedRun run(request);
  REQUIRE_FALSE(run.result.error);
  CHECK(run.result.safe == db::SafeState::kVerified);
  CHECK(run.checks() == Strings{"warm-up pass", "seating pass", "conditioning pass"});
  CHECK(run.course({"state", "safe", "way-back", "branch-broken"}) ==
        Strings{"state prepared -> running", "state running -> suspended", "safe verified",
                "state suspended -> running", "way-back", "branch-broken TB-BRANCH-BROKEN", "way-back",
                "state running -> stopping", "safe verified"});
  CHECK(run.result.branches_redone == 2);
  CHECK(run.result.waiting_seconds == Approx(7.4).margin(1.0));
  CHECK((run.frames.size() == 12 && run.void_frames == 4));
  CHECK((run.told.back().frames == 7 && run.told.back().frames_void == 4));  // before the last of eight
  REQUIRE(run.branches.size() == 5);
  CHECK_THAT(run.branches[0].void_reason, Catch::StartsWith("suspended") && Catch::Contains("supply_bar"));
  CHECK_THAT(run.branches[1].void_reason, Catch::StartsWith("TB-BRANCH-BROKEN"));
  CHECK(std::ranges::any_of(run.told, [](const bench::RunStatus& status) {
    return status.phase.find("branch 1 of repeat 1: conditioning") !=
           std::string::npos;  // the way back names its branch
  }));
  CHECK((run.branches[2].attempt == 2 && run.branches[2].from_psi == 0.0 && run.branches[2].to_psi == 6.0));
  check_settled(run, 2.0);
  std::vector<double> levels;
  for (const db::FrameRecord& frame : run.frames)
    if (!run.branch_of(frame).is_void) levels.push_back(frame.setpoint_psi);
  CHECK(levels == std::vector<double>{0, 2, 4, 6, 4, 2, 4, 6});
}

TEST_CASE("whole run: several frames per level have the set interval, and ramps without stops take their own time") {
  bench::RunRequest request = small_request();
  request.recipes = {
      recipe_of("unit = \"psi\"\nturning_points = [20, 10]\nstep = 10\nframes_per_level = 2\nframe_interval_s = 1.5\n"
                "[conditioning]\ncycles = 1\npeak = 15\n"),
      recipe_of("unit = \"psi\"\nturning_points = [0, 8, 0]\nstep = 4\nsettle = \"none\"\nramp_psi_per_s = [2.0, 8.0]\n"
                "repeats = 2\n")};
  const FinishedRun run(request);
  REQUIRE_FALSE(run.result.error);
  CHECK(run.voids() == 0);
  CHECK(run.flags() == Strings(14));
  CHECK(run.result.waiting_seconds == 0.0);
  REQUIRE(run.frames.size() == 14);
  REQUIRE(run.told.size() == 16);  // with two of conditioning
  for (std::size_t i = 0; i < run.told.size(); ++i) CHECK(run.told[i].step == static_cast<int>(i) + 1);
  for (const std::size_t first : {0U, 2U}) {
    CHECK(in_s(run.frames[first].in_band_ns) == Approx(2.0));
    CHECK(in_s(run.frames[first + 1].time_ns - run.frames[first].time_ns) == Approx(1.5));
    CHECK(run.frames[first + 1].setpoint_psi == run.frames[first].setpoint_psi);
  }
  for (const auto& [from, took_s] : {std::pair<std::size_t, double>{4, 2.0}, {9, 0.5}}) {
    for (std::size_t i = from + 1; i < from + 5; ++i) {  // 4 psi each
      CHECK(in_s(run.frames[i].since_command_ns) == Approx(took_s));
      CHECK(in_s(run.frames[i].time_ns - run.frames[i - 1].time_ns) == Approx(took_s));
    }
  }
}

TEST_CASE("whole run: a fault that ends it has its id and exit code, frames are kept, attempts are recorded") {
  const auto ends = [](const std::string& id, ExitCode code, std::size_t frames, int redone, int voids,
                       const bench::RunRequest& request) {
    INFO(id);
    const FinishedRun run(request);
    REQUIRE(run.result.error);
    CHECK(run.result.error->id() == id);
    CHECK(run.result.error->code() == code);
    CHECK_FALSE(run.result.error->remedy().empty());
    CHECK((run.result.outcome == db::Outcome::kFailed || run.result.outcome == db::Outcome::kAborted));
    CHECK(run.result.safe == (code == ExitCode::kUnsafe ? db::SafeState::kFailed : db::SafeState::kVerified));
    CHECK(run.frames.size() == frames);
    CHECK(run.result.branches_redone == redone);
    CHECK(run.voids() == voids);
    const Strings course = run.course({"attempt", "fault"});
    CHECK(std::ranges::count(course, "attempt " + id) == (id == "TB-SCANNER-TIMEOUT" ? 8 : 0));
    CHECK(course.back() == "fault " + id);
    CHECK((run.told.empty()) == (id == "TB-CHAMBER-NOT-VENTED"));  // no step was begun
    CHECK_THAT(run.store.run(run.result.run).reason, Catch::StartsWith(id));
  };
  const auto fault = [](FaultKind kind, double at_s, double value, double lasts_s = 1e6) {
    return planned_fault(kind, at_s, lasts_s, value);
  };
  ends("TB-CHAMBER-TIMEOUT", ExitCode::kDevice, 1, 0, 0,
       two_branches({{"simulation.chamber.leak_psi_per_s", "40"}, {"settling.timeout_s", "3"}}, ""));
  // Twice two readings of a frame, and the third attempt of the branch.
  ends("TB-SCANNER-TIMEOUT", ExitCode::kDevice, 2, 2, 2,
       two_branches({{"simulation.wire_faults.scanner_silent_after_scans", "6"}, {"scanner.frame_timeout_ms", "200"}},
                    "[retry]\nframe = 1\nbranch = 2\n"));
  ends("TB-BRANCH-BROKEN", ExitCode::kDevice, 2, 1, 2,
       two_branches({{"settling.trace_s", "0.1"}}, "[guard]\nredo = 1\n[conditioning]\ncycles = 1\npeak = 6\n",
                    {fault(FaultKind::kOvershoot, 9.0, 1.5), fault(FaultKind::kOvershoot, 17.0, 1.5)}));
  ends("TB-RUN-SUSPENDED", ExitCode::kDevice, 2, 1, 1,
       two_branches(kSupplySensor, kSupplyRule + "timeout_s = 3\n", {fault(FaultKind::kSupplyLost, 4.0, 0.001)}));
  ends("TB-SCANNER-STALE", ExitCode::kDevice, 2, 0, 0,
       two_branches({}, "", {fault(FaultKind::kScannerStale, 3.0, 0.0)}));
  ends("TB-CHAMBER-DISAGREE", ExitCode::kUnsafe, 1, 1, 1,  // apart for half a second they may be
       two_branches({}, "",
                    {fault(FaultKind::kReferenceOffset, 3.0, 5.0, 0.5), fault(FaultKind::kReferenceOffset, 5.5, 5.0)}));
  ends("TB-STEP-TIMEOUT", ExitCode::kDevice, 0, 0, 0, two_branches({}, "dwell_s = 2.0\n[timeout]\nstep_s = 2.55\n"));
  ends("TB-CHAMBER-NOT-VENTED", ExitCode::kUnsafe, 0, 0, 0,
       two_branches({}, "", {fault(FaultKind::kReferenceOffset, 0.0, 1.25)}));
}

TEST_CASE("whole run: an impossible reading prevents the start, ends a run in progress, and proves nothing") {
  constexpr double kDead = -90.0;  // psi: a supply that is lost behind a live zero
  const auto dead = [](FaultKind kind, double at_s, double lasts_s = 1e6) {
    return planned_fault(kind, at_s, lasts_s, kDead);
  };
  const auto ends = [](const std::vector<bench::PlannedFault>& faults, ExitCode code, db::SafeState safe, bool begun) {
    const FinishedRun run(two_branches({}, "", faults));
    REQUIRE(run.result.error);
    INFO(run.result.error->what() << " / " << run.result.safe_text.in(tactbench::analysis::PressureUnit::kPsi));
    CHECK(run.result.error->id() == "TB-CHAMBER-WITNESS");
    CHECK(run.result.error->code() == code);
    CHECK(run.result.outcome == db::Outcome::kAborted);
    CHECK(run.result.safe == safe);
    CHECK(run.told.empty() != begun);
    CHECK(run.voids() <= 1);
  };
  constexpr auto kFeedback = FaultKind::kFeedbackOffset, kReference = FaultKind::kReferenceOffset;
  // Before the first command there is no unloaded frame, so the array bears no witness.
  for (const FaultKind kind : {kFeedback, kReference})
    ends({dead(kind, 0.0)}, ExitCode::kUnsafe, db::SafeState::kUnverified, false);
  for (const FaultKind kind : {kFeedback, kReference})
    ends({dead(kind, 3.0)}, ExitCode::kStopped, db::SafeState::kVerified, true);
  ends({dead(kFeedback, 3.0), dead(kReference, 3.0)}, ExitCode::kUnsafe, db::SafeState::kUnverified, true);
  ends({dead(kFeedback, 3.0), dead(kReference, 3.0), planned_fault(FaultKind::kValveStuck, 3.0, 1e6, 0.0),
        planned_fault(FaultKind::kScannerUnplugged, 3.0, 1e6, 0.0)},
       ExitCode::kUnsafe, db::SafeState::kUnverified, true);
  // A shock on a line for less than disagreement_s.
  CHECK_FALSE(FinishedRun(two_branches({}, "", {dead(kReference, 3.0, 0.5)})).result.error);
}

TEST_CASE("whole run: a step may take exactly as long as its recipe allows") {
  const FinishedRun run(two_branches({}, "dwell_s = 2.0\n[timeout]\nstep_s = 2.65\n"));
  CHECK(run.result.outcome == db::Outcome::kCompleted);
  CHECK(run.frames.size() == 4);
}

TEST_CASE("whole run: if frames are not read again, a damaged scan costs a branch") {
  const FinishedRun run(
      two_branches({{"simulation.wire_faults.scanner_corrupt_scan", "6"}, {"scanner.frame_timeout_ms", "1000"}},
                   "[retry]\nframe = 0\nbranch = 1\n"));
  REQUIRE_FALSE(run.result.error);
  CHECK(run.course({"attempt", "safe", "way-back"}) == Strings{"attempt TB-SCANNER-CORRUPT",
                                                               "attempt TB-SCANNER-CORRUPT", "safe verified",
                                                               "way-back", "safe verified"});
  CHECK(run.result.branches_redone == 1);
  REQUIRE(run.branches.size() == 3);
  CHECK_THAT(run.branches[0].void_reason, Catch::StartsWith("TB-SCANNER-CORRUPT"));
  CHECK((run.frames.size() == 6 && run.void_frames == 2));
  check_settled(run, 2.0);
}

TEST_CASE("whole run: a broken branch is kept with a flag if the recipe requires it") {
  const FinishedRun run(two_branches({{"settling.trace_s", "0.1"}}, "[guard]\nredo = 0\non_broken = \"flag\"\n",
                                     {planned_fault(FaultKind::kOvershoot, 3.0, 1e6, 1.5)}));
  REQUIRE_FALSE(run.result.error);
  CHECK(run.voids() == 0);
  CHECK(run.flags() == Strings{"", "", "broken", ""});
}

TEST_CASE("whole run: a stuck row and a feedback that leaves its band each flag the frame concerned") {
  const FinishedRun run(two_branches(
      {}, "[dwell]\ntolerance_s = 0.0\n",
      {planned_fault(FaultKind::kRowStuck, 1.0, 6.0, 3.0), planned_fault(FaultKind::kFeedbackOffset, 4.0, 0.5, 0.4)}));
  REQUIRE_FALSE(run.result.error);
  CHECK(run.flags() == Strings{"", "row-stuck left-band", "", ""});
}

TEST_CASE("whole run: a module busy for a moment costs no branch and is recorded, one that stays busy costs one") {
  for (const double lasts_s : {0.1, 2.0}) {
    const FinishedRun run(
        two_branches({}, "[retry]\nbranch = 1\n", {planned_fault(FaultKind::kModuleBusy, 4.0, lasts_s, 0.0)}));
    INFO("busy for " << lasts_s << " s");
    REQUIRE_FALSE(run.result.error);
    CHECK(run.result.safe == db::SafeState::kVerified);
    CHECK(run.voids() == (lasts_s < 1.0 ? 0 : 1));
    const Strings course = run.course({"warning", "attempt"});
    CHECK(std::ranges::count(course, "warning TB-MODBUS-BUSY") >= (lasts_s < 1.0 ? 1 : 0));
    CHECK(std::ranges::count(course, "attempt TB-MODBUS-BUSY") == (lasts_s < 1.0 ? 0 : 1));
  }
}

TEST_CASE("whole run: a wait shorter than the rest that the recipe allows costs only its own branch") {
  const FinishedRun run(two_branches(kSupplySensor, "dwell_s = 4.0\nrest_restart_s = 15\n" + kSupplyRule,
                                     {planned_fault(FaultKind::kSupplyLost, 14.0, 5.0, 0.001)}));
  REQUIRE_FALSE(run.result.error);
  REQUIRE(run.branches.size() == 3);
  CHECK((!run.branches[0].is_void && run.branches[1].is_void && !run.branches[2].is_void));
  CHECK((run.branches[1].ordinal == 1 && run.branches[2].ordinal == 1));
}

TEST_CASE("whole press run: only frames with a force scatter beyond the tolerance of the level are flagged") {
  for (const char* noise_n : {"0.005", "0.08"}) {
    bench::RunRequest request = small_request({{"simulation.contact.force_noise_n", noise_n}});
    request.recipes = {recipe_of(press_text(1))};
    const FinishedRun run(request);
    REQUIRE_FALSE(run.result.error);
    const std::string flag = noise_n == std::string("0.08") ? "force-spread" : "";
    const std::string tare = flag.empty() ? "tare pass" : "tare warning";
    CHECK(run.checks() == Strings{tare, "conditioning pass", tare});
    // The tolerance is 0.05 N of no force and of 5 N, 0.3 N of 30 N.
    CHECK(run.flags() == Strings{flag, "", flag});
  }
}

TEST_CASE("whole press run: z is homed first, forces are reached and held, and z is proved clear at the end") {
  bench::RunRequest request = small_request();
  request.recipes = {recipe_of(press_text(1))};
  const FinishedRun run(request);
  REQUIRE_FALSE(run.result.error);
  CHECK(run.result.safe == db::SafeState::kVerified);
  CHECK(run.course({"stage"}) == Strings{"stage home", "stage tare", "stage contact", "stage contact", "stage tare"});
  CHECK(run.checks() == Strings{"tare pass", "conditioning pass", "tare pass"});
  Strings moved;  // axes in the order in which they were first sent
  for (const db::EventRecord& event : run.store.events(1)) {
    const std::size_t at = (event.id + event.detail).find("stage ");
    if (event.kind != "command" || at == std::string::npos) continue;
    const std::string axis = (event.id + event.detail).substr(at + 6, 1);
    if (std::ranges::find(moved, axis) == moved.end()) moved.push_back(axis);
  }
  CHECK(moved == Strings{"z", "x", "y"});
  REQUIRE(run.frames.size() == 3);
  const std::vector<double> forces = {5.0, 30.0, 5.0};
  for (std::size_t i = 0; i < forces.size(); ++i) {
    REQUIRE(run.frames[i].wrench);
    const db::WrenchRecord& pressed = *run.frames[i].wrench;
    CHECK(pressed.target_n == forces[i]);
    CHECK(pressed.force_start_n == Approx(forces[i]).margin(forces[i] < 10.0 ? 0.06 : 0.31));
    CHECK(pressed.wrench[2] == Approx(-forces[i]).epsilon(0.02));
    CHECK((pressed.place_mm[0] == Approx(30.0) && pressed.place_mm[1] == Approx(30.0)));
    CHECK(in_s(run.frames[i].in_band_ns) == Approx(0.5).margin(0.01));
  }
  CHECK(run.frames[1].wrench->place_mm[2] > run.frames[0].wrench->place_mm[2]);
  REQUIRE(run.branches.size() == 2);
  CHECK((run.branches[0].from_n == 0.0 && run.branches[0].to_n == 30.0 && run.branches[1].to_n == 5.0));
  CHECK(run.result.most_exchanges_a_step <= 60);
}

TEST_CASE("whole press run: a point pressed at three places registers the taxel positions") {
  bench::RunRequest request = small_request();
  request.recipes = {recipe_of(
      "kind = \"press\"\ndwell_s = 1.0\n[press]\nobject = \"point\"\npositions_mm = [[20, 24], [40, 28], [30, 40]]\n"
      "forces_n = [3]\nhold = \"force\"\nregisters = true\napproach_mm_per_s = 0.6\ncontact_n = 0.15\nclear_mm = "
      "4.0\n")};
  const FinishedRun run(request);
  REQUIRE_FALSE(run.result.error);
  CHECK(run.result.safe == db::SafeState::kVerified);
  REQUIRE(run.frames.size() == 3);
  const std::vector<std::pair<double, double>> places = {{20, 24}, {40, 28}, {30, 40}};
  for (std::size_t i = 0; i < places.size(); ++i) {
    REQUIRE(run.frames[i].wrench);
    CHECK(run.frames[i].wrench->place_mm[0] == Approx(places[i].first));
    CHECK(run.frames[i].wrench->place_mm[1] == Approx(places[i].second));
    CHECK(run.frames[i].wrench->wrench[2] == Approx(-3.0).margin(0.06));
  }
  CHECK(run.checks() == Strings{"tare pass", "tare pass", "mount pass"});
  const nlohmann::json mount = nlohmann::json::parse(run.store.checks(1).back().detail_json);
  CHECK(mount.at("touches").size() == 3);
  CHECK(mount.at("flipped") == false);
  // The array's centre, taxel 7.5, lies under 30, 30.
  CHECK(mount.at("scale").get<double>() == Approx(1.0).margin(0.02));
  CHECK(mount.at("angle_deg").get<double>() == Approx(0.0).margin(3.0));
  for (const int axis : {0, 1})
    CHECK(mount.at("offset_mm").at(axis).get<double>() == Approx(30.0 - 7.5 * 2.54).margin(1.0));
  CHECK(mount.at("rms_mm").get<double>() < 0.5);
  CHECK(mount.at("other_flip_rms_mm").get<double>() > 5.0);
}

TEST_CASE("whole run: if its store disappears it ends vented, and all measured data are saved completely") {
  namespace fs = std::filesystem;
  using Goes = std::function<void(const std::string& path, const std::string& elsewhere)>;
  const auto [how, goes] = GENERATE(table<std::string, Goes>({
      {"removed", [](const std::string& path, const std::string&) { fs::remove(path); }},
      {"moved", [](const std::string& path, const std::string&) { fs::rename(path, path + ".old"); }},
      {"replaced by an older copy", [](const std::string& path, const std::string&) { fs::rename(path + ".copy", path); }},
      {"replaced by another", [](const std::string& path, const std::string&) { write_file(path + "x", ""); fs::rename(path + "x", path); }},
      {"cut off", [](const std::string& path, const std::string&) { fs::resize_file(path, 3 * 4096); }},
      {"its folder moved", [](const std::string& path, const std::string& to) { fs::rename(fs::path(path).parent_path(), to); }},
  }));
  INFO(how);
  const TemporaryFolder folder;
  const std::string path = folder.path("here/runs.db");
  fs::create_directory(folder.path("here"));
  const Variable temporary("TMPDIR", folder.path());
  db::RunStore store = db::RunStore::open(path, db::Durability::kNormal);
  const db::SensorRecord sensor = small_request().sensor;
  store.add_sensor(sensor);
  store.snapshot(path + ".copy");
  bench::RunRequest request = small_request();
  int steps = 0;
  request.on_step = [&, does = goes](const sequences::Step&) {
    if (++steps == 12) does(path, folder.path("there"));
  };
  const bench::RunResult result = run_small(request, store);
  CHECK(steps == 12);
  REQUIRE(result.error);
  CHECK(result.error->id() == "TB-STORE-GONE");
  CHECK(result.error->code() == ExitCode::kStore);
  CHECK(result.safe == db::SafeState::kVerified);
  if (how == "cut off") return;
  const std::string remedy = result.error->remedy();
  const std::size_t from = remedy.find('\'') + 1;
  const std::string saved = remedy.substr(from, remedy.find('\'', from) - from);
  CHECK(fs::path(saved).parent_path() == (fs::exists(folder.path("here")) ? folder.path("here") : folder.path()));
  const db::RunStore rescued = db::RunStore::open_read_only(saved);
  CHECK(result.frames_kept > 2);
  CHECK(rescued.frame_count(result.run) == result.frames_kept);
  CHECK(rescued.check_content(result.run).holds());
  CHECK(rescued.check_structure().empty());
  CHECK(rescued.run(result.run).outcome == db::Outcome::kFailed);
  CHECK_THAT(rescued.run(result.run).reason, Catch::StartsWith("TB-STORE-GONE"));
  // The file now in its place is read as it is.
  CHECK_FALSE(fs::exists(path + "-wal"));
  if (how == "replaced by an older copy") CHECK(db::RunStore::open_read_only(path).runs().empty());
}

TEST_CASE("whole run: a lock file removed during the run is created again at once, with its lock") {
  bench::RunRequest request = small_request();
  const TemporaryFolder folder;
  const std::string path = folder.path("runs.db");
  db::RunStore store = db::RunStore::open(path, db::Durability::kNormal);
  int steps = 0;
  request.on_step = [&](const sequences::Step&) {
    ++steps;
    if (steps == 12) std::filesystem::remove(path + "-lock");
    if (steps == 14) CHECK_FALSE(bench::StoreLocks(path).try_lock_store());
  };
  const bench::RunResult result = run_small(request, store);
  CHECK_FALSE(result.error);
  CHECK(steps > 14);
  const auto events = store.events(result.run);
  CHECK(std::ranges::count(events, "TB-STORE-LOCK", &db::EventRecord::id) == 1);
}

// The seating check inside runs of the simulated rig.

namespace {

bench::RunResult run_seated(db::RunStore& store, const std::vector<sequences::Override>& overrides = {},
                            bool check_seating = true) {
  bench::RunRequest request = small_request(overrides);
  request.check_seating = check_seating;
  return run_small(request, store);
}

std::vector<db::CheckRecord> seatings(const db::RunStore& store, std::int64_t run) {
  std::vector<db::CheckRecord> found;
  for (db::CheckRecord& check : store.checks(run)) {
    if (check.kind == "seating") found.push_back(std::move(check));
  }
  return found;
}

std::string first_kind(const db::CheckRecord& check) {
  return nlohmann::json::parse(check.detail_json).at("findings").at(0).at("kind");
}

// A whole row of the specimen, as the bench file has it.
bench::RunRequest with_dead_row(int row) {
  bench::RunRequest request = small_request();
  request.check_seating = true;
  for (int c = 0; c < 16; ++c) {
    request.bench.simulation->plant.specimen.defects.push_back({bench::TaxelDefect::Kind::kDead, row, c});
  }
  return request;
}

}  // namespace

TEST_CASE("seating: the check is stored before the first frame, and an equal run has equal content") {
  QuickStore store;
  const bench::RunResult first = run_seated(store);
  REQUIRE(!first.error);
  CHECK(first.frames == 2 * 15);
  const std::vector<db::CheckRecord> checks = seatings(store, first.run);
  REQUIRE(checks.size() == 1);
  CHECK(checks.front().verdict == "pass");
  CHECK(checks.front().data.size() == 2U * 256U);
  CHECK(checks.front().time_ns < 60'000'000'000);
  const auto detail = nlohmann::json::parse(checks.front().detail_json);
  CHECK(detail.at("pressure_psi").get<double>() == Approx(8.0).margin(0.3));
  CHECK(detail.at("mean_response_v").get<double>() > 0.5);
  CHECK(detail.at("findings").empty());
  const bench::RunResult again = run_seated(store);  // now with a last seating
  CHECK(again.content_sha256 == first.content_sha256);
}

TEST_CASE("seating: a sensor mounted again a month later on a warmer day passes") {
  QuickStore store;
  REQUIRE(!run_seated(store).error);
  const bench::RunResult result = run_seated(store, {{"simulation.mount_seed", "1"},
                                                     {"simulation.effects.remount_variation", "0.03"},
                                                     {"simulation.temperature_c", "28"},
                                                     {"simulation.age_months", "1"},
                                                     {"simulation.effects.gain_drift_per_month", "0.01"},
                                                     {"simulation.effects.zero_drift_v_per_month", "0.01"}});
  CHECK(!result.error);
  CHECK(seatings(store, result.run).front().verdict == "pass");
}

TEST_CASE("seating: a turned sensor ends the second run, vented, but not the first") {
  QuickStore store;
  REQUIRE(!run_seated(store).error);
  const bench::RunResult result = run_seated(store, {{"simulation.mount_turn", "\"turned-90\""}});
  REQUIRE(result.error);
  CHECK(result.error->id() == "TB-SEATING");
  CHECK(result.error->code() == ExitCode::kCriterionFailed);
  CHECK_THAT(result.error->what(), Catch::Contains("90"));
  CHECK_FALSE(result.error->remedy().empty());
  CHECK(result.frames == 0);
  CHECK(result.safe == db::SafeState::kVerified);
  CHECK(store.run(result.run).outcome == db::Outcome::kFailed);
  REQUIRE(seatings(store, result.run).size() == 1);
  CHECK(seatings(store, result.run).front().verdict == "fail");
  CHECK(first_kind(seatings(store, result.run).front()) == "turned");
  // A failed seating is nothing to compare with: turned back, it passes again.
  CHECK(!run_seated(store).error);
}

TEST_CASE("seating: a dead row ends the very first run") {
  QuickStore store;
  const bench::RunResult dead = run_small(with_dead_row(4), store);
  REQUIRE(dead.error);
  CHECK(dead.error->id() == "TB-SEATING");
  CHECK_THAT(dead.error->what(), Catch::Contains("row 4"));
}

TEST_CASE("seating: without the check a badly seated sensor is measured, and the run records the missing check") {
  QuickStore store;
  bench::RunRequest request = with_dead_row(4);
  request.check_seating = false;
  const bench::RunResult result = run_small(request, store);
  CHECK(!result.error);
  CHECK(seatings(store, result.run).empty());
  bool said = false;
  for (const db::EventRecord& event : store.events(result.run)) {
    said = said || (event.kind == "seating" && event.detail.find("--no-seating") != std::string::npos);
  }
  CHECK(said);
}

TEST_CASE("seating: a low recipe is not checked, the peak of a medium recipe is the load of the check") {
  QuickStore store;
  bench::RunRequest request = small_request();
  request.check_seating = true;
  const auto up_to = [](const std::string& psi) {
    return sequences::parse_recipe(sequences::TomlDocument::from_text(
        "schema = 1\nname = \"low\"\nunit = \"psi\"\nturning_points = [0, " + psi + ", 0]\nstep = 2\n", "low.toml"));
  };
  request.recipes = {up_to("4")};
  const bench::RunResult low = run_small(request, store);
  REQUIRE(!low.error);
  CHECK(seatings(store, low.run).empty());
  request.recipes = {up_to("6")};
  const bench::RunResult between = run_small(request, store);
  REQUIRE(!between.error);
  REQUIRE(seatings(store, between.run).size() == 1);
  const auto detail = nlohmann::json::parse(seatings(store, between.run).front().detail_json);
  CHECK(detail.at("pressure_psi").get<double>() == Approx(6.0).margin(0.3));
}

TEST_CASE("seating: many dead taxels give one warning, later runs accept them without a warning") {
  QuickStore store;
  bench::RunRequest request = small_request();
  request.check_seating = true;
  for (int i = 0; i < 8; ++i) {
    request.bench.simulation->plant.specimen.defects.push_back({bench::TaxelDefect::Kind::kDead, i, 15 - i});
  }
  const bench::RunResult first = run_small(request, store);
  CHECK(!first.error);
  REQUIRE(seatings(store, first.run).size() == 1);
  CHECK(seatings(store, first.run).front().verdict == "warning");
  CHECK(first_kind(seatings(store, first.run).front()) == "dead-taxels");
  const bench::RunResult second = run_small(request, store);
  CHECK(seatings(store, second.run).front().verdict == "pass");
}
