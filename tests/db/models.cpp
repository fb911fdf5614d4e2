// Fits, verdicts, figures, baselines, repetitions and approved reports, by answers worked out by hand.
#include <catch2/catch.hpp>

#include "tests/db/store_example.h"

using namespace tactbench;
using namespace tactbench::tests;
using db::RunStore;
using Figures = std::map<std::string, double>;
using Words = std::vector<std::string>;

TEST_CASE("run store: fits and verdicts read back exactly") {
  NewStore store;
  const std::int64_t run = store_example(store);
  db::FitRecord fit{0, run, "elam", true, 256, R"({"p":[-0.0,5e-324]})", "a build", "0.1.0", "2024-05-02T00:00:00Z"};
  const std::int64_t first = store.add_fit(fit), second = store.add_fit(fit);
  fit.model = "gpi";
  fit.stands = false;
  const std::int64_t rival = store.add_fit(fit);
  CHECK(store.default_fit(run)->fit == second);
  CHECK(store.fits(run).back().fit == rival);
  const db::FitRecord got = store.fit(first);
  CHECK((got.fit == first && got.run == run && got.model == "elam" && got.stands && got.fitted == 256));
  CHECK((got.document == fit.document && got.made_by == "a build" && got.program_version == "0.1.0"));
  CHECK(got.created_utc == fit.created_utc);

  db::VerdictRecord verdict{0, 0, "mpe", "span", 0.1 + 0.2, 1.5, "psi", "guarded", "pass", "limits", "sha"};
  verdict.low_psi = 4.0;
  verdict.high_psi = 40.5;
  verdict.direction = "down";
  verdict.share = 0.95;
  verdict.expanded = 0.1;
  store.replace_verdicts(run, first, {verdict, verdict});
  store.replace_verdicts(run, second, {verdict});
  const std::vector<db::VerdictRecord> verdicts = store.verdicts(run);
  REQUIRE(verdicts.size() == 1);
  CHECK((verdicts[0].run == run && verdicts[0].fit == second && verdicts[0].criterion == verdict.criterion));
  CHECK((verdicts[0].scope_kind == "span" && verdicts[0].value == 0.1 + 0.2 && verdicts[0].limit == 1.5));
  CHECK((verdicts[0].low_psi == 4.0 && verdicts[0].high_psi == 40.5 && verdicts[0].direction == "down"));
  CHECK((verdicts[0].share == 0.95 && verdicts[0].expanded == 0.1));
  CHECK((verdicts[0].unit == "psi" && verdicts[0].rule == "guarded" && verdicts[0].limits_sha256 == "sha"));
  CHECK(store_error([&] { store.replace_verdicts(run, 99, {}); }) == "TB-STORE-NOT-FOUND");
  CHECK(store.verdicts(run).size() == 1);
  CHECK(verdicts[0].model_run == run);
  store.replace_verdicts(run, rival, {verdict});
  REQUIRE(store.verdicts(run).size() == 2);
  CHECK((store.verdicts(run)[0].fit == second && store.verdicts(run)[1].fit == rival));
}

TEST_CASE("run store: verdicts by other limits or by models of another run are not replaced") {
  NewStore store;
  const std::int64_t judged = store_example(store), one = store_example(store), other = store_example(store);
  const auto fit_of_run = [&](std::int64_t run) {
    return store.add_fit({0, run, "elam", true, 1, "{}", "", "0.1.0", "2024-05-02T00:00:00Z"});
  };
  const auto by_limits = [](const char* sha256, const char* word) {
    db::VerdictRecord verdict{0, 0, "mean_compensation_error", "array", 1.0, 1.5, "psi", "simple", word, "l", sha256};
    return std::vector<db::VerdictRecord>{verdict};
  };
  store.replace_verdicts(judged, fit_of_run(one), by_limits("strict", "fail"));
  store.replace_verdicts(judged, fit_of_run(one), by_limits("wide", "pass"));
  store.replace_verdicts(judged, fit_of_run(other), by_limits("strict", "pass"));
  store.replace_verdicts(judged, fit_of_run(one), {});  // report only
  const auto words = [](const std::vector<db::VerdictRecord>& verdicts) {
    std::string text;
    for (const db::VerdictRecord& verdict : verdicts) text += verdict.limits_sha256 + " " + verdict.verdict + "; ";
    return text;
  };
  CHECK(words(store.verdicts(judged)) == "strict fail; wide pass; strict pass; ");
  CHECK(words(store.verdicts_of_models(one)) == "strict fail; wide pass; ");
  CHECK(words(store.verdicts_of_models(other)) == "strict pass; ");
  CHECK(store.verdicts_of_models(judged).empty());
  store.replace_verdicts(judged, fit_of_run(one), by_limits("strict", "inconclusive"));
  CHECK(words(store.verdicts_of_models(one)) == "wide pass; strict inconclusive; ");
  CHECK(store.verdicts_of_models(one).back().model_run == one);
}

TEST_CASE("run lookup: the selected fit of a run is found, else its only one, and an unknown fit is an error") {
  NewStore store;
  const std::int64_t first = store_example(store), second = store_example(store);
  CHECK_FALSE(store.default_fit(first));
  const auto add = [&](std::int64_t run, const std::string& model, bool stands) {
    return store.add_fit({0, run, model, stands, 1, "{}", "", "0.1.0", kUtc});
  };
  CHECK((add(first, "elam", true) == 1 && add(second, "mpi", false) == 2 && add(first, "gpi", false) == 3));
  CHECK(store.default_fit(first)->fit == 1);
  CHECK(store.default_fit(second)->fit == 2);  // the only one
  CHECK(store_error([&] { (void)store.fit(9); }) == "TB-STORE-NOT-FOUND");
}

