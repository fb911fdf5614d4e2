// The hash chain over a run's content by answers that another program computed, what it depends on, and the seals over
// the rows in addition to the content: no change or deletion goes unnoticed.
#include <fmt/format.h>
#include <openssl/evp.h>

#include <array>
#include <bit>
#include <catch2/catch.hpp>
#include <filesystem>
#include <limits>
#include <map>
#include <random>
#include <set>

#include "db/hash_chain.h"
#include "db/sqlite.h"
#include "tests/db/store_example.h"
#include "tests/support/sanitized.h"

using namespace tactbench;
using namespace tactbench::tests;
using db::HashChain;
using db::RunStore;
using db::sqlite::Access;
using db::sqlite::Connection;
using db::sqlite::Statement;

TEST_CASE("SHA-256: gives the published values of FIPS 180") {
  CHECK(db::sha256_hex("") == "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  CHECK(db::sha256_hex("abc") == "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  CHECK(db::sha256_hex("abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq") ==
        "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1");
  CHECK(db::sha256_hex(std::string(1000000, 'a')) ==
        "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
}

TEST_CASE("content hash: a run continued by another process has the hash of one written in one go") {
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

TEST_CASE("content hash: does not depend on UUID, host, wall clock, time zone or run number") {
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
TEST_CASE("content hash: depends on every canonical column, and on no other") {
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

TEST_CASE("content hash: depends on each bit of a blob, each frame, event and branch, and their order") {
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

TEST_CASE("content hash: field boundaries are unambiguous, and numbers hash as SQLite stores them") {
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

TEST_CASE("content hash: a pressure of -0.0, NaN or infinity does not break verification") {
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

TEST_CASE("content hash: a run has the hash that another program computed") {
  const TemporaryFolder folder;
  db::RunStore store = db::RunStore::open(folder.path("runs.db"));
  const std::int64_t run = store_example(store);
  CHECK(store.run(run).content_sha256 == "058012ec21c9467134fc0dc98492780abafd573ad5ed9fa7f15e0181a6779295");
}

TEST_CASE("content hash: header and frames have the hashes that another program computed") {
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

TEST_CASE(
    "content hash: the end of a run has the hash that another program computed, with and without a branch force") {
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

TEST_CASE("content hash: sealed data have the hashes that another program computed") {
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

TEST_CASE("content hash: fails without SHA-256 in the library") {
  REQUIRE(EVP_set_default_properties(nullptr, "provider=none_of_that_name") == 1);
  const std::string id = store_error([] { const HashChain chain; });
  REQUIRE(EVP_set_default_properties(nullptr, "") == 1);
  CHECK(id == "TB-STORE-SQL");
  CHECK(db::sha256_hex("abc").substr(0, 8) == "ba7816bf");
}

// The differences that check_content names, and that it notices every changed byte of content.

namespace {

// All canonical content of a run, as read back, bit for bit.
std::string content_read_back(const RunStore& store, std::int64_t number) {
  std::string text;
  const auto word = [&](const std::string& value) { text += fmt::format("{}:{};", value.size(), value); };
  const auto whole = [&](auto... values) { ((text += fmt::format("{};", values)), ...); };
  const auto real = [&](double value) { text += fmt::format("{:x};", std::bit_cast<std::uint64_t>(value)); };
  const auto reals = [&](const auto& values) {
    whole(values.size());
    for (const double value : values) real(value);
  };
  const db::RunRecord r = store.run(number);
  for (const std::string* value :
       {&r.origin, &r.reason, &r.operator_name, &r.purpose, &r.sensor_serial, &r.scanner_serial, &r.bench_id,
        &r.bench_toml, &r.bench_sha256, &r.sensor_toml, &r.sensor_sha256, &r.overrides_json, &r.program_version,
        &r.git_commit, &r.build_id}) {
    word(*value);
  }
  word(db::to_string(r.outcome));
  word(db::to_string(r.safe_state));
  whole(r.git_dirty, r.seed, r.sensor_seed, r.sequences.size(), r.devices.size());
  for (const db::SequenceRecord& s : r.sequences) {
    for (const std::string* value : {&s.name, &s.recipe_toml, &s.recipe_sha256}) word(*value);
    whole(s.sequence, s.repeats, s.frames_per_repeat);
  }
  for (const db::DeviceRecord& d : r.devices) {
    for (const std::string* value : {&d.role, &d.model, &d.serial, &d.firmware, &d.origin, &d.calibration_json}) {
      word(*value);
    }
  }
  const std::vector<db::BranchRecord> branches = store.branches(number);
  for (const db::BranchRecord& b : branches) {
    whole(b.sequence, b.repeat, b.ordinal, b.attempt, b.is_void, b.from_n.has_value(), b.to_n.has_value());
    word(b.void_reason);
    for (const double value : {b.from_psi, b.to_psi, b.from_n.value_or(0.0), b.to_n.value_or(0.0)}) real(value);
  }
  for (const db::FrameRecord& f : store.frames(number)) {
    std::size_t branch = 0;
    while (branch < branches.size() && branches[branch].branch != f.branch) ++branch;
    whole(branch, f.ordinal, f.setpoint_counts, f.feedback_counts, f.reference_counts, f.time_ns, f.since_command_ns,
          f.in_band_ns, f.device_time_us, f.status, f.exchanges, f.rows, f.columns, f.scans, f.counts.size());
    for (const double value : {f.setpoint_psi, f.feedback_psi, f.reference_psi}) real(value);
    for (const std::uint16_t count : f.counts) whole(count);
    word(f.flags);
    for (const db::TracePoint& p : f.trace) {
      reals(std::array<double, 4>{p.before_frame_s, p.setpoint_psi, p.feedback_psi, p.reference_psi});
    }
    if (!f.wrench) continue;
    real(f.wrench->target_n);
    real(f.wrench->force_start_n);
    reals(f.wrench->wrench);
    reals(f.wrench->raw);
    reals(f.wrench->place_mm);
  }
  for (const db::EventRecord& e : store.events(number)) {
    whole(e.time_ns);
    for (const std::string* value : {&e.kind, &e.id, &e.detail}) word(*value);
  }
  for (const db::CheckRecord& c : store.checks(number)) {
    whole(c.time_ns);
    for (const std::string* value : {&c.kind, &c.verdict, &c.detail_json}) word(*value);
    reals(c.data);
  }
  for (const db::SeriesRecord& s : store.series(number)) {
    whole(s.sequence, s.taxel);
    reals(s.input);
    reals(s.output);
  }
  return text;
}

// A run of many frames, so that most of the file is content.
std::int64_t store_long_example(RunStore& store) {
  const Begun begun = begin_example(store);
  store.set_state(begun.run, "running", {5, "state", "", "prepared -> running"});
  for (int i = 0; i < 100; ++i) {
    db::FrameRecord frame = example_frame(begun.branch, i);
    frame.rows = 12;
    frame.columns = 12;
    frame.counts.clear();
    for (int k = 0; k < 2 * 144; ++k) frame.counts.push_back(static_cast<std::uint16_t>(977 * k + 31 * i));
    store.append_frame(begun.run, frame);
  }
  store.append_check(begun.run, {begun.run, 4, "seating", "pass", R"({"rows":3})", {1.0 / 3.0, 2.5}});
  store.append_series(begun.run, {{0, 3, {0.5, 1.5}, {2.5, 3.5}}});
  store.end_run(begun.run, db::Outcome::kCompleted, "all steps done", db::SafeState::kVerified, "2024-05-01T10:00:00Z");
  return begun.run;
}

void remove_store(const std::string& path) {
  for (const char* ending : {"", "-wal", "-shm", "-journal"}) std::filesystem::remove(path + ending);
}

std::string changed(RunStore& store, std::int64_t run, const std::string& sql) {
  Connection raw(store.path(), Access::kReadWrite);
  raw.execute("PRAGMA foreign_keys = OFF; PRAGMA ignore_check_constraints = ON; BEGIN; " + sql + "; COMMIT");
  return store.check_content(run).difference;
}

}  // namespace

TEST_CASE("content check: the first difference is named") {
  const auto named = [](const std::string& sql) {
    const TemporaryFolder folder;
    RunStore store = RunStore::open(folder.path("runs.db"));
    db::RunRecord record = example_run();
    for (db::SequenceRecord& sequence : record.sequences) {
      sequence.recipe_sha256 = db::sha256_hex(sequence.recipe_toml);
    }
    const std::int64_t run = store_example(store, record);
    return changed(store, run, sql);
  };
  using Catch::Contains;
  CHECK_THAT(named("UPDATE frames SET reference_psi = 7 WHERE frame % 10 = 2"),
             Contains("frame 2 (sequence 1 'down', repeat 0, branch 0, attempt 1, step 0): its row"));
  CHECK_THAT(named("UPDATE frames SET status = 7 WHERE frame % 10 > 1"), Contains("frame 2 "));
  CHECK_THAT(named("UPDATE branches SET ordinal = 9 WHERE attempt = 1"), Contains("frame 2 ") && Contains("branch 9"));
  CHECK_THAT(named("UPDATE frames SET branch = 77 WHERE frame % 10 = 3"), Contains("frame 3 (of no branch"));
  CHECK_THAT(named("DELETE FROM frames WHERE frame % 10 = 2"), Contains("frame 2 is missing"));
  CHECK_THAT(named("UPDATE frames SET status = 7 WHERE frame % 10 = 1"), Contains("run's row") && Contains("frame 1"));
  CHECK_THAT(named("UPDATE runs SET operator = 'X'"), Contains("run's row"));
  CHECK_THAT(named("UPDATE devices SET serial = 'X'"), Contains("a device"));
  CHECK_THAT(named("UPDATE sequences SET recipe_toml = 'X' WHERE sequence = 1"),
             Contains("recipe of sequence 1 ('down')"));
  CHECK_THAT(named("UPDATE runs SET bench_toml = 'X'"), Contains("bench file"));
  CHECK_THAT(named("UPDATE runs SET sensor_toml = 'X'"), Contains("sensor file"));
  CHECK_THAT(named("UPDATE events SET detail = 'X' WHERE id <> ''"), Contains("what follows") && Contains("an event"));
  CHECK_THAT(named("DELETE FROM frames WHERE frame % 10 = 3"), Contains("number of frames (now 2)"));
  CHECK_THAT(named("UPDATE runs SET outcome = 'stopped'"), Contains("outcome"));
  CHECK_THAT(named("UPDATE runs SET content_sha256 = replace(content_sha256, substr(content_sha256, 9, 1), 'x')"),
             Contains("stored hash itself"));
  CHECK_THAT(named("UPDATE runs SET content_sha256 = ''"), Contains("stored hash itself"));
  CHECK_THAT(named("UPDATE frames SET chain = zeroblob(32) WHERE frame % 10 = 2"),
             Contains("link") && Contains("frame 2"));
  CHECK_THAT(named("UPDATE frames SET chain = zeroblob(32) WHERE frame % 10 = 3"),
             Contains("link") && Contains("frame 3"));
  CHECK(named("UPDATE runs SET host = 'X', tags = 'a', notes = 'b', started_utc = 'c', time_zone = 'd'").empty());
}

TEST_CASE("content check: one changed byte anywhere in the file is detected, or does not change the content") {
  const TemporaryFolder folder;
  std::int64_t run = 0;
  {
    RunStore store = RunStore::open(folder.path("runs.db"), db::Durability::kNormal);
    run = store_long_example(store);
  }
  REQUIRE_FALSE(std::filesystem::exists(folder.path("runs.db-wal")));
  const std::string whole = read_file(folder.path("runs.db"));
  const std::string content = content_read_back(RunStore::open_read_only(folder.path("runs.db")), run);
  REQUIRE(content.size() > 30000);
  std::mt19937_64 random(20240501);
  constexpr int kFlips = kSanitized ? 300 : 1000;
  int refused = 0, red = 0, harmless = 0;
  const std::string path = folder.path("copy.db");
  for (int i = 0; i < kFlips; ++i) {
    std::string bytes = whole;
    const std::size_t place = random() % bytes.size();
    const auto flip = static_cast<unsigned char>(i % 2 == 0 ? 1U << (random() % 8) : 1 + random() % 255);
    bytes[place] = static_cast<char>(static_cast<unsigned char>(bytes[place]) ^ flip);
    write_file(path, bytes);
    std::string read_back;
    bool holds = false, opened = false;
    try {
      const RunStore store = RunStore::open_read_only(path);
      holds = store.check_content(run).holds();
      opened = true;
      if (holds) read_back = content_read_back(store, run);
    } catch (const db::StoreError&) {
      holds = false;
    }
    ++(!opened ? refused : !holds ? red : harmless);
    if (holds && read_back != content) {
      FAIL_CHECK("byte " << place << " changed by " << int{flip} << " (flip " << i << ") got past");
    }
    remove_store(path);
  }
  CAPTURE(refused, red, harmless);
  CHECK(refused + red + harmless == kFlips);
  CHECK(red > kFlips / 5);         // the file is mostly content: many flips must be noticed
  CHECK(harmless > kFlips / 100);  // and verify does not report bytes outside the content
}

namespace {

db::VerdictRecord verdict_on(const std::string& criterion) {
  db::VerdictRecord verdict;
  verdict.criterion = criterion;
  verdict.verdict = "pass";
  verdict.value = 0.1;
  verdict.limit = 1.0 / 3.0;
  return verdict;
}

// A run with a fit, two verdicts, two approvals and a void.
std::int64_t judged_example(RunStore& store) {
  const std::int64_t run = store_example(store);
  const std::int64_t fit = store.add_fit({0, run, "elam", true, 1, "{}", "a build", "0.1.0", kUtc});
  store.replace_verdicts(run, fit, {verdict_on("mean_compensation_error"), verdict_on("unfit_taxels")});
  store.add_report({run, "1-0a1b2c3d", "0a1b2c3d", "K. Lee", kUtc, "", ""});
  store.add_report({run, "1-ffffffff", "ffffffff", "K. Lee", kUtc, "1-0a1b2c3d", "serial corrected"});
  store.void_run(run, "gauge closed", "K. Lee", kUtc);
  return run;
}

// Which rows of run 1 check_seals finds changed after `sql`.
std::string sealed_rows_after(const std::string& sql) {
  const TemporaryFolder folder;
  RunStore store = RunStore::open(folder.path("runs.db"));
  const std::int64_t run = judged_example(store);
  CHECK(store.check_seals(run).empty());
  Connection(store.path(), Access::kReadWrite).execute("PRAGMA foreign_keys = OFF; " + sql);
  CHECK(store.check_content(run).holds());
  const std::vector<std::string> differences = store.check_seals(run);
  CHECK(differences.size() <= 1);
  return differences.empty() ? "" : differences.front().substr(0, differences.front().find(':'));
}

}  // namespace

TEST_CASE("seals: changes and deletions of verdicts, fits, approvals and voids are detected") {
  CHECK(sealed_rows_after("DELETE FROM verdicts") == "verdicts");
  CHECK(sealed_rows_after("DELETE FROM verdicts WHERE criterion = 'unfit_taxels'") == "verdicts");
  CHECK(sealed_rows_after("UPDATE verdicts SET verdict = 'fail' WHERE criterion = 'unfit_taxels'") == "verdicts");
  for (const char* column : {"value", "expanded", "low_psi", "high_psi", "taxel_share"})
    CHECK(sealed_rows_after(fmt::format("UPDATE verdicts SET {0} = coalesce({0}, 0) + 1e-15", column)) == "verdicts");
  CHECK(sealed_rows_after("UPDATE verdicts SET direction = 'up'") == "verdicts");
  for (const char* change : {"document = '[]'", "model = 'gpi'", "stands = 0", "fitted = 2", "made_by = ''"})
    CHECK(sealed_rows_after(std::string("UPDATE fits SET ") + change) == "fits");
  CHECK(sealed_rows_after("UPDATE seals SET sha256 = '' WHERE kind = 'fits'") == "fits");
  CHECK(sealed_rows_after("DELETE FROM reports") == "approvals");
  CHECK(sealed_rows_after("UPDATE reports SET approved_by = 'M. Ito'") == "approvals");
  for (const char* reason : {"''", "'it was better so'"})
    CHECK(sealed_rows_after(std::string("UPDATE reports SET reason = ") + reason + " WHERE reason <> ''") ==
          "approvals");
  CHECK(sealed_rows_after("UPDATE runs SET void_utc = '', void_by = '', void_reason = ''") == "void");
  CHECK(sealed_rows_after("UPDATE runs SET void_reason = 'none'") == "void");
  CHECK(sealed_rows_after("DELETE FROM verdicts; DELETE FROM seals WHERE kind = 'verdicts'") == "verdicts");
  CHECK(sealed_rows_after("UPDATE runs SET tags = 'a', notes = 'b'").empty());
}

TEST_CASE("seals: a run is sealed from its start, so that an added verdict is detected") {
  NewStore store;
  const std::int64_t run = store_example(store);
  CHECK(store.check_seals(run).empty());
  Connection(store.path(), Access::kReadWrite)
      .execute(
          "INSERT INTO verdicts (run, criterion, scope_kind, low_psi, high_psi, direction, taxel_share, unit, rule, "
          "verdict, limits_toml, limits_sha256) "
          "VALUES (1, 'a', 'array', 0, 0, 'both', 1, 'psi', 'simple', 'pass', '', '')");
  REQUIRE(store.check_seals(run).size() == 1);
  CHECK_THAT(store.check_seals(run).front(), Catch::StartsWith("verdicts"));
}

TEST_CASE("seals: copied runs are sealed in the other store, and a tampered run is not copied") {
  NewStore store, other;
  const std::int64_t run = judged_example(store);
  store_example(other);
  const std::int64_t copy = other.copy_runs_from(store, {run}).front();
  CHECK(other.check_seals(copy).empty());
  Connection(other.path(), Access::kReadWrite).execute("DELETE FROM verdicts WHERE criterion = 'unfit_taxels'");
  CHECK(other.check_seals(copy).size() == 1);
  NewStore third;
  CHECK(store_error([&] { (void)third.copy_runs_from(other, {copy}); }) == "TB-STORE-CONFLICT");
  CHECK(third.runs().empty());
}

TEST_CASE("frames hash: depends on the measured data, not on the program that measured") {
  NewStore store;
  db::RunRecord record = example_run();
  const std::int64_t first = store_example(store, record);
  record.program_version = "9.9";
  record.git_commit = "fedcba";
  const std::int64_t second = store_example(store, record);
  CHECK(store.content_hash(first) != store.content_hash(second));
  CHECK(db::frames_hash(store, first) == db::frames_hash(store, second));
  const std::int64_t none = begin_example(store, record).run;
  CHECK(db::frames_hash(store, none) != db::frames_hash(store, first));
  CHECK_THROWS_AS(db::frames_hash(store, 99), db::StoreError);
}
