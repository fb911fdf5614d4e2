// Writing a run. The statement that stores a frame is prepared once and is a transaction by itself.
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <system_error>

#include "db/run_store_database.h"

namespace tactbench::db {

namespace {

StoreError conflict(const std::string& message, const std::string& remedy) {
  return {"TB-STORE-CONFLICT", message, remedy};
}

std::string insert_frame() {
  const std::string columns = fmt::format("frame, chain, {}, {}", FrameRecord::kColumns, WrenchRecord::kColumns);
  return fmt::format(
      "INSERT INTO frames ({}, dtype) SELECT {}, 'uint16le' "
      "WHERE EXISTS (SELECT 1 FROM runs WHERE run = ? AND state <> 'ended')",
      columns, sqlite::parameters(columns));
}

void check_shape(const FrameRecord& frame) {
  if (has_consistent_shape(frame)) return;
  throw conflict(fmt::format("a frame of {} x {} x {} (scans, rows, columns) comes with {} counts", frame.scans,
                             frame.rows, frame.columns, frame.counts.size()),
                 "this is a defect of the caller: please report it");
}

// Texts that an instrument reports are bounded like those that people type. A table has the name of its file.
void check_device(const DeviceRecord& device) {
  if (device.origin == "imported") return;
  check_text(fmt::format("the model of the {}", device.role), device.model, kMaxNameLength);
  check_text(fmt::format("the serial number of the {}", device.role), device.serial, kMaxNameLength);
  check_text(fmt::format("the firmware of the {}", device.role), device.firmware, kMaxNameLength);
}

}  // namespace

RunStore::Database::OpenRun& RunStore::Database::open_run(std::int64_t run) {
  const auto known = open_runs.find(run);
  if (known != open_runs.end()) return known->second;
  require_run(run);
  OpenRun open;
  const auto outcome = sqlite::Statement(connection, "SELECT outcome FROM runs WHERE run = ? AND state = 'ended'")
                           .bind(run)
                           .first<std::string>();
  if (outcome) {
    throw conflict(fmt::format("store {}: run {} has ended ({}) and accepts no more data", path, run, *outcome),
                   "start a new run");
  }
  sqlite::Statement last(connection,
                         "SELECT frame, chain FROM frames WHERE frame > ? AND frame < ? "
                         "ORDER BY frame DESC LIMIT 1");
  if (last.bind(frames_above(run), frames_below(run)).step()) {
    last.read(open.frames, open.chain.emplace());
    open.frames -= frames_above(run);
  }
  return open_runs.emplace(run, open).first->second;
}

void RunStore::Database::require_open(std::int64_t run) {
  sqlite::Statement row(connection, "SELECT 1 FROM runs WHERE run = ? AND state <> 'ended'");
  if (row.bind(run).step()) return;
  open_runs.erase(run);
  throw conflict(fmt::format("store {}: run {} was ended by another process and accepts no more data", path, run),
                 "tactbench runs show shows how it ended; tactbench resume continues it");
}

const BranchRecord& RunStore::Database::branch_of(std::int64_t run, std::int64_t branch) {
  if (last_branch_run == run && last_branch.branch == branch) return last_branch;
  sqlite::Statement row(connection,
                        "SELECT branch, sequence, \"repeat\", ordinal, attempt, void FROM branches "
                        "WHERE branch = ? AND run = ?");
  if (!row.bind(branch, run).step()) {
    throw conflict(fmt::format("store {}: run {} has no branch {}", path, run, branch), "begin the branch first");
  }
  BranchRecord found;
  row.read(found.branch, found.sequence, found.repeat, found.ordinal, found.attempt, found.is_void);
  if (found.is_void) {
    throw conflict(fmt::format("store {}: branch {} of run {} is void", path, branch, run),
                   "begin the branch again with the next attempt");
  }
  last_branch = found;
  last_branch_run = run;
  return last_branch;
}

void RunStore::Database::insert_devices(std::int64_t run, const std::vector<DeviceRecord>& devices) {
  sqlite::Statement row(connection,
                        sqlite::insert_into("devices", fmt::format("run, position, {}", DeviceRecord::kColumns)));
  int position = 0;
  for (const DeviceRecord& d : devices) {
    check_device(d);
    row.bind(run, position++, d.row()).run();
  }
}

void RunStore::Database::insert_event(std::int64_t run, const EventRecord& event) {
  sqlite::Statement(connection, sqlite::insert_into("events", fmt::format("run, {}", EventRecord::kColumns)))
      .bind(run, event.row())
      .run();
}

// Only through SQLite: pages of a transaction that do not fit its cache go to the log before the commit. After a
// rollback they are unused, but the file keeps its length.
void RunStore::Database::preallocate_log() {
  constexpr std::uintmax_t kLongest = 1000 * (4096 + 24) + 32;
  constexpr int kFullSync = 2;
  std::error_code missing;
  const std::uintmax_t now = std::filesystem::file_size(connection.path() + "-wal", missing);
  if ((!missing && now >= kLongest) || connection.integer("PRAGMA synchronous") != kFullSync) return;
  const std::int64_t cache = connection.integer("PRAGMA cache_size");
  connection.execute("PRAGMA cache_size = 16");
  try {
    const sqlite::Transaction never_committed(connection);
    connection.execute("CREATE TABLE longer (bytes BLOB); INSERT INTO longer VALUES (zeroblob(4200000))");
  } catch (const StoreError&) {  // a full disk reports it at the next write
  }
  connection.execute(fmt::format("PRAGMA cache_size = {}", cache));
}

void RunStore::wait_for_locks(std::chrono::milliseconds at_most) {
  database_->connection.wait_for_locks(static_cast<int>(at_most.count()));
}

std::int64_t RunStore::begin_run(const RunRecord& run) {
  if (!run.operator_name.empty()) check_nonblank_text("the operator's name", run.operator_name, kMaxNameLength);
  check_text("the purpose", run.purpose, kMaxTextLength);
  check_text("the scanner's serial", run.scanner_serial, kMaxNameLength);
  check_text("the bench's id", run.bench_id, kMaxNameLength);
  database_->preallocate_log();
  sqlite::Connection& connection = database_->connection;
  sqlite::Transaction transaction(connection);
  if (!run.sensor_serial.empty() && !sensor(run.sensor_serial)) {
    throw conflict(fmt::format("store {}: sensor '{}' is not registered", path(), run.sensor_serial),
                   "register it: tactbench sensors add");
  }
  RunRecord begun = run;
  if (begun.uuid.empty()) begun.uuid = new_uuid();
  const std::string columns =
      fmt::format("{}, {}, outcome, safe_state, ended_utc, content_sha256", RunRecord::kContent, RunRecord::kBegun);
  sqlite::Statement(connection, sqlite::insert_into("runs", columns, "sensor_serial"))
      .bind(begun.content(), begun.begun(), to_string(Outcome::kIncomplete), to_string(begun.safe_state), "", "")
      .run();
  const std::int64_t number = connection.last_row();
  sqlite::Statement row(connection, sqlite::insert_into("sequences", fmt::format("run, {}", SequenceRecord::kColumns)));
  for (const SequenceRecord& s : run.sequences) row.bind(number, s.row()).run();
  database_->insert_devices(number, run.devices);
  sqlite::Statement sealed(connection, "INSERT INTO seals (run, kind, count, sha256) VALUES (?, ?, 0, '')");
  for (const char* kind : kSealed) sealed.bind(number, kind).run();
  transaction.commit();
  return number;
}

void RunStore::set_devices(std::int64_t run, const std::vector<DeviceRecord>& devices) {
  if (database_->open_run(run).frames > 0) {
    throw conflict(fmt::format("store {}: run {} has frames already; its devices are fixed", path(), run),
                   "set the devices before the first frame");
  }
  sqlite::Transaction transaction(database_->connection);
  database_->require_open(run);
  sqlite::Statement(database_->connection, "DELETE FROM devices WHERE run = ?").bind(run).run();
  database_->insert_devices(run, devices);
  transaction.commit();
}

void RunStore::set_state(std::int64_t run, const std::string& state, const EventRecord& event) {
  database_->open_run(run);
  if (state == "ended") throw conflict("a run may end only through end_run", "this is a defect: please report it");
  sqlite::Transaction transaction(database_->connection);
  database_->require_open(run);
  sqlite::Statement(database_->connection, "UPDATE runs SET state = ? WHERE run = ?").bind(state, run).run();
  database_->insert_event(run, event);
  transaction.commit();
}

std::int64_t RunStore::begin_branch(std::int64_t run, const BranchRecord& b) {
  database_->open_run(run);
  sqlite::Transaction transaction(database_->connection);
  database_->require_open(run);
  sqlite::Statement(database_->connection,
                    sqlite::insert_into("branches", fmt::format("run, {}", BranchRecord::kColumns)))
      .bind(run, b.row())
      .run();
  const std::int64_t branch = database_->connection.last_row();
  transaction.commit();
  return branch;
}

void RunStore::void_branch(std::int64_t branch, const std::string& reason) {
  const auto known = sqlite::Statement(database_->connection, "SELECT run FROM branches WHERE branch = ?")
                         .bind(branch)
                         .first<std::int64_t>();
  if (!known) {
    throw StoreError("TB-STORE-NOT-FOUND", fmt::format("store {} has no branch {}", path(), branch),
                     "name a branch that begin_branch gave");
  }
  const std::int64_t run = *known;
  database_->open_run(run);
  sqlite::Transaction transaction(database_->connection);
  database_->require_open(run);
  sqlite::Statement(database_->connection, "UPDATE branches SET void = 1, void_reason = ? WHERE branch = ?")
      .bind(reason, branch)
      .run();
  transaction.commit();
  database_->last_branch_run = 0;
}

void RunStore::append_frame(std::int64_t run, const FrameRecord& f) {
  Database& database = *database_;
  Database::OpenRun& open = database.open_run(run);
  const BranchRecord& branch = database.branch_of(run, f.branch);
  check_shape(f);
  if (!open.chain) open.chain = database.header_digest(run);
  const Digest chain = database.hasher.frame(*open.chain, branch, f);
  if (!database.frame_statement) {
    database.frame_statement = std::make_unique<sqlite::Statement>(database.connection, insert_frame());
  }
  const auto of = [&](auto member) { return f.wrench ? std::optional(*f.wrench.*member) : std::nullopt; };
  database.frame_statement
      ->bind(frames_above(run) + open.frames + 1, chain, f.row(), of(&WrenchRecord::target_n),
             of(&WrenchRecord::force_start_n), of(&WrenchRecord::wrench), of(&WrenchRecord::raw),
             of(&WrenchRecord::place_mm), run)
      .run();
  if (database.connection.changes() != 1) {
    database.require_open(run);
    throw conflict(fmt::format("store {}: run {} was ended and reopened by another process", path(), run),
                   "this frame was not stored; end this run");
  }
  ++open.frames;
  open.chain = chain;
}

void RunStore::append_event(std::int64_t run, const EventRecord& event) {
  database_->open_run(run);
  sqlite::Transaction transaction(database_->connection);
  database_->require_open(run);
  database_->insert_event(run, event);
  transaction.commit();
}

void RunStore::append_series(std::int64_t run, const std::vector<SeriesRecord>& series) {
  database_->open_run(run);
  sqlite::Transaction transaction(database_->connection);
  database_->require_open(run);
  sqlite::Statement row(database_->connection,
                        sqlite::insert_into("series", fmt::format("run, {}", SeriesRecord::kColumns)));
  for (const SeriesRecord& s : series) row.bind(run, s.row()).run();
  transaction.commit();
}

void RunStore::append_check(std::int64_t run, const CheckRecord& c) {
  database_->open_run(run);
  sqlite::Transaction transaction(database_->connection);
  database_->require_open(run);
  sqlite::Statement(database_->connection, sqlite::insert_into("checks", fmt::format("run, {}", CheckRecord::kColumns)))
      .bind(run, c.row())
      .run();
  transaction.commit();
}

void RunStore::set_rest(std::int64_t run, double rest_s) {
  database_->open_run(run);
  sqlite::Statement(database_->connection, "UPDATE runs SET rest_s = ? WHERE run = ? AND state <> 'ended'")
      .bind(rest_s, run)
      .run();
}

void RunStore::set_seen(std::int64_t run, const std::string& utc) {
  database_->open_run(run);
  sqlite::Statement(database_->connection, "UPDATE runs SET seen_utc = ? WHERE run = ? AND state <> 'ended'")
      .bind(utc, run)
      .run();
}

// The end of a run and its content hash: ended by its sequencer, or found dead at the next start.

Digest RunStore::Database::header_digest(std::int64_t run) { return hasher.header(this->run(run)); }

RunEnd RunStore::Database::end_of(std::int64_t run) {
  return {events(run), branches(run), checks(run), series(run), Outcome::kIncomplete, {}, SafeState::kUnknown};
}

RunEnd RunStore::Database::end_of(const RunRecord& run) {
  RunEnd end = end_of(run.run);
  end.outcome = run.outcome;
  end.reason = run.reason;
  end.safe = run.safe_state;
  return end;
}

void RunStore::Database::close_run(std::int64_t run, Outcome outcome, const std::string& reason, SafeState safe,
                                   const std::string& utc) {
  OpenRun& open = open_run(run);
  require_open(run);
  const Digest chain = open.chain ? *open.chain : header_digest(run);
  RunEnd end = end_of(run);
  end.outcome = outcome;
  end.reason = reason;
  end.safe = safe;
  const Digest content = hasher.close(chain, open.frames, end);
  sqlite::Statement(connection,
                    "UPDATE runs SET state = 'ended', outcome = ?, reason = ?, safe_state = ?, ended_utc = ?, "
                    "content_sha256 = ? WHERE run = ?")
      .bind(to_string(outcome), reason, to_string(safe), utc, hex(content), run)
      .run();
}

void RunStore::end_run(std::int64_t run, Outcome outcome, const std::string& reason, SafeState safe,
                       const std::string& utc) {
  database_->open_run(run);
  if (outcome == Outcome::kIncomplete) {
    throw StoreError("TB-STORE-CONFLICT", "an ended run is not incomplete", "this is a defect: please report it");
  }
  sqlite::Transaction transaction(database_->connection);
  database_->close_run(run, outcome, reason, safe, utc);
  transaction.commit();
  database_->open_runs.erase(run);
}

int RunStore::mark_interrupted(const std::string& utc) {
  struct Dead {
    std::int64_t run;
    std::string state;
  };
  sqlite::Transaction transaction(database_->connection);
  std::vector<Dead> found;
  {
    sqlite::Statement rows(database_->connection, "SELECT run, state FROM runs WHERE state <> 'ended' ORDER BY run");
    while (rows.step()) found.push_back({rows.value<std::int64_t>(0), rows.value<std::string>(1)});
  }
  const std::string reason = "TB-RUN-INTERRUPTED: the process ended without closing the run";
  database_->open_runs.clear();
  for (const Dead& dead : found) {
    database_->insert_event(dead.run, {last_time_ns(dead.run), "state", "TB-RUN-INTERRUPTED",
                                       dead.state + " -> ended: found without a living process at the next start"});
    database_->close_run(dead.run, Outcome::kInterrupted, reason, SafeState::kUnknown, utc);
  }
  transaction.commit();
  database_->open_runs.clear();
  return static_cast<int>(found.size());
}

void RunStore::reopen_run(std::int64_t run, const EventRecord& event) {
  const auto refuse = [&](const std::string& what, const std::string& remedy) {
    throw StoreError("TB-STORE-CONFLICT", fmt::format("store {}: run {} {}", path(), run, what), remedy);
  };
  // Checked and changed in one transaction: when two processes resume a run, the second finds it open already.
  sqlite::Transaction transaction(database_->connection);
  const RunRecord record = database_->run(run);
  if (record.outcome == Outcome::kCompleted) refuse("is completed: nothing is left to do", "start a new run");
  if (record.outcome == Outcome::kIncomplete) {
    refuse("has not ended: it is being resumed already, or is live",
           "control it with tactbench pause, resume, stop; or wait for its end");
  }
  const ContentCheck content = check_content(run);
  if (content.pruned) refuse("has no frames any more: they were removed by a retention rule", "start a new run");
  if (!content.holds()) {
    refuse(fmt::format("has changed since it was stored, and continuing it would hide that: {}", content.difference),
           fmt::format("tactbench verify {} shows what differs; restore your last snapshot, or start a new run", run));
  }
  sqlite::Statement(database_->connection,
                    "UPDATE runs SET state = 'prepared', outcome = 'incomplete', reason = '', safe_state = 'unknown', "
                    "ended_utc = '', content_sha256 = '' WHERE run = ?")
      .bind(run)
      .run();
  database_->open_runs.erase(run);
  database_->insert_event(run, event);
  transaction.commit();
}

std::string RunStore::content_hash(std::int64_t number) const {
  Database& database = *database_;
  database.require_frames(number);
  const RunRecord run = database.run(number);
  const RunEnd end = database.end_of(run);
  const std::vector<BranchRecord>& branches = end.branches;
  Digest chain = database.hasher.header(run);
  std::int64_t frames = 0;
  database.for_each_frame(number, [&](const FrameRecord& frame) {
    const auto branch = std::lower_bound(branches.begin(), branches.end(), frame.branch,
                                         [](const BranchRecord& b, std::int64_t key) { return b.branch < key; });
    // A frame without a branch of this run can only come from a manual change of the file; it still enters the hash.
    const bool known = branch != branches.end() && branch->branch == frame.branch;
    chain = database.hasher.frame(chain, known ? *branch : BranchRecord{}, frame);
    ++frames;
  });
  return hex(database.hasher.close(chain, frames, end));
}

}  // namespace tactbench::db
