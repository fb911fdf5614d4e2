#include <catch2/catch.hpp>

#include <functional>
#include <map>
#include <set>

#include "db/hash_chain.h"
#include "db/sqlite.h"
#include "tests/db/store_example.h"
#include "tests/support/process.h"

using namespace tactbench;
using namespace tactbench::tests;
using db::RunStore;
using db::sqlite::Access;
using db::sqlite::Connection;
using db::sqlite::Statement;

TEST_CASE("SHA-256 gives the known answers of FIPS 180") {
  CHECK(db::sha256_hex("") == "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  CHECK(db::sha256_hex("abc") == "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  CHECK(db::sha256_hex("abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq") ==
        "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1");
  CHECK(db::sha256_hex(std::string(1000000, 'a')) ==
        "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
}

TEST_CASE("the stored hash equals the one recomputed from the rows, by another store object too") {
  const TemporaryFolder folder;
  std::int64_t run = 0;
  {
    RunStore store = RunStore::open(folder.path("runs.db"));
    run = store_example(store);
    CHECK(store.run(run).content_sha256.size() == 64);
    CHECK(store.run(run).content_sha256 == store.content_hash(run));
  }
  const RunStore reader = RunStore::open_read_only(folder.path("runs.db"));
  CHECK(reader.run(run).content_sha256 == reader.content_hash(run));
}

TEST_CASE("a run continued by another process has the hash of one written in one go") {
  const TemporaryFolder folder;
  const auto half = [&](bool reopen) {
    const std::string path = folder.path(reopen ? "two.db" : "one.db");
    RunStore store = RunStore::open(path);
    const Begun begun = begin_example(store);
    store.append_frame(begun.run, example_frame(begun.branch, 0));
    if (reopen) store = RunStore::open(path);
    store.append_frame(begun.run, example_frame(begun.branch, 1));
    store.end_run(begun.run, db::Outcome::kCompleted, "", db::SafeState::kVerified, "");
    CHECK(store.content_hash(begun.run) == store.run(begun.run).content_sha256);
    return store.run(begun.run).content_sha256;
  };
  CHECK(half(false) == half(true));
}

TEST_CASE("UUID, host, wall clock, time zone and run number do not count") {
  const TemporaryFolder folder;
  RunStore one = RunStore::open(folder.path("one.db"));
  RunStore two = RunStore::open(folder.path("two.db"), db::Durability::kNormal);
  store_example(two);  // so that run, branch, frame and event keys differ
  db::RunRecord other = example_run();
  other.uuid = db::new_uuid();
  other.host = "host-b";
  other.time_zone = "UTC";
  other.started_utc = "2025-01-01T00:00:00Z";
  const std::int64_t first = store_example(one), second = store_example(two, other);
  CHECK(first != second);
  CHECK(one.run(first).content_sha256 == two.run(second).content_sha256);
}

// Changes each column of each table of a run and checks that the hash changes. A column added later is covered
// automatically.
TEST_CASE("every canonical column counts, and no other") {
  const TemporaryFolder folder;
  const std::string path = folder.path("runs.db");
  RunStore store = RunStore::open(path);
  const std::int64_t run = store_example(store);
  const std::string hash = store.content_hash(run);
  const std::set<std::string> outside = {
      "runs.uuid",   "runs.host",        "runs.time_zone",      "runs.started_utc", "runs.ended_utc", "runs.tags",
      "runs.notes",  "runs.state",       "runs.content_sha256", "frames.dtype",     "frames.chain",   "runs.seen_utc",
      "runs.rest_s", "runs.void_reason", "runs.void_by",        "runs.void_utc"};
  const std::set<std::string> keys = {"runs.run",        "sequences.run", "devices.run",      "branches.run",
                                      "events.run",      "frames.frame",  "events.event",     "devices.position",
                                      "branches.branch", "checks.run",    "checks.check_row", "series.run"};
  // Where only some values are allowed, or the blob's size must fit.
  const std::map<std::string, std::string> values = {
      {"runs.outcome", "'stopped'"},     {"runs.safe_state", "'failed'"},
      {"branches.void", "1 - void"},     {"runs.git_dirty", "1 - git_dirty"},
      {"frames.branch", "3 - branch"},   {"series.input", "zeroblob(16)"},
      {"series.output", "zeroblob(16)"}, {"frames.counts", "CAST(x'01' || substr(counts, 2) AS BLOB)"}};
  Connection raw(path, Access::kReadWrite);
  raw.execute("PRAGMA foreign_keys = OFF; PRAGMA ignore_check_constraints = ON; PRAGMA synchronous = OFF");
  int tried = 0;
  for (const std::string table : {"runs", "sequences", "devices", "branches", "frames", "events", "checks", "series"}) {
    std::vector<std::pair<std::string, std::string>> columns;
    {
      Statement rows(raw, "SELECT name, type FROM pragma_table_info(?)");
      rows.bind(table);
      while (rows.step()) {
        auto& [name, type] = columns.emplace_back();
        rows.read(name, type);
      }
    }
    for (const auto& [name, type] : columns) {
      const std::string column = table + "." + name;
      if (keys.contains(column)) continue;
      std::string value = '"' + name + "\" || 'x'";
      if (type == "INTEGER") value = '"' + name + "\" + 1";
      if (type == "REAL") value = '"' + name + "\" + 1e-9";
      if (type == "BLOB") value = "zeroblob(32)";
      if (values.contains(column)) value = values.at(column);
      INFO(column << " = " << value);
      db::sqlite::Transaction transaction(raw);
      raw.execute("CREATE TEMP TABLE kept AS SELECT rowid AS id, \"" + name + "\" AS value FROM " + table);
      const std::string row = " WHERE rowid = (SELECT max(rowid) FROM " + table + ")";
      raw.execute("UPDATE " + table + " SET \"" + name + "\" = " + value + row);
      transaction.commit();
      CHECK((store.content_hash(run) == hash) == outside.contains(column));
      raw.execute("UPDATE " + table + " SET \"" + name + "\" = (SELECT value FROM kept WHERE id = " + table +
                  ".rowid); DROP TABLE kept");
      REQUIRE(store.content_hash(run) == hash);
      ++tried;
    }
  }
  CHECK(tried > 55);
}

TEST_CASE("each bit of a blob, each frame, event and branch, and their order count") {
  const TemporaryFolder folder;
  const std::string path = folder.path("runs.db");
  RunStore store = RunStore::open(path);
  const std::int64_t run = store_example(store);
  const std::string hash = store.content_hash(run);
  Connection raw(path, Access::kReadWrite);
  raw.execute("PRAGMA synchronous = OFF");
  const std::int64_t frame = run * 1'000'000'000 + 2;
  std::vector<std::uint8_t> counts;
  {
    Statement row(raw, "SELECT counts FROM frames WHERE frame = ?");
    REQUIRE(row.bind(frame).step());
    row.read(counts);
  }
  const auto write = [&] { Statement(raw, "UPDATE frames SET counts = ? WHERE frame = ?").bind(counts, frame).run(); };
  std::set<std::string> hashes = {hash};
  for (std::size_t bit = 0; bit < counts.size() * 8; ++bit) {
    counts[bit / 8] ^= static_cast<std::uint8_t>(1U << (bit % 8));
    write();
    hashes.insert(store.content_hash(run));
    counts[bit / 8] ^= static_cast<std::uint8_t>(1U << (bit % 8));
  }
  CHECK(hashes.size() == 1 + counts.size() * 8);
  write();
  REQUIRE(store.content_hash(run) == hash);
  const auto differs_in_a_copy = [&](const std::string& change) {
    raw.execute("PRAGMA foreign_keys = OFF; VACUUM INTO '" + folder.path("copy.db") + "'");
    {
      Connection copy(folder.path("copy.db"), Access::kReadWrite);
      copy.execute("PRAGMA foreign_keys = OFF; " + change);
    }
    const bool differs = RunStore::open_read_only(folder.path("copy.db")).content_hash(run) != hash;
    std::filesystem::remove(folder.path("copy.db"));
    return differs;
  };
  CHECK_FALSE(differs_in_a_copy("SELECT 1"));
  CHECK(differs_in_a_copy("DELETE FROM frames WHERE frame = (SELECT max(frame) FROM frames)"));
  CHECK(differs_in_a_copy("DELETE FROM frames"));
  CHECK(differs_in_a_copy("DELETE FROM events WHERE event = 1"));
  CHECK(differs_in_a_copy("DELETE FROM branches WHERE branch = 1"));
  CHECK(differs_in_a_copy("DELETE FROM devices WHERE position = 1"));
  CHECK(differs_in_a_copy("DELETE FROM sequences WHERE sequence = 0"));
  CHECK(differs_in_a_copy("UPDATE events SET event = -event"));
  CHECK(differs_in_a_copy("UPDATE devices SET position = -position"));
  CHECK(differs_in_a_copy("UPDATE frames SET frame = frame + 5 WHERE frame % 10 = 2"));
}

TEST_CASE("the bytes under a link of the chain are unambiguous, and numbers hash as SQLite stores them") {
  db::HashChain chain;
  db::RunRecord one = example_run(), two = example_run();
  one.operator_name = "ab";
  one.purpose = "c";
  two.operator_name = "a";
  two.purpose = "bc";
  CHECK(chain.header(one) != chain.header(two));
  db::FrameRecord frame = example_frame(1, 0), same = frame;
  frame.reference_psi = 0.0;
  same.reference_psi = -0.0;  // SQLite keeps no sign of zero
  CHECK(chain.frame({}, {}, frame) == chain.frame({}, {}, same));
  same.reference_psi = 5e-324;
  CHECK(chain.frame({}, {}, frame) != chain.frame({}, {}, same));
}

TEST_CASE("a reading of -0.0 or not-a-number does not break verification") {
  const TemporaryFolder folder;
  RunStore store = RunStore::open(folder.path("runs.db"));
  const Begun begun = begin_example(store);
  db::FrameRecord frame = example_frame(begun.branch, 0);
  frame.setpoint_psi = -0.0;
  frame.feedback_psi = std::numeric_limits<double>::signaling_NaN();
  frame.reference_psi = -std::numeric_limits<double>::infinity();
  store.append_frame(begun.run, frame);
  store.end_run(begun.run, db::Outcome::kCompleted, "", db::SafeState::kVerified, "");
  CHECK(store.content_hash(begun.run) == store.run(begun.run).content_sha256);
}
