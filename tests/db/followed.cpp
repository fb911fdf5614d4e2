// Figures, baselines and approved reports: kept beside runs, not part of their content.
#include <catch2/catch.hpp>
#include <cmath>

#include "tests/db/store_example.h"
#include "tests/support/process.h"

using namespace tactbench;
using namespace tactbench::tests;
using db::RunStore;

namespace {

std::int64_t with_seed(RunStore& store, std::int64_t seed) {
  db::RunRecord record = example_run();
  record.seed = seed;
  return store_example(store, record);
}

}  // namespace

TEST_CASE("figures are replaced as a whole, by run and subject, and those of void runs are not listed") {
  const TemporaryFolder folder;
  RunStore store = RunStore::open(folder.path("runs.db"));
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

TEST_CASE("a baseline needs runs with figures of its subject, a reason and a name") {
  const TemporaryFolder folder;
  RunStore store = RunStore::open(folder.path("runs.db"));
  const std::int64_t first = with_seed(store, 1), second = with_seed(store, 2), third = with_seed(store, 3);
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

TEST_CASE("runs that repeat one another count once, and alone they are not a baseline") {
  const TemporaryFolder folder;
  RunStore store = RunStore::open(folder.path("runs.db"));
  // 1 and 2: the same content; 3: another seed and the same figures, one of them not-a-number; 4: other figures.
  std::vector<std::int64_t> runs;
  for (const std::int64_t seed : {1, 1, 3, 4}) {
    runs.push_back(with_seed(store, seed));
    store.replace_figures(runs.back(), "nightly/a",
                          {{"x_psi", seed == 4 ? 1.1 : 1.0}, {"dead_taxels", 0.0}, {"y_mv", std::nan("")}});
  }
  using Repeated = std::map<std::int64_t, std::int64_t>;
  CHECK(store.repeated_runs("nightly/a", runs) == Repeated{{2, 1}, {3, 1}});
  CHECK(store.repeated_runs("nightly/a", {4, 3, 3}).empty());
  const auto accepted = [&](const std::vector<std::int64_t>& named, std::string* message = nullptr) {
    return store_error([&] { store.add_baseline({0, "nightly/a", "as made", "K. Lee", "2026", named}); }, message);
  };
  std::string message;
  CHECK(accepted({1, 2, 3}, &message) == "TB-STORE-CONFLICT");
  CHECK(store.baselines().empty());
  CHECK(accepted({1, 1}).empty());  // one run, named twice: accepted, but nothing is judged by it yet
  CHECK(accepted(runs).empty());
  CHECK(store.baselines().back().runs == runs);
}

TEST_CASE("a report is approved once, by name, and is copied with its run") {
  const TemporaryFolder folder;
  RunStore store = RunStore::open(folder.path("runs.db"));
  const std::int64_t run = store_example(store);
  const db::ReportRecord report{run, "1-0a1b2c3d", "0a1b2c3d", "K. Lee", "2026-01-01T00:00:00Z", "", ""};
  store.add_report(report);
  CHECK(store_error([&] { store.add_report(report); }) == "TB-STORE-CONFLICT");
  for (const char* nobody : {"", " \t"})
    CHECK(store_error([&] {
            store.add_report({run, "1-ffffffff", "ff", nobody, "2026", "", ""});
          }) == "TB-STORE-BLANK");
  store.add_report({run, "1-ffffffff", "ff", "M. Ito", "2026-01-02T00:00:00Z", "1-0a1b2c3d", "serial corrected"});
  store.replace_figures(run, "sensor", {{"x_psi", 1.0}});
  RunStore other = RunStore::open(folder.path("other.db"));
  store_example(other);
  const std::int64_t copied = other.copy_runs_from(store, {run}).front();
  const std::vector<db::ReportRecord> reports = other.reports(copied);
  REQUIRE(reports.size() == 2);
  CHECK((reports[0].number == "1-0a1b2c3d" && reports[1].replaces == "1-0a1b2c3d" && reports[1].run == copied));
  CHECK((reports[0].reason.empty() && reports[1].reason == "serial corrected"));
  REQUIRE(other.figures("sensor").size() == 1);
  CHECK(other.figures("sensor")[0].run == copied);
}
