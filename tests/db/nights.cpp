// Nights, baselines that were taken over, and what finds runs and figures for a merge: each by answers worked out by
// hand.
#include <catch2/catch.hpp>
#include <cmath>

#include "tests/db/new_store.h"

using namespace tactbench;
using namespace tactbench::tests;
using db::RunStore;
using Words = std::vector<std::string>;
using Figures = std::map<std::string, double>;

namespace {

std::int64_t seeded(RunStore& store, std::int64_t seed, std::int64_t sensor_seed) {
  db::RunRecord record = example_run();
  record.seed = seed;
  record.sensor_seed = sensor_seed;
  return store_example(store, record);
}

}  // namespace

TEST_CASE("nights: each field of each night reads back, with the results of its own night") {
  NewStore store;
  const std::int64_t run = store_example(store);
  db::NightRecord first{
      0, "small", "small.toml", "schema = 1\n", R"({"seeds":2})", 2, 3, "begun one", "end one", "program one", {}};
  first.results = {{7, "g", R"({"x":1})", run}, {1, "a", "{}", 0}};
  db::NightRecord second{0, "large",     "large.toml", "schema = 2\n", "{}", 1,
                         1, "begun two", "end two",    "program two",  {}};
  second.results = {{0, "z", R"({"y":2})", 0}};
  CHECK(store.nights().empty());
  CHECK(store.add_night(first) == 1);
  CHECK(store.add_night(second) == 2);
  const std::vector<db::NightRecord> nights = store.nights();
  REQUIRE(nights.size() == 2);
  CHECK((nights[0].night == 1 && nights[0].suite == "small" && nights[0].suite_file == "small.toml"));
  CHECK((nights[0].suite_toml == "schema = 1\n" && nights[0].selection_json == R"({"seeds":2})"));
  CHECK((nights[0].shard == 2 && nights[0].shards == 3 && nights[0].program == "program one"));
  CHECK((nights[0].begun_utc == "begun one" && nights[0].ended_utc == "end one"));
  REQUIRE(nights[0].results.size() == 2);  // in the order of their positions
  CHECK((nights[0].results[0].position == 1 && nights[0].results[0].label == "a"));
  CHECK((nights[0].results[0].first_run == 0 && nights[0].results[0].json == "{}"));
  CHECK((nights[0].results[1].position == 7 && nights[0].results[1].label == "g"));
  CHECK((nights[0].results[1].first_run == run && nights[0].results[1].json == R"({"x":1})"));
  CHECK((nights[1].night == 2 && nights[1].suite == "large" && nights[1].suite_file == "large.toml"));
  CHECK((nights[1].shard == 1 && nights[1].shards == 1 && nights[1].ended_utc == "end two"));
  REQUIRE(nights[1].results.size() == 1);
  CHECK((nights[1].results[0].label == "z" && nights[1].results[0].json == R"({"y":2})"));
}

TEST_CASE("nights: a night that is refused half way leaves nothing") {
  NewStore store;
  db::NightRecord night{0, "small", "f", "t", "{}", 1, 1, kUtc, kUtc, "p", {}};
  night.results = {{0, "a", "{}", 0}, {0, "a again", "{}", 0}};
  CHECK(store_error([&] { store.add_night(night); }) == "TB-STORE-CONFLICT");
  CHECK(store.nights().empty());
  night.results = {{0, "a", "{}", 99}};  // of a run that nobody has
  CHECK(store_error([&] { store.add_night(night); }) == "TB-STORE-CONFLICT");
  night.results = {{0, "a", "{}", 0}};
  CHECK(store.add_night(night) == 1);
}

TEST_CASE("run lookup: a run is found by its UUID, and an unknown UUID finds no run") {
  NewStore store;
  CHECK(store.run_of_uuid("") == 0);
  const std::int64_t first = store_example(store), second = store_example(store);
  CHECK(store.run_of_uuid(store.run(first).uuid) == first);
  CHECK(store.run_of_uuid(store.run(second).uuid) == second);
  CHECK(store.run_of_uuid(store.run(first).uuid + "0") == 0);
}

TEST_CASE("run lookup: the last run of a subject has both seeds and statistics, is earlier, and is not void") {
  NewStore store;
  const std::int64_t first = seeded(store, 1, 2), second = seeded(store, 1, 2), third = seeded(store, 1, 3),
                     fourth = seeded(store, 2, 2);
  CHECK(store.last_run_of("a", 1, 2, 99) == 0);
  for (const std::int64_t run : {first, second, third, fourth}) store.replace_figures(run, "a", {{"x", 1.0}});
  store.replace_figures(first, "b", {{"x", 1.0}});
  CHECK(store.last_run_of("a", 1, 2, 99) == second);
  CHECK(store.last_run_of("a", 1, 2, second + 1) == second);
  CHECK(store.last_run_of("a", 1, 2, second) == first);
  CHECK(store.last_run_of("a", 1, 2, first) == 0);
  CHECK(store.last_run_of("a", 1, 3, 99) == third);
  CHECK(store.last_run_of("a", 2, 2, 99) == fourth);
  CHECK(store.last_run_of("a", 2, 3, 99) == 0);
  CHECK(store.last_run_of("b", 1, 2, 99) == first);
  store.void_run(second, "gauge closed", "K. Lee", kUtc);
  CHECK(store.last_run_of("a", 1, 2, 99) == first);
}

