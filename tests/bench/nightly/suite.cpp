// Which scenarios a night carries out: one alone, with other seeds, in parts; and scenarios that are none.
#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <vector>

#include "bench/common/error.h"
#include "bench/nightly/night_store.h"
#include "bench/nightly/suite.h"
#include "db/run_store.h"
#include "db/sqlite.h"
#include "tests/bench/config/bench_text.h"
#include "tests/bench/nightly/part_store.h"
#include "tests/support/process.h"
#include "tests/support/refusal.h"

using namespace tactbench;
using namespace tactbench::bench;
using namespace tactbench::tests;

namespace {

Suite suite_of_three() {
  return parse_suite(
      "schema = 1\nname = \"s\"\n[[scenario]]\nname = \"a\"\nabout = \"\"\nseed = 5\n[[scenario]]\nname = \"b\"\n"
      "about = \"\"\n[[scenario]]\nname = \"c\"\nabout = \"\"\nseed = 9\n",
      "three.toml");
}

std::string labels(const Suite& suite) {
  std::string text;
  for (const Scenario& scenario : suite.scenarios)
    text += (text.empty() ? "" : " ") + scenario.label + "=" + std::to_string(scenario.seed);
  return text;
}

}  // namespace

TEST_CASE("a night's choice: all, one alone, two in the suite's order, one seed for all, several seeds") {
  CHECK(labels(selected(suite_of_three(), {})) == "a=5 b=1 c=9");
  CHECK(labels(selected(suite_of_three(), {.only = {"b"}, .seed = std::nullopt, .seeds = 1})) == "b=1");
  CHECK(labels(selected(suite_of_three(), {.only = {"c", "a", "c"}, .seed = std::nullopt, .seeds = 1})) == "a=5 c=9");
  CHECK(labels(selected(suite_of_three(), {.only = {}, .seed = 7, .seeds = 1})) == "a=7 b=7 c=7");
  CHECK(labels(selected(suite_of_three(), {.only = {"c"}, .seed = 0, .seeds = 2})) == "c-seed-0=0 c-seed-1=1");
  const auto none = refusal_by([] {
    (void)selected(suite_of_three(), {.only = {"a", "d"}, .seed = std::nullopt, .seeds = 1});
  });
  REQUIRE(none);
  CHECK((none->id() == "TB-NIGHTLY-SCENARIO" && none->code() == ExitCode::kUsage && none->where() == "three.toml"));
}

TEST_CASE("scenario selection: JSON is written and read back, invalid JSON is rejected") {
  CHECK(to_json(Selection{}) == "{\"only\":[],\"seed\":null,\"seeds\":1}");
  CHECK(to_json(Selection{{"x", "y"}, 12, 3}) == "{\"only\":[\"x\",\"y\"],\"seed\":12,\"seeds\":3}");
  const Selection none = selection_from_json("{\"only\":[],\"seed\":null,\"seeds\":1}");
  CHECK((none.only.empty() && !none.seed && none.seeds == 1));
  const Selection all = selection_from_json("{\"only\":[\"x\"],\"seed\":12,\"seeds\":3}");
  CHECK((all.only == std::vector<std::string>{"x"} && all.seed == 12U && all.seeds == 3));
  for (const char* wrong : {"", "{}", "{\"only\":[],\"seeds\":1}", "{\"only\":\"x\",\"seed\":null,\"seeds\":1}"})
    CHECK_THROWS(selection_from_json(wrong));
}

TEST_CASE("shard: parts of a night take the scenarios in turn, in suite order") {
  const Suite whole = selected(suite_of_three(), {.only = {}, .seed = std::nullopt, .seeds = 2});
  CHECK(labels(part_of(whole, {1, 2})) == "a-seed-5=5 b-seed-1=1 c-seed-9=9");
  CHECK(labels(part_of(whole, {2, 2})) == "a-seed-6=6 b-seed-2=2 c-seed-10=10");
  CHECK(labels(part_of(whole, {1, 1})) == labels(whole));
  CHECK(part_of(whole, {3, 4}).name == "s");
}

