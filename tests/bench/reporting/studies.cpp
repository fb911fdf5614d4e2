// Further runs in a report: mounts, turns, paces and presses, each with its runs in order. On runs of one taxel
// that are stored by hand, with models of a straight line.
#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "analysis/report/gather.h"
#include "bench/common/error.h"
#include "bench/config/config.h"
#include "bench/reporting/report_results.h"
#include "bench/reporting/study_roles.h"
#include "db/run_store.h"
#include "tests/bench/reporting/film_runs.h"
#include "tests/support/process.h"

using namespace tactbench;
using namespace tactbench::tests;

namespace {

using TypedStudies = std::vector<std::string>;

// Presses of an object at places one after the other, each up to 2 N and down; 1 V a newton.
struct HandPress {
  std::string object = "ring", name = "p";
  int places = 1;
  std::string mount_json = {};  // of a registration
  double area_mm2 = 0.0;        // of the sensor's type; 0: none is stored
  bool with_recipe = true;
};

class StudiedRuns : public FilmStore {
 public:
  std::int64_t add_press(const HandPress& made) {
    db::RunRecord run;
    run.uuid = db::new_uuid();
    run.origin = "simulated";
    run.state = "prepared";
    run.sensor_serial = "S-1";
    run.purpose = fmt::format("press {}", ++presses_);
    run.started_utc = "2026-03-01T00:00:00Z";
    if (made.area_mm2 > 0.0)
      run.sensor_toml = fmt::format(
          "schema = 1\nname = \"t\"\nrows = 1\ncolumns = 1\npitch_mm = 3.5\ntaxel_area_mm2 = {}\norientation_deg = 0\n"
          "output_range_v = [0, 5]\nfull_scale = \"highest mean output of the run\"\n",
          made.area_mm2);
    const std::string recipe = fmt::format(
        "schema = 1\nname = \"{}\"\nkind = \"press\"\ndwell_s = 0.5\n[press]\nobject = \"{}\"\npositions_mm = [[1, "
        "1]]\nforces_n = [1, 2]\n",
        made.name, made.object);
    // The chart of loops comes before that of the presses.
    run.sequences = {{0, "other", "", "", 1, 3},
                     {1, made.name, made.with_recipe ? recipe : "", "", 1, 4 * made.places}};
    run.devices = {{"tactile scanner", "synthetic", "", "", "simulated", R"({"volts_per_count":0.0001})"},
                   {"force sensor", "synthetic", "F-1", "", "simulated", R"({"certificate":"C-7"})"}};
    const std::int64_t number = store.begin_run(run);
    int ordinal = 0;
    for (int place = 0; place < made.places; ++place)
      for (const bool rising : {true, false}) {
        db::BranchRecord branch;
        branch.sequence = 1;
        branch.ordinal = 2 * place + (rising ? 0 : 1);
        branch.from_n = rising ? 0.0 : 2.0;
        branch.to_n = rising ? 2.0 : 0.0;
        const std::int64_t own = store.begin_branch(number, branch);
        for (const double force : rising ? std::vector{1.0, 2.0} : std::vector{1.0, 0.0}) {
          db::FrameRecord frame;
          frame.branch = own;
          frame.ordinal = ordinal++;
          frame.rows = frame.columns = frame.scans = 1;
          frame.time_ns = 1'000'000'000LL * ordinal;
          frame.counts = {static_cast<std::uint16_t>(10000.0 * force)};
          frame.wrench.emplace();
          frame.wrench->target_n = frame.wrench->force_start_n = force;
          frame.wrench->wrench = {0.0, 0.0, -force, 0.0, 0.0, 0.0};
          store.append_frame(number, frame);
        }
      }
    if (!made.mount_json.empty()) store.append_check(number, {number, 0, "mount", "pass", made.mount_json, {}});
    store.end_run(number, db::Outcome::kCompleted, "", db::SafeState::kVerified, "2026-03-01T00:00:00Z");
    return number;
  }
  // Of a report on that run.
  [[nodiscard]] analysis::ReportResults results(const TypedStudies& studies, std::int64_t run = 1) const {
    analysis::Runs runs(store);
    analysis::ReportInput input;
    input.run = store.run(run);
    input.fit = film_line_model();
    bench::ReportExtras extras;
    extras.studies = studies;
    bench::add_results(input, runs, extras);
    return input.more;
  }
  static std::string contact_text(const analysis::ReportResults& more) {
    std::string text;
    for (const analysis::ContactResult& one : more.contacts)
      text += fmt::format("{} {} '{}' {} mm, {} mm2, {} places, mount {}; ", one.run, one.sequence, one.object,
                          one.geometry.pitch_mm, one.geometry.taxel_area_mm2, one.positions, one.mount_run);
    return text;
  }

