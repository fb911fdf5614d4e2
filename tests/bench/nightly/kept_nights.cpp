// Nights in a store: their runs are taken once, and compared with the last ones of the same seeds. No rig: the stores
// of scenarios are written here.
#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <filesystem>
#include <string>
#include <vector>

#include "bench/nightly/night_store.h"
#include "bench/nightly/suite.h"
#include "tests/bench/nightly/part_store.h"

using namespace tactbench;
using namespace tactbench::bench;
using namespace tactbench::tests;

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
    return take_night(part_night(begun_utc, "2026-01-03T00:00:00Z"), suite, results, in_stores_of(folder_.path()),
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

TEST_CASE("a night's runs are taken once, with its tag, its figures and its results") {
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

TEST_CASE("fixed seeds: the first night, one that repeats its frames with other figures, one of other frames") {
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

TEST_CASE("fixed seeds: held-out runs count as well, one by one, and runs of another purpose are none of them") {
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

TEST_CASE("a night of several seeds shows each scenario once, with the newest seed's figures") {
  KeptNights nights;
  const Suite suite = suite_of_seeds(2);
  std::vector<ScenarioResult> results{nights.made("one-seed-1", {{}}, {{"a", 2.0}}),
                                      nights.made("one-seed-2", {{.seed = 2}}, {{"a", 3.0}}),
                                      nights.made("two-seed-1", {{.purpose = "nightly: two"}}, {{"a", 4.0}})};
  ScenarioResult none;
  none.name = "two-seed-2";
  results.push_back(none);
  CHECK(nights.take(suite, results, "2026-01-02T00:00:00Z"));
  const std::vector<Followed> followed = compare_night(suite, results, nights.store());
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