TEST_CASE("statistics: subjects are listed once and in order, also per run, and values by run and subject") {
  NewStore store;
  const std::int64_t first = seeded(store, 1, 2), second = seeded(store, 3, 4);
  CHECK(store.subjects().empty());
  CHECK(store.subjects_of(first).empty());
  store.replace_figures(first, "b", {{"x_psi", 0.5}, {"y", 2.0}});
  store.replace_figures(first, "a", {{"x_psi", 1.5}});
  store.replace_figures(second, "c", {{"x_psi", 2.5}});
  store.replace_figures(second, "a", {{"x_psi", 3.5}});
  CHECK(store.subjects() == Words{"a", "b", "c"});
  CHECK(store.subjects_of(first) == Words{"a", "b"});
  CHECK(store.subjects_of(second) == Words{"a", "c"});
  CHECK(store.subjects_of(99).empty());
  CHECK(store.figures_of(first, "b") == Figures{{"x_psi", 0.5}, {"y", 2.0}});
  CHECK(store.figures_of(first, "a") == Figures{{"x_psi", 1.5}});
  CHECK(store.figures_of(second, "a") == Figures{{"x_psi", 3.5}});
  CHECK(store.figures_of(second, "b").empty());
  CHECK(store.figures_of(99, "a").empty());
}

TEST_CASE("baselines: an imported baseline reads back unchanged, and the last one is the one accepted last") {
  NewStore store;
  const std::int64_t first = seeded(store, 1, 2), second = seeded(store, 3, 4);
  CHECK_FALSE(store.last_baseline("rig"));
  CHECK(store.copy_baseline({0, "rig", "new film", "K. Lee", "2026-02-02", {second, first}}) == 1);
  CHECK(store.copy_baseline({0, "rig", "as made", "M. Ito", "2026-01-01", {first}}) == 2);
  CHECK(store.copy_baseline({0, "sensor", "other", "M. Ito", "2026-03-03", {second}}) == 3);
  const auto last = store.last_baseline("rig");
  REQUIRE(last);
  CHECK((last->baseline == 1 && last->subject == "rig" && last->reason == "new film"));
  CHECK((last->accepted_by == "K. Lee" && last->accepted_utc == "2026-02-02"));
  CHECK(last->runs == std::vector<std::int64_t>{first, second});
  REQUIRE(store.last_baseline("sensor"));
  CHECK(store.last_baseline("sensor")->runs == std::vector<std::int64_t>{second});
  CHECK_FALSE(store.last_baseline("none"));
  // Of two that were accepted at one time the later one counts.
  CHECK(store.copy_baseline({0, "rig", "once more", "K. Lee", "2026-02-02", {second}}) == 4);
  CHECK(store.last_baseline("rig")->baseline == 4);
  CHECK(store.baselines().size() == 4);
  CHECK(store_error([&] {
          store.copy_baseline({0, "rig", "why", "K. Lee", "2026-04-04", {99}});
        }) == "TB-STORE-CONFLICT");
  CHECK(store.baselines().size() == 4);
}

TEST_CASE("statistics: are replaced as a whole per run and subject, and those of void runs are not listed") {
  NewStore store;
  const std::int64_t first = store_example(store), second = store_example(store);
  store.replace_figures(first, "nightly/a", {{"x_psi", 1.0}, {"y_mv", std::nan("")}});
  store.replace_figures(first, "nightly/a", {{"x_psi", 2.0}, {"z", 0.1}});
  store.replace_figures(second, "nightly/a", {{"x_psi", 3.0}});
  store.replace_figures(second, "nightly/b", {{"x_psi", 4.0}});
  const std::vector<db::FigureRecord> figures = store.figures("nightly/a");
  REQUIRE(figures.size() == 3);
  CHECK((figures[0].run == first && figures[0].name == "x_psi" && figures[0].value == 2.0));
  CHECK((figures[1].name == "z" && figures[1].value == 0.1));
  CHECK((figures[2].run == second && figures[2].value == 3.0));
  CHECK(store.figures("").size() == 4);
  store.void_run(second, "valve leaked", "K. Lee", "2026-01-01T00:00:00Z");
  CHECK(store.figures("").size() == 2);
  CHECK(store.check_content(first).holds());
  CHECK(store_error([&] { store.replace_figures(99, "nightly/a", {}); }) == "TB-STORE-NOT-FOUND");
}