 private:
  int presses_ = 0;
};

using RunList = std::vector<std::int64_t>;

}  // namespace

TEST_CASE("study results: mounts and turns are compared with the run of the report, which is listed first") {
  StudiedRuns made;
  FilmRun mounted, turned;
  mounted.set = {{"simulation.mount_seed", "1"}};
  turned.set = {{"simulation.turned_in_chamber_deg", "90"}};
  (void)made.add({});
  (void)made.add(mounted);
  (void)made.add(turned);
  mounted.set = {{"simulation.mount_seed", "2"}};
  (void)made.add(mounted);
  const analysis::ReportResults none = made.results({});
  CHECK_FALSE(none.studies.remount.assessed());
  CHECK(none.studies.remount.runs.empty());
  CHECK(none.studies.uniformity.runs.empty());
  const analysis::ReportResults mounts = made.results({"2:mount", "4:mount"});
  CHECK(mounts.studies.remount.assessed());
  CHECK(mounts.studies.remount.runs == RunList{1, 2, 4});
  CHECK(mounts.studies.remount.degrees == 2);
  CHECK(mounts.studies.remount.pressure_psi == std::vector<double>{10.0, 20.0, 30.0, 40.0, 50.0, 60.0});
  CHECK(mounts.studies.uniformity.runs.empty());
  const analysis::ReportResults turns = made.results({"1:0", "3:90"});
  CHECK(turns.studies.uniformity.runs == RunList{1, 3});
  CHECK(turns.studies.uniformity.angles_deg == std::vector<int>{0, 90});
  CHECK(turns.studies.remount.runs.empty());
  const analysis::ReportResults both = made.results({"3:90", "4:mount"});
  CHECK(both.studies.remount.runs == RunList{1, 4});
  CHECK(both.studies.uniformity.runs == RunList{1, 3});
}

TEST_CASE("study results: runs at several rates or with holds are assessed for each sequence") {
  StudiedRuns made;
  FilmRun paced;
  paced.recipe =
      "schema = 1\nname = \"a\"\nunit = \"psi\"\nturning_points = [0, 60, 0]\nstep = 10\nrepeats = 2\ndwell_s = [1, "
      "4]\n";
  paced.dwells_s = {1.0, 4.0};
  (void)made.add({});
  (void)made.add(paced);
  (void)made.add(paced);
  CHECK_FALSE(made.results({}).studies.rate_hold.assessed());
  const analysis::RateHold found = made.results({"2", "3"}).studies.rate_hold;
  CHECK(found.assessed());
  REQUIRE(found.runs.size() == 2);
  CHECK((found.runs[0].run == 2 && found.runs[1].run == 3));
  CHECK(found.runs[0].sequence == "a");
  // The report's own run, too, where it paces.
  CHECK(made.results({"2"}, 2).studies.rate_hold.runs.size() == 1);
}

TEST_CASE("study results: a plain loop run is accepted as a study if its measured temperature differs") {
  StudiedRuns made;
  FilmRun cool, warm;
  cool.temperatures_c = {23.0};
  warm.temperatures_c = {25.0};
  (void)made.add(cool);
  (void)made.add(warm);
  CHECK(made.results({"2"}).contacts.empty());
  warm.temperatures_c = {24.9};
  (void)made.add(warm);
  CHECK_THROWS_AS(made.results({"3"}), bench::Error);
  CHECK_THROWS_AS(made.results({"1"}), bench::Error);
}

TEST_CASE("study results: press runs are listed with object, sensor, mount and instrument") {
  StudiedRuns made;
  (void)made.add({});
  const std::int64_t ring = made.add_press({.area_mm2 = 5.5}), flat = made.add_press({.object = "flat", .places = 2});
  const std::int64_t silent = made.add_press({.with_recipe = false});
  CHECK(made.results({}).contacts.empty());
  const analysis::ReportResults found = made.results({fmt::to_string(flat), fmt::to_string(ring)});
  CHECK(StudiedRuns::contact_text(found) ==
        fmt::format("{} p 'flat' 3.5 mm, 5.5 mm2, 2 places, mount 0; {} p 'ring' 3.5 mm, 5.5 mm2, 1 places, mount 0; ",
                    flat, ring));
  CHECK_THAT(found.contacts[0].force_traceability, Catch::Contains("C-7"));
  CHECK_FALSE(found.studies.rate_hold.assessed());
  CHECK(found.studies.crosstalk.run == 0);
  CHECK(StudiedRuns::contact_text(made.results({}, silent)) ==
        fmt::format("{} p '' 2.54 mm, 6.4516 mm2, 1 places, mount 0; ", silent));
  CHECK(made.results({fmt::to_string(ring)}, silent).contacts.size() == 2);
}

