// Dates and rules that verbs of the store take, each at its edges, and what db prune tells of runs that are
// known row by row.
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "bench/common/utc.h"
#include "db/sqlite.h"
#include "tests/bench/cli/store_here.h"

using namespace tactbench;
using namespace tactbench::tests;

namespace {

struct StoreOfRules : StoreHere {
  Finished prune(const std::string& rule, const std::vector<std::string>& more = {}) const {
    return verb_here(bench::add_db, joined_words({"db", "prune", "--db", path, "--keep=" + rule}, more));
  }
  Finished since(const std::string& date) const {
    return verb_here(bench::add_runs, {"runs", "list", "--json", "--db", path, "--since=" + date});
  }
};

void add_night_run(db::RunStore& store, const std::string& started, const std::vector<std::string>& tags) {
  db::RunRecord run = example_run();
  run.started_utc = started;
  store.set_tags(store_example(store, run), tags, {});
}

}  // namespace

TEST_CASE("db prune --keep takes days, weeks and dates, at their edges") {
  const StoreOfRules store;
  (void)store.open();
  for (const char* rule : {"1d", "36500d", "1w", "0000-00-00", "9999-99-99"}) {
    INFO(rule);
    CHECK(store.prune(rule).code == 0);
  }
  for (const char* rule :
       {"d",          "0d",         "0w",         "36501d",       "36501w",     "-1d",         "1m",
        "1dd",        "1 d",        "1",          "99999999999d", "2026-01-3",  "2026-01-311", "/026-01-31",
        ":026-01-31", "2026-01-3/", "2026-01-3:", "2026/01-31",   "2026-01/31", "2026-1-311"}) {
    INFO(rule);
    check_refusal(store.prune(rule), 2, "TB-USAGE", "--keep");
  }
  // Of a day of UTC, which may turn meanwhile.
  for (const auto& [rule, days] : std::vector<std::pair<std::string, int>>{{"3d", 3}, {"2w", 14}, {"1d", 1}}) {
    const std::string before = bench::utc_days_ago(days);
    const nlohmann::json told = nlohmann::json::parse(store.prune(rule, {"--json"}).out);
    CHECK((before <= told.at("begin_of_kept") && told.at("begin_of_kept") <= bench::utc_days_ago(days)));
  }
}

TEST_CASE("runs list --since takes a date, with or without a time, or a number of days") {
  const StoreOfRules store;
  {
    db::RunStore open = store.open();
    add_night_run(open, "2024-05-01T09:00:00Z", {});
  }
  const auto lists = [&](const std::string& date) {
    const Finished list = store.since(date);
    CHECK(list.code == 0);
    return nlohmann::json::parse(list.out).at("runs").size() == 1;
  };
  CHECK(lists("2020-01-01"));
  CHECK(lists("36500d"));
  CHECK_FALSE(lists("0d"));
  CHECK(lists("2024-05-01"));
  CHECK(lists("2024-05-01T09:00:00Z"));
  CHECK_FALSE(lists("2024-05-01T09:00:01Z"));
  CHECK_FALSE(lists("2100-01-01"));
  for (const char* date : {"2024-05-0", "2024-05", "/024-05-01", ":024-05-01", "2024-05-0/", "2024-05-0:", "2024/05-01",
                           "2024-05:01", "20240-5-01", "yesterday12", "-1d", "d", "7"}) {
    INFO(date);
    check_refusal(store.since(date), 2, "TB-USAGE", "--since");
  }
}

TEST_CASE("db prune tells what would go, what went and what stays") {
  const StoreOfRules store;
  {
    db::RunStore open = store.open();
    add_night_run(open, "2024-05-01T09:00:00Z", {"nightly"});
    add_night_run(open, "2024-05-01T10:00:00Z", {"nightly", "pinned"});
    add_night_run(open, "2024-05-01T11:00:00Z", {"other"});
    add_night_run(open, "2024-05-01T12:00:00Z", {"nightly"});
    add_night_run(open, "2024-05-02T00:00:00Z", {"nightly"});  // of the first day to keep
    add_night_run(open, "2024-05-02", {"nightly"});
  }
  const nlohmann::json asked = nlohmann::json::parse(store.prune("2024-05-02", {"--json"}).out);
  CHECK(asked.at("done") == false);
  CHECK(asked.at("runs") == nlohmann::json({1, 4}));
  CHECK(asked.at("frames") == 6);
  CHECK(asked.at("bytes") == 0);
  CHECK(asked.at("file_bytes") == asked.at("file_bytes_before"));
  // 3 frames each of 12 counts of 2 bytes, and 2 points of 16 bytes of their traces.
  CHECK(store.prune("2024-05-01T", {}).code == 2);
  CHECK(store.prune("2024-05-02", {"--yes"}).code == 0);
  CHECK(nlohmann::json::parse(store.prune("2024-05-02", {"--yes", "--shrink", "--json"}).out).at("frames") == 0);
  const nlohmann::json told = nlohmann::json::parse(store.prune("2024-05-03", {"--yes", "--json"}).out);
  CHECK(told.at("done") == true);
  CHECK(told.at("runs") == nlohmann::json({5, 6}));
  CHECK(told.at("frames") == 6);
  CHECK(told.at("bytes") == 6 * (24 + 32));
  CHECK(told.at("kept") == nlohmann::json::parse(R"([{"run": 2, "why": "pinned"}])"));
}

TEST_CASE("db prune leaves a damaged run whole") {
  const StoreOfRules store;
  {
    db::RunStore open = store.open();
    add_night_run(open, "2024-05-01T09:00:00Z", {"nightly"});
    add_night_run(open, "2024-05-01T10:00:00Z", {"nightly"});
  }
  db::sqlite::Connection(store.path, db::sqlite::Access::kReadWrite)
      .execute("UPDATE frames SET reference_psi = reference_psi + 1e-9 WHERE rowid = (SELECT min(rowid) FROM frames)");
  CHECK(store.prune("2024-05-02", {"--yes"}).code == 0);
  CHECK(db::RunStore::open_read_only(store.path).frame_count(1) == 3);
}