namespace {

std::int64_t seeded(RunStore& store, std::int64_t seed, std::int64_t sensor_seed = 0,
                    const std::string& origin = "simulated") {
  db::RunRecord record = example_run();
  record.seed = seed;
  record.sensor_seed = sensor_seed;
  record.origin = origin;
  return store_example(store, record);
}

}  // namespace

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

TEST_CASE("baselines: runs that repeat one another count once, a set of repetitions alone is refused") {
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

TEST_CASE("repeated runs: runs without statistics, or open runs with different ones, are not repetitions") {
  NewStore store;
  const std::int64_t one = seeded(store, 1), two = seeded(store, 2);
  CHECK(store.repeated_runs("rig", {one, two}).empty());
  const std::int64_t open = store.begin_run(example_run()), other = store.begin_run(example_run());
  store.replace_figures(open, "rig", {{"x_psi", 1.5}});
  store.replace_figures(other, "rig", {{"x_psi", 2.5}});
  CHECK(store.repeated_runs("rig", {open, other}).empty());
  store.replace_figures(other, "rig", {{"x_psi", 1.5}});
  CHECK(store.repeated_runs("rig", {open, other}) == std::map<std::int64_t, std::int64_t>{{other, open}});
}

TEST_CASE("baselines: a baseline requires a date and runs of one origin") {
  NewStore store;
  const std::int64_t simulated = seeded(store, 1), real = seeded(store, 2, 0, "hardware");
  for (const std::int64_t run : {simulated, real}) {
    store.replace_figures(run, "rig", {{"x_psi", static_cast<double>(run)}});
  }
  const auto added = [&](const std::string& utc, const std::vector<std::int64_t>& runs) {
    return store_error([&] { store.add_baseline({0, "rig", "as made", "K. Lee", utc, runs}); });
  };
  CHECK(added("", {simulated}) == "TB-STORE-CONFLICT");
  CHECK(added(kUtc, {simulated, real}) == "TB-STORE-CONFLICT");
  CHECK(store.baselines().empty());
  CHECK(added(kUtc, {simulated}).empty());
  CHECK(added(kUtc, {real}).empty());
  CHECK(store.baselines().size() == 2);
  // A repetition together with a newly measured run is accepted: one figure has a spread.
  const std::int64_t again = seeded(store, 1), anew = seeded(store, 5);
  store.replace_figures(again, "rig", {{"x_psi", 7.0}});
  store.replace_figures(anew, "rig", {{"x_psi", 8.0}});
  CHECK(added(kUtc, {simulated, again, anew}).empty());
  CHECK(added(kUtc, {simulated, again}) == "TB-STORE-CONFLICT");
}

TEST_CASE("approved reports: a report names the one it replaces and why, and the first names none") {
  NewStore store;
  const std::int64_t run = store_example(store);
  const auto approved = [&](const std::string& number, const std::string& replaces, const std::string& reason) {
    return store_error([&] { store.add_report({run, number, "c", "K. Lee", kUtc, replaces, reason}); });
  };
  CHECK(approved("1-a", "1-0", "why") == "TB-STORE-CONFLICT");
  CHECK(approved("1-a", "", "why") == "TB-STORE-CONFLICT");
  CHECK(approved("1-a", "", "").empty());
  CHECK(approved("1-b", "", "") == "TB-STORE-CONFLICT");
  for (const char* nothing : {"", " \n"}) CHECK(approved("1-b", "1-a", nothing) == "TB-STORE-BLANK");
  CHECK(approved("1-b", "1-a", std::string(db::kMaxTextLength + 1, 'x')) == "TB-STORE-TOO-LONG");
  CHECK(approved("1-b", "1-a", "customer's name corrected").empty());
  CHECK(approved("1-a", "1-b", "why") == "TB-STORE-CONFLICT");
  CHECK(approved("1-c", "1-a", "replaced already") == "TB-STORE-CONFLICT");
  for (const char* nobody : {"", " \t"})
    CHECK(store_error([&] { store.add_report({run, "1-c", "c", nobody, kUtc, "1-b", "why"}); }) == "TB-STORE-BLANK");
  REQUIRE(store.reports(run).size() == 2);
  const db::ReportRecord last = store.reports(run).back();
  CHECK((last.run == run && last.number == "1-b" && last.content_sha256 == "c" && last.approved_by == "K. Lee"));
  CHECK((last.approved_utc == kUtc && last.replaces == "1-a"));
  CHECK((last.reason == "customer's name corrected" && store.reports(run).front().reason.empty()));
  CHECK(store.check_seals(run).empty());
}

TEST_CASE("repeated runs: equal counts are not a repetition, equal content is") {
  NewStore store;
  const std::vector<std::int64_t> runs = {seeded(store, 1), seeded(store, 2), seeded(store, 2)};
  for (const std::int64_t run : runs) store.replace_figures(run, "rig", {{"frames", 124.0}, {"branches_redone", 2.0}});
  CHECK(store.repeated_runs("rig", runs) == std::map<std::int64_t, std::int64_t>{{runs[2], runs[1]}});
}