TEST_CASE("study results: the last given registration applies to runs without one, point presses show crosstalk") {
  StudiedRuns made;
  (void)made.add({});
  const std::int64_t before = made.add_press({});
  const std::int64_t first = made.add_press({.mount_json = R"({"angle_deg":0,"offset_mm":[1,2]})"});
  const std::int64_t second =
      made.add_press({.object = "point", .mount_json = R"({"angle_deg":90,"offset_mm":[1,2]})"});
  const std::int64_t after = made.add_press({.object = "point", .places = 4});
  const analysis::ReportResults found =
      made.results({fmt::to_string(before), fmt::to_string(first), fmt::to_string(second), fmt::to_string(after)});
  REQUIRE(found.contacts.size() == 4);
  const auto mount = [&](std::size_t i) { return found.contacts[i].mount_run; };
  CHECK((mount(0) == second && mount(1) == first && mount(2) == second && mount(3) == second));
  CHECK(found.studies.crosstalk.run == after);
}

// Every way in which a run's own record contradicts the role that was typed for it, in all its words; and what agrees.

using namespace tactbench::bench;

namespace {

using RunTags = std::vector<std::string>;

// Of hardware: nothing but its tags says how the sensor lay.
db::RunRecord placed_run(std::int64_t number, const RunTags& tags = {}) {
  db::RunRecord run;
  run.run = number;
  run.origin = "hardware";
  run.overrides_json = "[]";
  run.tags = tags;
  return run;
}

db::RunRecord simulated_run(std::int64_t number, const std::string& degrees, const std::string& mount_seed,
                            const RunTags& tags = {}) {
  db::RunRecord run = placed_run(number, tags);
  run.origin = "simulated";
  run.bench_toml = tests::read_file(find_config("simulated.toml"));
  run.overrides_json = fmt::format(R"([{{"key":"simulation.turned_in_chamber_deg","value":"{}"}},)"
                                   R"({{"key":"simulation.mount_seed","value":"{}"}}])",
                                   degrees, mount_seed);
  return run;
}

// "" where the role is believed; else the place of the refusal, and what its remedy ends with: what was done.
std::string role_refusal(const std::string& role, const db::RunRecord& own, const db::RunRecord& other,
                         StudyPurpose purpose = StudyPurpose::kPlainLoops) {
  try {
    check_role({other.run, role}, own, other, purpose);
  } catch (const Error& error) {
    CHECK(error.code() == ExitCode::kUsage);
    CHECK(error.id() == "TB-REPORT-STUDY");
    return error.where() + ", " + error.remedy().substr(error.remedy().rfind(' ') + 1);
  }
  return {};
}

}  // namespace

TEST_CASE("study roles: without a role, or without contrary records, the stated role is accepted") {
  const db::RunRecord own = placed_run(1);
  CHECK(role_refusal("", own, simulated_run(2, "90", "0"), StudyPurpose::kPresses).empty());
  for (const char* role : {"mount", "0", "90", "180", "270"}) CHECK(role_refusal(role, own, placed_run(2)).empty());
  // Other tags, and values that are not numbers, do not state a turn.
  for (const char* tag : {"turned=a quarter", "turned=90 degrees", "turned", "turned90", "returned=90", "turned="})
    CHECK(role_refusal("180", own, placed_run(2, {tag})).empty());
  // A bench that cannot be read, or is not simulated.
  db::RunRecord unread = simulated_run(2, "90", "0");
  unread.bench_toml = "no bench";
  CHECK(role_refusal("180", own, unread).empty());
  db::RunRecord hardware = simulated_run(2, "90", "0");
  hardware.origin = "hardware";
  CHECK(role_refusal("180", own, hardware).empty());
}

TEST_CASE("study roles: a press run or a run at several rates is rejected as mount or turn") {
  const db::RunRecord own = placed_run(1);
  CHECK(role_refusal("mount", own, placed_run(6), StudyPurpose::kPresses) == "--studies 6:mount, 6");
  CHECK(role_refusal("90", own, placed_run(7), StudyPurpose::kPaces) == "--studies 7:90, 7");
}

