// db snapshot and db migrate: what they print, tell as JSON and leave behind.
#include <catch2/catch.hpp>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/bench/cli/verb_here.h"
#include "tests/db/store_example.h"

using namespace tactbench;
using namespace tactbench::tests;
using Told = nlohmann::ordered_json;

namespace {

struct StoreForDb {
  StoreForDb() {
    db::RunStore store = db::RunStore::open(path, db::Durability::kNormal);
    (void)store_example(store);
  }
  Finished db(std::vector<std::string> words) const {
    words.insert(words.begin(), "db");
    words.insert(words.end(), {"--db", path});
    return verb_here(bench::add_db, words);
  }
  TemporaryFolder folder;
  std::string path = folder.path("runs.db");
};

}  // namespace

TEST_CASE("db snapshot: a copy with its length, never over a file that exists") {
  const StoreForDb of;
  const std::string copy = of.folder.path("copy.db"), second = of.folder.path("second.db");
  const Finished made = of.db({"snapshot", copy});
  CHECK(made.code == 0);
  CHECK(made.out ==
        copy + ": snapshot of " + of.path + ", " + std::to_string(std::filesystem::file_size(copy)) + " bytes\n");
  CHECK(db::RunStore::open_read_only(copy).run(1).content_sha256 ==
        db::RunStore::open_read_only(of.path).run(1).content_sha256);
  CHECK(of.db({"snapshot", copy}).code != 0);
  const Told told = Told::parse(of.db({"snapshot", second, "--json"}).out);
  CHECK(told == Told{{"schema", "tactbench.db.snapshot"},
                     {"version", 1},
                     {"store", of.path},
                     {"snapshot", second},
                     {"bytes", std::filesystem::file_size(second)}});
}

TEST_CASE("db migrate: a store of this program's schema stays as it is") {
  const StoreForDb of;
  const std::string schema = std::to_string(db::kSchemaVersion);
  const Finished done = of.db({"migrate"});
  CHECK(done.code == 0);
  CHECK(done.out == of.path + " already has this program's schema " + schema + ": nothing was done\n");
  const Told told = Told::parse(of.db({"migrate", "--json"}).out);
  CHECK(told.at("store") == of.path);
  CHECK(told.at("schema_before") == db::kSchemaVersion);
  CHECK(told.at("backup") == "");
}
