// db snapshot, migrate and check: what they tell as JSON and leave behind.
#include <catch2/catch.hpp>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "db/schema.h"
#include "db/sqlite.h"
#include "tests/bench/cli/store_here.h"

using namespace tactbench;
using namespace tactbench::tests;
using Told = nlohmann::ordered_json;

namespace {

struct StoreForDb : StoreHere {
  StoreForDb() {
    db::RunStore store = open();
    (void)store_example(store);
  }
  Finished copy_to(const std::string& file, std::vector<std::string> more = {}) const {
    more.insert(more.begin(), {"runs", "copy", "--to", file});
    return say(bench::add_runs, more);
  }
};

}  // namespace

TEST_CASE("runs copy of a whole store: a copy with its length, never over a file that exists") {
  const StoreForDb of;
  const std::string copy = of.folder.path("copy.db"), second = of.folder.path("second.db");
  CHECK(of.copy_to(copy).code == 0);
  CHECK(db::RunStore::open_read_only(copy).run(1).content_sha256 ==
        db::RunStore::open_read_only(of.path).run(1).content_sha256);
  check_refusal(of.copy_to(copy), 2, "TB-STORE-EXISTS");
  const Told told = Told::parse(of.copy_to(second, {"--json"}).out);
  CHECK(told == Told{{"schema", "tactbench.runs.copy"},
                     {"version", 1},
                     {"store", of.path},
                     {"to", second},
                     {"bytes", std::filesystem::file_size(second)}});
}

TEST_CASE("db migrate: a store of this program's schema stays as it is") {
  const StoreForDb of;
  CHECK(of.say(bench::add_db, {"db", "migrate"}).code == 0);
  const Told told = Told::parse(of.say(bench::add_db, {"db", "migrate", "--json"}).out);
  CHECK(told.at("store") == of.path);
  CHECK(told.at("schema_before") == db::kSchemaVersion);
  CHECK(told.at("backup") == "");
}

TEST_CASE("db: a missing store is refused, and not made") {
  const TemporaryFolder folder;
  const std::string none = folder.path("none.db");
  check_refusal(verb_here(bench::add_verify, {"verify", "--db", none}), 5, "TB-STORE-OPEN");
  check_refusal(verb_here(bench::add_db, {"db", "migrate", "--db", none}), 5, "TB-STORE-OPEN");
  CHECK_FALSE(std::filesystem::exists(none));
}

TEST_CASE("db migrate: a store whose making was cut off becomes one") {
  const TemporaryFolder folder;
  {  // as a process leaves it that is killed while it makes a store: the journal takes all of it back
    db::sqlite::Connection made(folder.path("made.db"), db::sqlite::Access::kReadWrite);
    made.execute("PRAGMA journal_mode = DELETE; PRAGMA cache_size = 1; BEGIN; PRAGMA application_id = " +
                 std::to_string(db::kApplicationId) + "; CREATE TABLE half (a)");
    for (int i = 0; i < 200; ++i) made.execute("INSERT INTO half VALUES (zeroblob(4000))");
    std::filesystem::copy_file(folder.path("made.db-journal"), folder.path("cut.db-journal"));
    made.execute("COMMIT");
    std::filesystem::copy_file(folder.path("made.db"), folder.path("cut.db"));
  }
  CHECK(verb_here(bench::add_db, {"db", "migrate", "--db", folder.path("cut.db")}).code == 0);
  CHECK(db::RunStore::open_read_only(folder.path("cut.db")).runs().empty());
  CHECK_FALSE(std::filesystem::exists(folder.path("cut.db") + ".schema-0.backup"));
}

TEST_CASE("verify: each run that differs, and runs that have not ended") {
  const StoreForDb of;
  {
    db::RunStore store = of.open();
    (void)store_example(store);
    (void)begin_example(store);
  }
  db::sqlite::Connection(of.path, db::sqlite::Access::kReadWrite)
      .execute("UPDATE frames SET status = 9 WHERE frame = 1000000002");
  CHECK(of.say(bench::add_verify, {"verify"}).code == 5);
  const Told told = Told::parse(of.say(bench::add_verify, {"verify", "--json"}).out);
  CHECK(told.at("holds") == false);
  CHECK(told.at("structure").empty());
  REQUIRE(told.at("runs").size() == 3);
  CHECK(told.at("runs").at(0).at("holds") == false);
  CHECK(told.at("runs").at(0).at("ended") == true);
  CHECK_FALSE(told.at("runs").at(0).at("difference").get<std::string>().empty());
  CHECK(told.at("runs").at(1) == Told{{"run", 2},
                                      {"ended", true},
                                      {"holds", true},
                                      {"pruned", false},
                                      {"frames", 3},
                                      {"difference", ""},
                                      {"beside", Told::array()}});
  CHECK(told.at("runs").at(2).at("ended") == false);
  CHECK(told.at("runs").at(2).at("holds") == true);
}
