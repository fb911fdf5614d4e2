#include "db/run_writer.h"

#include <fmt/format.h>

#include <memory>

#include "db/database.h"
#include "db/remarks.h"
#include "db/run_store.h"

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

void insert_devices(Database& database, std::int64_t run, const std::vector<DeviceRecord>& devices) {
  sqlite::Statement row(database.connection,
                        sqlite::insert_into("devices", fmt::format("run, position, {}", DeviceRecord::kColumns)));
  int position = 0;
  for (const DeviceRecord& d : devices) {
    check_device(d);
    row.bind(run, position++, d.row()).run();
  }
}

void insert_event(Database& database, std::int64_t run, const EventRecord& event) {
  sqlite::Statement(database.connection, sqlite::insert_into("events", fmt::format("run, {}", EventRecord::kColumns)))
      .bind(run, event.row())
      .run();
}

// The last update of the run's row. Part of the caller's transaction.
void close_run(Database& database, std::int64_t run, Outcome outcome, const std::string& reason, SafeState safe,
               const std::string& utc) {
  const Database::OpenRun& open = database.open_run(run);
  database.require_open(run);
  const RunReader reader(database);
  RunRecord ended = reader.run(run);
  ended.outcome = outcome;
  ended.reason = reason;
  ended.safe_state = safe;
  const Digest chain = open.chain ? *open.chain : database.hasher.header(ended);
  const Digest content = database.hasher.close(chain, open.frames, end_of(reader, ended));
  sqlite::Statement(database.connection,
                    "UPDATE runs SET state = 'ended', outcome = ?, reason = ?, safe_state = ?, ended_utc = ?, "
                    "content_sha256 = ? WHERE run = ?")
      .bind(to_string(outcome), reason, to_string(safe), utc, hex(content), run)
      .run();
}

}  // namespace

void RunWriter::wait_for_locks(std::chrono::milliseconds at_most) {
  database_->connection.wait_for_locks(static_cast<int>(at_most.count()));
}

void RunWriter::add_sensor(const SensorRecord& sensor) {
  check_nonblank_text("the serial", sensor.serial, kMaxNameLength);
  check_nonblank_text("the type's name", sensor.type, kMaxNameLength);
  if (!sensor.scanner_serial.empty())
    check_nonblank_text("the scanner's serial", sensor.scanner_serial, kMaxNameLength);
  check_text("the note", sensor.note, kMaxTextLength);
  sqlite::Connection& connection = database_->connection;
  sqlite::Transaction transaction(connection);
  if (const auto known = this->sensor(sensor.serial)) {
    const bool same_type = known->type_sha256 == sensor.type_sha256;
    if (same_type && known->scanner_serial == sensor.scanner_serial) return;
    throw StoreError("TB-STORE-CONFLICT",
                     same_type
                         ? fmt::format("store {}: sensor '{}' is registered with scanner '{}', not '{}'",
                                       database_->path, sensor.serial, known->scanner_serial, sensor.scanner_serial)
                         : fmt::format("store {}: sensor '{}' is registered with another type file ('{}')",
                                       database_->path, sensor.serial, known->type),
                     "register it under another serial: models are bound to sensor, type and scanner");
  }
  sqlite::Statement(connection, sqlite::insert_into("sensors", SensorRecord::kColumns)).bind(sensor.row()).run();
  transaction.commit();
}