TEST_CASE("nightly scenario: a bench that is not simulated is rejected before anything is changed") {
  const TemporaryFolder folder;
  Scenario scenario = suite_of_three().scenarios[0];
  scenario.bench = folder.path("rig.toml");
  write_file(scenario.bench, bench_text("hardware"));
  const auto refused = refusal_by([&] { (void)carry_out(scenario, folder.path("n.db")); });
  REQUIRE(refused);
  CHECK((refused->id() == "TB-NIGHTLY-BENCH" && refused->code() == ExitCode::kUsage));
  CHECK_THAT(refused->where(), Catch::EndsWith(scenario.bench));
}

TEST_CASE("scenario store: holds only the sensor and the runs of the suite, without tags") {
  const TemporaryFolder folder;
  const std::string path = folder.path("n.db");
  CHECK_FALSE(is_scenario_store(path));
  write_file(folder.path("text"), "no store");
  CHECK_FALSE(is_scenario_store(folder.path("text")));
  db::RunStore store = db::RunStore::open(path, db::Durability::kNormal);
  CHECK(is_scenario_store(path));  // broken off before its specimen
  store.add_sensor({"SIM-0001", "t", "", db::sha256_hex(""), "", "simulated array of the nightly suite", ""});
  db::RunRecord run;
  run.uuid = db::new_uuid();
  run.origin = "simulated";
  run.state = "prepared";
  run.sensor_serial = "SIM-0001";
  run.operator_name = "nightly";
  run.sequences = {{0, "s", "", "", 1, 1}};
  const std::int64_t first = store.begin_run(run);
  CHECK(is_scenario_store(path));
  store.set_tags(first, {"kept"}, {});
  CHECK_FALSE(is_scenario_store(path));
  store.set_tags(first, {}, {"kept"});
  CHECK(is_scenario_store(path));
  store.end_run(first, db::Outcome::kCompleted, "", db::SafeState::kVerified, "2026-01-01T00:00:00Z");
  run.uuid = db::new_uuid();
  run.operator_name = "K. Lee";
  (void)store.begin_run(run);
  CHECK_FALSE(is_scenario_store(path));
  db::RunStore other = db::RunStore::open(folder.path("other.db"), db::Durability::kNormal);
  other.add_sensor({"S-1", "t", "", db::sha256_hex(""), "", "mine", ""});
  CHECK_FALSE(is_scenario_store(folder.path("other.db")));
}

// Nights in a store: their runs are taken once, and compared with the last ones of the same seeds. No rig: the stores
// of scenarios are written here.

namespace {

Suite suite_of_seeds(int seeds) { return with_seeds(parse_suite(kPartSuite, "s.toml"), seeds); }

struct NightRun {
  std::string purpose = "nightly: one";
  std::int64_t seed = 1;
  std::uint16_t counts = 7;  // of its only frame
};

// The store of one scenario, with these runs; its result has these figures.
ScenarioResult carried_out(const std::string& path, const std::string& label, const std::vector<NightRun>& runs,
                           const std::map<std::string, double>& figures) {
  std::filesystem::remove(path);
  PartStore part(path);
  ScenarioResult result;
  result.name = label;
  result.figures = figures;
  for (const NightRun& own : runs) {
    const std::int64_t number = part.add_run(own.purpose, own.seed, own.counts);
    result.runs.push_back({number, "completed", "", "verified", part.store.run(number).content_sha256});
  }
  return result;
}

// A main store, and nights that are taken into it from a folder.
class KeptNights {
 public:
  KeptNights() : store_(db::RunStore::open(folder_.path("main.db"), db::Durability::kNormal)) {}
  // Whether anything of the night was not there yet.
  bool take(const Suite& suite, std::vector<ScenarioResult>& results, const std::string& begun_utc) {
    return store_night(part_night(begun_utc, "2026-01-03T00:00:00Z"), suite, results, in_stores_of(folder_.path()),
                       store_);
  }
  ScenarioResult made(const std::string& label, const std::vector<NightRun>& runs,
                      const std::map<std::string, double>& figures) const {
    return carried_out(folder_.path(label + ".db"), label, runs, figures);
  }
  [[nodiscard]] const db::RunStore& store() const { return store_; }