TEST_CASE("study roles: turns are relative to the run of the report, by tags or by the simulated sensor") {
  const db::RunRecord own = placed_run(1), turned = placed_run(1, {"turned=90"});
  CHECK(role_refusal("90", own, placed_run(2, {"turned=90"})).empty());
  CHECK(role_refusal("180", own, placed_run(2, {"turned=90"})) == "--studies 2:180, 2:90");
  CHECK(role_refusal("90", turned, placed_run(2, {"turned=180"})).empty());
  CHECK(role_refusal("270", turned, placed_run(2, {"turned=0"})).empty());  // backwards by 90
  CHECK(role_refusal("0", turned, placed_run(2, {"turned=450"})).empty());  // once around
  CHECK(role_refusal("180", turned, placed_run(2, {"turned=180"})) == "--studies 2:180, 2:90");
  CHECK(role_refusal("180", turned, placed_run(2, {"turned=-720"})) == "--studies 2:180, 2:270");
  // A run whose own turn cannot be read counts as not turned.
  CHECK(role_refusal("90", placed_run(1, {"turned=x"}), placed_run(2, {"turned=90"})).empty());
  // To a millionth of a degree.
  CHECK(role_refusal("90", own, placed_run(2, {"turned=90.0000009"})).empty());
  CHECK_FALSE(role_refusal("90", own, placed_run(2, {"turned=90.0000011"})).empty());
  CHECK_FALSE(role_refusal("90", own, placed_run(2, {"turned=89.9999989"})).empty());
  // The simulated sensor's own place, unless a tag says another.
  const db::RunRecord simulated = simulated_run(1, "0", "0");
  CHECK(role_refusal("90", simulated, simulated_run(3, "90", "0")).empty());
  CHECK(role_refusal("180", simulated, simulated_run(3, "90", "0")) == "--studies 3:180, 3:90");
  CHECK(role_refusal("180", simulated, simulated_run(3, "90", "0", {"turned=180"})).empty());
  CHECK(role_refusal("0", simulated_run(1, "90", "0"), simulated_run(3, "90", "0")).empty());
}

TEST_CASE("study roles: a mount must be another mount and not turned, by tags or by the simulated sensor") {
  const db::RunRecord own = placed_run(1, {"mount=a"});
  CHECK(role_refusal("mount", own, placed_run(2, {"mount=b"})).empty());
  CHECK(role_refusal("mount", placed_run(1), placed_run(2, {"mount=a"})).empty());
  CHECK(role_refusal("mount", own, placed_run(2)).empty());
  CHECK(role_refusal("mount", own, placed_run(2, {"mount=a"})) == "--studies 2:mount, 2");
  CHECK(role_refusal("mount", own, placed_run(2, {"mount=b", "turned=90"})) == "--studies 2:mount, 2:90");
  CHECK(role_refusal("mount", own, placed_run(2, {"mount=b", "turned=0"})).empty());
  // One that is turned may lie in the same mount: only the turn is asked for.
  CHECK(role_refusal("90", own, placed_run(2, {"mount=a", "turned=90"})).empty());
  const db::RunRecord simulated = simulated_run(1, "0", "4");
  CHECK(role_refusal("mount", simulated, simulated_run(3, "0", "5")).empty());
  CHECK(role_refusal("mount", simulated, simulated_run(3, "0", "4")) == "--studies 3:mount, 3");
  CHECK(role_refusal("mount", simulated, simulated_run(3, "0", "4", {"mount=other"})).empty());
}

// Further runs as typed after --studies: what is taken for a run with its role, and each refusal. The
// runs are stored by hand, without frames.

