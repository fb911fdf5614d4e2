// The end of a run and its content hash: ended by its sequencer, or found dead at the next start.
#include <fmt/format.h>

#include <algorithm>

#include "db/run_store_database.h"

namespace tactbench::db {

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
  if (content.pruned) refuse("has no frames any more: they were removed by a rule", "start a new run");
  if (!content.holds()) {
    refuse(fmt::format("is not what was stored, and to continue it would hide that: {}", content.difference),
           fmt::format("tactbench verify {} shows what differs; take your last snapshot, or start a new run", run));
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
  database.each_frame(number, [&](const FrameRecord& frame) {
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