 private:
  TemporaryFolder folder_;
  db::RunStore store_;
};

// One scenario's night, taken and compared.
ScenarioResult night_of_one(KeptNights& nights, const std::vector<NightRun>& runs,
                            const std::map<std::string, double>& figures, const std::string& begun_utc) {
  std::vector<ScenarioResult> results{nights.made("one", runs, figures)};
  CHECK(nights.take(suite_of_seeds(1), results, begun_utc));
  (void)compare_night(suite_of_seeds(1), results, nights.store());
  return results[0];
}

// The run that the scenario was compared with, 0: none. Other frames are told with the commit that measured the
// earlier.
std::int64_t compared_with(const ScenarioResult& result) {
  const std::size_t digits = result.compared.find_first_of("0123456789");
  return digits == std::string::npos ? 0 : std::stoll(result.compared.substr(digits));
}
bool other_frames(const ScenarioResult& result) { return result.compared.find("0123456789ab") != std::string::npos; }
bool is_first(const ScenarioResult& result) { return !result.compared.empty() && compared_with(result) == 0; }
bool same_as(const ScenarioResult& result, int run) { return compared_with(result) == run && !other_frames(result); }
bool changed_since(const ScenarioResult& result, int run) {
  return compared_with(result) == run && other_frames(result);
}

using TextLines = std::vector<std::string>;

}  // namespace

TEST_CASE("kept nights: the runs of a night are stored once, with tag, values and results") {
  KeptNights nights;
  std::vector<ScenarioResult> results{
      nights.made("one", {{}}, {{"a", 2.0}}),
      nights.made("two", {{.purpose = "nightly: two"}, {.purpose = "nightly: two"}}, {{"b", 3.0}})};
  ScenarioResult none;
  none.name = "three";  // broke off before its first run
  results.push_back(none);
  const std::vector<ScenarioResult> before = results;
  CHECK(nights.take(suite_of_seeds(1), results, "2026-01-02T00:00:00Z"));
  CHECK(results[0].runs[0].run == 1);
  CHECK((results[1].runs[0].run == 2 && results[1].runs[1].run == 3));
  const std::vector<db::RunRecord> runs = nights.store().runs();
  REQUIRE(runs.size() == 3);
  for (const db::RunRecord& run : runs) CHECK(nights.store().run(run.run).tags == TextLines{"nightly"});
  CHECK(nights.store().figures_of(1, "nightly/one") == std::map<std::string, double>{{"a", 2.0}});
  CHECK(nights.store().figures_of(2, "nightly/two") == std::map<std::string, double>{{"b", 3.0}});
  CHECK(nights.store().figures_of(3, "nightly/two").empty());
  REQUIRE(nights.store().nights().size() == 1);
  const std::vector<db::NightResultRecord> rows = nights.store().nights()[0].results;
  REQUIRE(rows.size() == 3);
  CHECK((rows[0].position == 0 && rows[0].first_run == 1 && rows[0].label == "one"));
  CHECK((rows[1].position == 1 && rows[1].first_run == 2));
  CHECK((rows[2].position == 2 && rows[2].first_run == 0));
  CHECK(result_from_json(rows[1].json).runs[1].run == 3);
  // The same again, and the same of another hour.
  std::vector<ScenarioResult> again = before;
  CHECK_FALSE(nights.take(suite_of_seeds(1), again, "2026-01-02T00:00:00Z"));
  CHECK(again[1].runs[1].run == 3);
  CHECK(nights.store().runs().size() == 3);
  again = before;
  CHECK(nights.take(suite_of_seeds(1), again, "2026-01-02T01:00:00Z"));
  CHECK(nights.store().runs().size() == 3);
  CHECK(nights.store().nights().size() == 2);
}

