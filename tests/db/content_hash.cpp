#include <openssl/evp.h>

#include <catch2/catch.hpp>
#include <functional>
#include <limits>
#include <map>
#include <set>

#include "db/hash_chain.h"
#include "db/sqlite.h"
#include "tests/db/new_store.h"

using namespace tactbench;
using namespace tactbench::tests;
using db::HashChain;
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
  NewStore store;
  const Begun begun = begin_example(store);
  db::FrameRecord frame = example_frame(begun.branch, 0);
  frame.setpoint_psi = -0.0;
  frame.feedback_psi = std::numeric_limits<double>::signaling_NaN();
  frame.reference_psi = -std::numeric_limits<double>::infinity();
  store.append_frame(begun.run, frame);
  store.end_run(begun.run, db::Outcome::kCompleted, "", db::SafeState::kVerified, "");
  CHECK(store.content_hash(begun.run) == store.run(begun.run).content_sha256);
}

namespace {

db::BranchRecord fourth_attempt() {
  db::BranchRecord branch;
  branch.sequence = 1;
  branch.repeat = 2;
  branch.ordinal = 3;
  branch.attempt = 4;
  branch.from_psi = 0.5;
  return branch;
}

}  // namespace

TEST_CASE("the content of a run hashes to what another program finds") {
  const TemporaryFolder folder;
  db::RunStore store = db::RunStore::open(folder.path("runs.db"));
  const std::int64_t run = store_example(store);
  CHECK(store.run(run).content_sha256 == "058012ec21c9467134fc0dc98492780abafd573ad5ed9fa7f15e0181a6779295");
}

TEST_CASE("header and frames hash to what another program finds") {
  HashChain chain;
  const db::Digest header = chain.header(example_run());
  CHECK(db::hex(header) == "b50aae7688d59992466f0454025f289c15a320d866dbf20c7c3214f7f891f273");
  CHECK(db::hex(chain.frame(header, example_branch(), example_frame(0, 0))) ==
        "79d87add49a56d1d510247fee4b26d545b5045e18a938173fa8e867eff2b6629");
  // Without flags, trace, wrench and counts, and with a pressure that is no number.
  db::FrameRecord bare = example_frame(0, 0);
  bare.feedback_psi = -std::numeric_limits<double>::quiet_NaN();
  bare.counts.clear();
  bare.flags.clear();
  bare.trace.clear();
  bare.wrench.reset();
  CHECK(db::hex(chain.frame({}, fourth_attempt(), bare)) ==
        "0873c62e582ec4fbf2e7c96fe3198705252d535ce2f7734d1b5e29427c06030a");
}

TEST_CASE("the end of a run hashes to what another program finds, with a force at one end of a branch and with none") {
  HashChain chain;
  db::RunEnd end;
  end.branches = {fourth_attempt()};
  CHECK(db::hex(chain.close({}, 0, end)) == "6ab156d05270123364a89c51e1bd9963df2088e0a87c85902b0da5dbf3337fa4");
  end.branches.front().to_n = 2.0;
  CHECK(db::hex(chain.close({}, 0, end)) == "f80818f0d4921084dbc07da1195f53796f23f6f59cb1c4701ca02674253eba12");
  end.branches.front().to_n.reset();
  end.branches.front().from_n = 2.0;
  const db::Digest other = chain.close({}, 0, end);
  end.branches.front().to_n = 2.0;
  CHECK(chain.close({}, 0, end) != other);
}

TEST_CASE("sealed data hash to what another program finds") {
  HashChain chain;
  const db::FitRecord first{3, 1, "elam", true, 256, R"({"p":[-0.0,5e-324]})", "a build", "0.1.0", "2024"};
  db::FitRecord second;
  second.fit = 4;
  second.model = "gpi";
  CHECK(db::hex(chain.fits({first, second})) == "b00d2686459ea5dafe70a98dd8be33f0ea423e27f0ef000d8621bfa626f2ed82");
  const db::VerdictRecord verdict{0, 2, "error", "array", 1.5, 2.5, "psi", "simple", "pass", "limits", "sha"};
  CHECK(db::hex(chain.verdicts({verdict, {}})) == "a43974356ee4ac9669ea24f28d1734557edb99cdfa59c8000741078264a7a455");
  CHECK(db::hex(chain.approvals(
            {{1, "1-a", "ca", "K. Lee", "2024", "", ""}, {1, "1-b", "cb", "M. Ito", "2025", "1-a", ""}})) ==
        "abe096aeb543994bd3cf721612465f65d3f1896f216dba8c82e4c28a7ea14fea");
  db::RunRecord run = example_run();
  run.void_reason = "gauge closed";
  run.void_by = "K. Lee";
  run.void_utc = "2026";
  CHECK(db::hex(chain.voided(run)) == "41b8e56961715f5668775219045d2d45afdb941e26e987a3377de3bba0d0b906");
}

TEST_CASE("without SHA-256 nothing is hashed") {
  REQUIRE(EVP_set_default_properties(nullptr, "provider=none_of_that_name") == 1);
  const std::string id = store_error([] { const HashChain chain; });
  REQUIRE(EVP_set_default_properties(nullptr, "") == 1);
  CHECK(id == "TB-STORE-SQL");
  CHECK(db::sha256_hex("abc").substr(0, 8) == "ba7816bf");
}

TEST_CASE("outcomes and safe states have a word each, and no other word is one") {
  using db::Outcome, db::SafeState;
  const std::vector<std::pair<Outcome, std::string>> outcomes = {
      {Outcome::kIncomplete, "incomplete"}, {Outcome::kCompleted, "completed"}, {Outcome::kStopped, "stopped"},
      {Outcome::kAborted, "aborted"},       {Outcome::kFailed, "failed"},       {Outcome::kInterrupted, "interrupted"}};
  for (const auto& [outcome, word] : outcomes) {
    CHECK(db::to_string(outcome) == word);
    CHECK(db::outcome_from(word) == outcome);
  }
  const std::vector<std::pair<SafeState, std::string>> states = {{SafeState::kUnknown, "unknown"},
                                                                 {SafeState::kVerified, "verified"},
                                                                 {SafeState::kUnverified, "unverified"},
                                                                 {SafeState::kFailed, "failed"}};
  for (const auto& [state, word] : states) {
    CHECK(db::to_string(state) == word);
    CHECK(db::safe_state_from(word) == state);
  }
  CHECK(!db::outcome_from("verified"));
  CHECK(!db::safe_state_from("completed"));
}