TEST_CASE("baselines: a baseline requires runs with statistics of its subject, a reason and a name") {
  NewStore store;
  const std::int64_t first = seeded(store, 1, 0), second = seeded(store, 2, 0), third = seeded(store, 3, 0);
  for (const std::int64_t run : {first, second})
    store.replace_figures(run, "nightly/a", {{"x_psi", static_cast<double>(run)}});
  const db::BaselineRecord good{0, "nightly/a", "as delivered", "K. Lee", "2026-01-01T00:00:00Z", {second, first}};
  const auto refused = [&](auto change) {
    db::BaselineRecord wrong = good;
    change(wrong);
    return store_error([&] { store.add_baseline(wrong); });
  };
  CHECK(refused([](db::BaselineRecord& b) { b.reason = " "; }) == "TB-STORE-BLANK");
  CHECK(refused([](db::BaselineRecord& b) { b.accepted_by.clear(); }) == "TB-STORE-BLANK");
  CHECK(refused([](db::BaselineRecord& b) { b.runs.clear(); }) == "TB-STORE-CONFLICT");
  CHECK(refused([&](db::BaselineRecord& b) { b.runs.push_back(third); }) == "TB-STORE-CONFLICT");
  CHECK(refused([](db::BaselineRecord& b) { b.runs.push_back(99); }) == "TB-STORE-NOT-FOUND");
  CHECK(store.baselines().empty());
  store.add_baseline(good);
  store.add_baseline({0, "nightly/a", "new film", "K. Lee", "2026-01-02T00:00:00Z", {second}});
  const std::vector<db::BaselineRecord> baselines = store.baselines();
  REQUIRE(baselines.size() == 2);
  CHECK(baselines[0].runs == std::vector<std::int64_t>{first, second});
  CHECK((baselines[1].reason == "new film" && baselines[1].runs == std::vector<std::int64_t>{second}));
  store.void_run(second, "valve leaked", "K. Lee", "2026-01-03T00:00:00Z");
  CHECK(refused([&](db::BaselineRecord&) {}) == "TB-STORE-CONFLICT");
}

TEST_CASE("baselines: runs that repeat one another count once, and only repetitions are refused") {
  NewStore store;
  // 1 and 2: the same content; 3: another seed and the same figures, one of them not-a-number; 4: other figures.
  std::vector<std::int64_t> runs;
  for (const std::int64_t seed : {1, 1, 3, 4}) {
    runs.push_back(seeded(store, seed, 0));
    store.replace_figures(runs.back(), "nightly/a",
                          {{"x_psi", seed == 4 ? 1.1 : 1.0}, {"dead_taxels", 0.0}, {"y_mv", std::nan("")}});
  }
  using Repeated = std::map<std::int64_t, std::int64_t>;
  CHECK(store.repeated_runs("nightly/a", runs) == Repeated{{2, 1}, {3, 1}});
  CHECK(store.repeated_runs("nightly/a", {3, 1, 2}) == Repeated{{2, 1}, {3, 1}});  // in whatever order
  CHECK(store.repeated_runs("nightly/a", {4, 3, 3}).empty());
  CHECK(store.repeated_runs("nightly/a", {}).empty());
  const auto accepted = [&](const std::vector<std::int64_t>& named) {
    return store_error([&] { store.add_baseline({0, "nightly/a", "as made", "K. Lee", "2026", named}); });
  };
  CHECK(accepted({1, 2, 3}) == "TB-STORE-CONFLICT");
  CHECK(store.baselines().empty());
  CHECK(accepted({1, 1}).empty());  // one run, named twice: accepted, but nothing is judged by it yet
  CHECK(accepted(runs).empty());
  CHECK(store.baselines().back().runs == runs);
}

TEST_CASE("run copy: approved reports and statistics are copied with their run") {
  NewStore store;
  const std::int64_t run = store_example(store);
  store.add_report({run, "1-0a1b2c3d", "0a1b2c3d", "K. Lee", "2026-01-01T00:00:00Z", "", ""});
  store.add_report({run,
                    "1-ffffffff",
                    "ff",
                    "M. Ito",
                    "2026-01-02T00:00:00Z",
                    "1-0a1b2c3d",
                    "serial corrected",
                    {{run, "c1"}, {9, "c2"}}});
  store.replace_figures(run, "sensor", {{"x_psi", 1.0}});
  NewStore other;
  store_example(other);
  const std::int64_t copied = other.copy_runs_from(store, {run}).front();
  const std::vector<db::ReportRecord> reports = other.reports(copied);
  REQUIRE(reports.size() == 2);
  CHECK((reports[0].number == "1-0a1b2c3d" && reports[1].replaces == "1-0a1b2c3d" && reports[1].run == copied));
  CHECK((reports[0].reason.empty() && reports[1].reason == "serial corrected"));
  REQUIRE(reports[1].evidence.size() == 2);
  CHECK((reports[1].evidence[1].run == 9 && reports[1].evidence[1].content_sha256 == "c2"));
  REQUIRE(other.figures("sensor").size() == 1);
  CHECK(other.figures("sensor")[0].run == copied);
}