TEST_CASE("fixed seeds: a night is compared with the last one: none, equal frames with other values, other frames") {
  KeptNights nights;
  const std::map<std::string, double> figures = {{"a", 2.0}, {"b", 5.0}, {"c", 1.0}, {"d", 0.0}};
  const ScenarioResult first = night_of_one(nights, {{}}, figures, "2026-01-02T00:00:00Z");
  CHECK(is_first(first));
  CHECK((first.remarks.empty() && first.wrong.empty()));
  const ScenarioResult second = night_of_one(
      nights, {{}}, {{"a", 2.5}, {"c", 1.0000000009}, {"d", 0.0}, {"e", 4.0}, {"f", 4.0}}, "2026-01-03T00:00:00Z");
  CHECK(same_as(second, 1));
  REQUIRE(second.remarks.size() == 3);  // another, one missing, two more
  CHECK_THAT(second.remarks[0], Catch::StartsWith("a is 2.5") && Catch::Contains("2 in run 1"));
  CHECK_THAT(second.remarks[1], Catch::StartsWith("b ") && Catch::Contains("run 1"));
  CHECK_THAT(second.remarks[2], Catch::StartsWith("2 figures"));
  const ScenarioResult third = night_of_one(
      nights, {{}}, {{"a", 2.5}, {"c", 1.0000000029}, {"d", 1e-300}, {"e", 4.0}, {"f", 4.0}}, "2026-01-04T00:00:00Z");
  CHECK(same_as(third, 2));
  REQUIRE(third.remarks.size() == 2);  // beyond a billionth
  CHECK((third.remarks[0].starts_with("c ") && third.remarks[1].starts_with("d is 1e-300")));
  const ScenarioResult fourth = night_of_one(nights, {{.counts = 8}}, {{"a", 9.0}}, "2026-01-05T00:00:00Z");
  CHECK(changed_since(fourth, 3));
  REQUIRE(fourth.remarks.size() == 1);
  CHECK_THAT(fourth.remarks[0],
             Catch::Contains("run 3") && Catch::Contains("2026-01-02") && Catch::Contains("0123456789ab"));
  CHECK(is_first(night_of_one(nights, {{.seed = 2}}, {{"a", 9.0}}, "2026-01-06T00:00:00Z")));
}

TEST_CASE("fixed seeds: held-out runs are compared one by one, runs of another purpose are ignored") {
  KeptNights nights;
  const std::vector<NightRun> two{{}, {.seed = 1'000'001, .counts = 9}};
  (void)night_of_one(nights, two, {{"a", 2.0}}, "2026-01-02T00:00:00Z");
  CHECK(same_as(night_of_one(nights, two, {{"a", 2.0}}, "2026-01-03T00:00:00Z"), 1));
  const std::vector<NightRun> other{{}, {.seed = 1'000'001, .counts = 10}};
  CHECK(changed_since(night_of_one(nights, other, {{"a", 2.0}}, "2026-01-04T00:00:00Z"), 3));
  // The first run alone: it is the same.
  CHECK(same_as(night_of_one(nights, {{}}, {{"a", 2.0}}, "2026-01-05T00:00:00Z"), 5));
  // Run 7 has no second one behind it: the next is of the night that is compared.
  CHECK(changed_since(night_of_one(nights, two, {{"a", 2.0}}, "2026-01-06T00:00:00Z"), 7));
}

TEST_CASE("kept nights: a night of several seeds lists each scenario once, with the values of the newest seed") {
  KeptNights nights;
  const Suite suite = suite_of_seeds(2);
  std::vector<ScenarioResult> results{nights.made("one-seed-1", {{}}, {{"a", 2.0}}),
                                      nights.made("one-seed-2", {{.seed = 2}}, {{"a", 3.0}}),
                                      nights.made("two-seed-1", {{.purpose = "nightly: two"}}, {{"a", 4.0}})};
  ScenarioResult none;
  none.name = "two-seed-2";
  results.push_back(none);
  CHECK(nights.take(suite, results, "2026-01-02T00:00:00Z"));
  const std::vector<SubjectTrend> followed = compare_night(suite, results, nights.store());
  REQUIRE(followed.size() == 2);
  CHECK(followed[0].subject == "nightly/one");
  REQUIRE(followed[0].figures.size() == 1);
  CHECK(followed[0].figures[0].values == std::vector<double>{2.0, 3.0});
  CHECK(followed[0].run == 2);
  CHECK(followed[1].subject == "nightly/two");
  CHECK(followed[1].figures[0].values == std::vector<double>{4.0});
  CHECK((is_first(results[0]) && is_first(results[2])));
  CHECK(results[3].compared.empty());
}

// Fits, verdicts and figures that were made of a run in another store since it was copied: what is taken, once.