namespace {

using StudyWords = std::vector<std::string>;

std::string what_and_remedy(const bench::Error& error) {
  return fmt::format("{} {} at {}", static_cast<int>(error.code()), error.id(), error.where());
}

std::string taken_as(const StudyWords& words) {
  try {
    std::string text;
    for (const bench::StudyRun& study : bench::study_runs_of(words))
      text += fmt::format("{}({}) ", study.run, study.role);
    return text;
  } catch (const bench::Error& error) {
    return what_and_remedy(error);
  }
}

constexpr const char* kLoopWords =
    "schema = 1\nname = \"a\"\nunit = \"psi\"\nturning_points = [0, 20, 0]\nstep = 10\ndwell_s = 2\n";

class RunsOfStudies {
 public:
  RunsOfStudies() { store_.add_sensor({"S-1", "synthetic", "", db::sha256_hex(""), "SC-1", "", ""}); }
  std::int64_t add(const std::string& recipe) {
    db::RunRecord run;
    run.uuid = db::new_uuid();
    run.origin = "hardware";
    run.state = "prepared";
    run.sensor_serial = "S-1";
    run.sequences = {{0, "a", recipe, "", 1, 5}};
    return store_.begin_run(run);
  }
  // "" where nothing is refused.
  [[nodiscard]] std::string refusal(const StudyWords& studies, bool models = true,
                                    const std::string& previous = "") const {
    analysis::Runs runs(store_);
    analysis::ReportInput input;
    input.run = store_.run(1);
    input.fit.run = 1;
    if (models) input.fit.taxels.resize(1);
    bench::ReportExtras extras;
    extras.studies = studies;
    extras.previous = previous;
    try {
      bench::add_results(input, runs, extras);
    } catch (const bench::Error& error) {
      return what_and_remedy(error);
    }
    CHECK(input.more.contacts.empty());
    return {};
  }

 private:
  tests::TemporaryFolder folder_;
  db::RunStore store_ = db::RunStore::open(folder_.path("studies.db"), db::Durability::kNormal);
};

}  // namespace

TEST_CASE("study options: accept runs with one of five roles") {
  CHECK(taken_as({}).empty());
  CHECK(taken_as({"7", "8:mount", "9:0", "10:90", "11:180", "12:270"}) == "7() 8(mount) 9(0) 10(90) 11(180) 12(270) ");
  CHECK(taken_as({"7", "7:mount", "7:0"}) == "7() 7(mount) 7(0) ");  // one run in several roles
  for (const char* word :
       {"", "x", ":mount", "7x", "7 ", " 7", "7:", "7:45", "7:mounted", "7:mount:", "7.0:90", "99999999999999999999"}) {
    INFO(word);
    CHECK(taken_as({"1", word}) == "2 TB-USAGE at --studies");
  }
  for (const char* word : {"7", "7:90"}) CHECK(taken_as({"1", word, "2", word}) == "2 TB-USAGE at --studies");
}

TEST_CASE("studies: are rejected if the run of the report has no models to compare with") {
  RunsOfStudies runs;
  runs.add(kLoopWords);
  runs.add(kLoopWords);
  const std::string refusal = "2 TB-REPORT-STUDY at run 1";
  CHECK(runs.refusal({}, false).empty());
  CHECK(runs.refusal({"2"}, false) == refusal);
  CHECK(runs.refusal({}, false, "2:1") == refusal);
  CHECK(runs.refusal({}, true, "2:1") == refusal);  // models, and no full loop that they were evaluated on
  CHECK(runs.refusal({}).empty());
}

TEST_CASE("studies: the run of the report may be named only as turn 0, and is not a study otherwise") {
  RunsOfStudies runs;
  runs.add(kLoopWords);
  CHECK(runs.refusal({"1:0"}).empty());
  for (const char* word : {"1", "1:90", "1:mount"})
    CHECK(runs.refusal({word}) == fmt::format("2 TB-REPORT-STUDY at --studies {}", word));
}

TEST_CASE("studies: a plain loop run needs a role, a run at several rates must not have one") {
  RunsOfStudies runs;
  runs.add(kLoopWords);
  const std::int64_t plain = runs.add(kLoopWords), without = runs.add("");
  CHECK(runs.refusal({"2"}) == "2 TB-REPORT-STUDY at --studies 2");
  CHECK(plain == 2);
  CHECK_FALSE(runs.refusal({std::to_string(without)}).empty());
  const std::string steps =
      "schema = 1\nname = \"a\"\nunit = \"psi\"\nturning_points = [0, 20, 0]\nstep = 10\nrepeats = 2\n";
  for (const char* pace : {"dwell_s = [1, 4]\n", "ramp_psi_per_s = [1, 4]\n", "frames_per_level = 3\ndwell_s = 4\n"}) {
    const std::int64_t run = runs.add(steps + pace);
    INFO(pace);
    CHECK(runs.refusal({fmt::format("{}:mount", run)}) == fmt::format("2 TB-REPORT-STUDY at --studies {}:mount", run));
  }
  const std::int64_t one = runs.add(steps + "dwell_s = [2]\nframes_per_level = 1\n");
  CHECK_FALSE(runs.refusal({std::to_string(one)}).empty());
}