std::int64_t RunWriter::begin_run(const RunRecord& run) {
  if (!run.operator_name.empty()) check_nonblank_text("the operator's name", run.operator_name, kMaxNameLength);
  check_text("the purpose", run.purpose, kMaxTextLength);
  check_text("the scanner's serial", run.scanner_serial, kMaxNameLength);
  check_text("the bench's id", run.bench_id, kMaxNameLength);
  database_->preallocate_log();
  sqlite::Connection& connection = database_->connection;
  sqlite::Transaction transaction(connection);
  if (!run.sensor_serial.empty() && !sensor(run.sensor_serial)) {
    throw conflict(fmt::format("store {}: sensor '{}' is not registered", database_->path, run.sensor_serial),
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
  insert_devices(*database_, number, run.devices);
  sqlite::Statement sealed(connection, "INSERT INTO seals (run, kind, count, sha256) VALUES (?, ?, 0, '')");
  for (const char* kind : kSealed) sealed.bind(number, kind).run();
  transaction.commit();
  return number;
}

void RunWriter::set_devices(std::int64_t run, const std::vector<DeviceRecord>& devices) {
  if (database_->open_run(run).frames > 0) {
    throw conflict(fmt::format("store {}: run {} has frames already; its devices are fixed", database_->path, run),
                   "set the devices before the first frame");
  }
  sqlite::Transaction transaction(database_->connection);
  database_->require_open(run);
  sqlite::Statement(database_->connection, "DELETE FROM devices WHERE run = ?").bind(run).run();
  insert_devices(*database_, run, devices);
  transaction.commit();
}

void RunWriter::set_state(std::int64_t run, const std::string& state, const EventRecord& event) {
  database_->open_run(run);
  if (state == "ended") throw conflict("a run may end only through end_run", "this is a defect: please report it");
  sqlite::Transaction transaction(database_->connection);
  database_->require_open(run);
  sqlite::Statement(database_->connection, "UPDATE runs SET state = ? WHERE run = ?").bind(state, run).run();
  insert_event(*database_, run, event);
  transaction.commit();
}

std::int64_t RunWriter::begin_branch(std::int64_t run, const BranchRecord& b) {
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

void RunWriter::void_branch(std::int64_t branch, const std::string& reason) {
  const auto known = sqlite::Statement(database_->connection, "SELECT run FROM branches WHERE branch = ?")
                         .bind(branch)
                         .first<std::int64_t>();
  if (!known) {
    throw StoreError("TB-STORE-NOT-FOUND", fmt::format("store {} has no branch {}", database_->path, branch),
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

void RunWriter::append_frame(std::int64_t run, const FrameRecord& f) {
  Database& database = *database_;
  Database::OpenRun& open = database.open_run(run);
  const BranchRecord& branch = database.branch_of(run, f.branch);
  check_shape(f);
  if (!open.chain) open.chain = database.hasher.header(this->run(run));
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
    throw conflict(fmt::format("store {}: run {} was ended and reopened by another process", database_->path, run),
                   "this frame was not stored; end this run");
  }
  ++open.frames;
  open.chain = chain;
}

void RunWriter::append_event(std::int64_t run, const EventRecord& event) {
  database_->open_run(run);
  sqlite::Transaction transaction(database_->connection);
  database_->require_open(run);
  insert_event(*database_, run, event);
  transaction.commit();
}

void RunWriter::append_series(std::int64_t run, const std::vector<SeriesRecord>& series) {
  database_->open_run(run);
  sqlite::Transaction transaction(database_->connection);
  database_->require_open(run);
  sqlite::Statement row(database_->connection,
                        sqlite::insert_into("series", fmt::format("run, {}", SeriesRecord::kColumns)));
  for (const SeriesRecord& s : series) row.bind(run, s.row()).run();
  transaction.commit();
}

void RunWriter::append_check(std::int64_t run, const CheckRecord& c) {
  database_->open_run(run);
  sqlite::Transaction transaction(database_->connection);
  database_->require_open(run);
  sqlite::Statement(database_->connection, sqlite::insert_into("checks", fmt::format("run, {}", CheckRecord::kColumns)))
      .bind(run, c.row())
      .run();
  transaction.commit();
}

void RunWriter::set_rest(std::int64_t run, double rest_s) {
  database_->open_run(run);
  sqlite::Statement(database_->connection, "UPDATE runs SET rest_s = ? WHERE run = ? AND state <> 'ended'")
      .bind(rest_s, run)
      .run();
}

void RunWriter::set_seen(std::int64_t run, const std::string& utc) {
  database_->open_run(run);
  sqlite::Statement(database_->connection, "UPDATE runs SET seen_utc = ? WHERE run = ? AND state <> 'ended'")
      .bind(utc, run)
      .run();
}

void RunWriter::end_run(std::int64_t run, Outcome outcome, const std::string& reason, SafeState safe,
                        const std::string& utc) {
  database_->open_run(run);
  if (outcome == Outcome::kIncomplete) {
    throw StoreError("TB-STORE-CONFLICT", "an ended run is not incomplete", "this is a defect: please report it");
  }
  sqlite::Transaction transaction(database_->connection);
  close_run(*database_, run, outcome, reason, safe, utc);
  transaction.commit();
  database_->open_runs.erase(run);
}

int RunWriter::mark_interrupted(const std::string& utc) {
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
    insert_event(*database_, dead.run,
                 {last_time_ns(dead.run), "state", "TB-RUN-INTERRUPTED",
                  dead.state + " -> ended: found without a living process at the next start"});
    close_run(*database_, dead.run, Outcome::kInterrupted, reason, SafeState::kUnknown, utc);
  }
  transaction.commit();
  database_->open_runs.clear();
  return static_cast<int>(found.size());
}

void RunWriter::reopen_run(std::int64_t run, const EventRecord& event) {
  const auto refuse = [&](const std::string& what, const std::string& remedy) {
    throw StoreError("TB-STORE-CONFLICT", fmt::format("store {}: run {} {}", database_->path, run, what), remedy);
  };
  // Checked and changed in one transaction: when two processes resume a run, the second finds it open already.
  sqlite::Transaction transaction(database_->connection);
  const RunRecord record = this->run(run);
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
  insert_event(*database_, run, event);
  transaction.commit();
}

}  // namespace tactbench::db