namespace {

db::FitRecord fit_of_run(std::int64_t run) {
  db::FitRecord fit;
  fit.run = run;
  fit.model = "elam";
  fit.document = R"({"c":1})";
  fit.made_by = "a build";
  fit.program_version = "1";
  fit.created_utc = "2026-01-03T00:00:00Z";
  return fit;
}

db::VerdictRecord taken_row(const std::string& limits, const std::string& verdict) {
  db::VerdictRecord row;
  row.criterion = "mean_compensation_error";
  row.verdict = verdict;
  row.limits_toml = limits;
  row.limits_sha256 = db::sha256_hex(limits);
  return row;
}

// Run 1 of `there` is run 2 of `here`.
class TwoStores {
 public:
  TwoStores() {
    (void)here.add_run("before", 1);
    (void)there.add_run("both", 2);
    (void)here.store.copy_runs_from(there.store, {1});
  }
  std::size_t take() { return bench::copy_fits(there.store, 1, here.store, 2); }
  [[nodiscard]] std::string verdicts() const {
    std::string text;
    for (const db::VerdictRecord& row : here.store.verdicts(2))
      text += fmt::format("{} {} {}; ", row.fit, row.limits_toml, row.verdict);
    return text;
  }

 private:
  TemporaryFolder folder_;

 public:
  PartStore there{folder_.path("there.db")}, here{folder_.path("here.db")};
};

}  // namespace

TEST_CASE("merged fits: fits missing here are copied, with their verdicts for each limits file") {
  TwoStores made;
  CHECK(made.take() == 0);
  const std::int64_t first = made.there.store.add_fit(fit_of_run(1));
  made.there.store.replace_verdicts(1, first, {taken_row("a", "pass"), taken_row("a", "fail")});
  made.there.store.replace_verdicts(1, first, {taken_row("b", "inconclusive")});
  made.there.store.replace_verdicts(1, 0, {taken_row("c", "pass")});  // without a fit: not taken
  CHECK(made.take() == 1);
  REQUIRE(made.here.store.fits(2).size() == 1);
  CHECK(made.here.store.fits(2)[0].document == R"({"c":1})");
  const std::string all = made.verdicts();
  CHECK_THAT(
      all, Catch::Contains("1 a pass; 1 a fail; ") && Catch::Contains("1 b inconclusive; ") && !Catch::Contains(" c "));
  CHECK(made.take() == 0);
  CHECK(made.verdicts() == all);
  CHECK(made.here.store.fits(1).empty());
}

TEST_CASE("merged fits: two fits differ if any of their texts differs") {
  TwoStores made;
  (void)made.here.store.add_fit(fit_of_run(2));
  (void)made.there.store.add_fit(fit_of_run(1));
  CHECK(made.take() == 0);
  int expected = 0;
  for (std::string db::FitRecord::*text : {&db::FitRecord::model, &db::FitRecord::document, &db::FitRecord::made_by,
                                           &db::FitRecord::program_version, &db::FitRecord::created_utc}) {
    db::FitRecord other = fit_of_run(1);
    other.*text = R"({"x":1})";
    (void)made.there.store.add_fit(other);
    CHECK(made.take() == 1);
    CHECK(made.here.store.fits(2).size() == static_cast<std::size_t>(++expected) + 1);
  }
}

TEST_CASE("merged fits: values are copied for subjects that have none here") {
  TwoStores made;
  made.here.store.replace_figures(2, "rig/a", {{"a_psi", 1.0}});
  made.there.store.replace_figures(1, "rig/a", {{"a_psi", 2.0}});
  made.there.store.replace_figures(1, "rig/b", {{"b_psi", 3.0}});
  CHECK(made.take() == 0);
  CHECK(made.here.store.figures_of(2, "rig/a").at("a_psi") == 1.0);
  CHECK(made.here.store.figures_of(2, "rig/b").at("b_psi") == 3.0);
}

TEST_CASE("merged fits: if a fit of a run was altered, nothing of that run is copied") {
  TwoStores made;
  (void)made.there.store.add_fit(fit_of_run(1));
  db::sqlite::Connection(made.there.store.path(), db::sqlite::Access::kReadWrite)
      .execute("UPDATE fits SET program_version = '2'");
  try {
    (void)made.take();
    FAIL("it was taken");
  } catch (const db::StoreError& error) {
    CHECK(error.id() == "TB-STORE-CONFLICT");
    CHECK_THAT(error.what(), Catch::Contains(made.there.store.path()) && Catch::Contains("run 1"));
  }
  CHECK(made.here.store.fits(2).empty());
}
