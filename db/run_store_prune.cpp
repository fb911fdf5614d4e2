// Removal of frames by a rule. What is kept in their place lets the rest of the run be checked: the first link of its
// hash chain against its row, sequences and devices, and the last frame's against the content hash and all that
// follows.
#include <fmt/format.h>

#include <algorithm>

#include "db/frames_hash.h"
#include "db/run_store_database.h"

namespace tactbench::db {

namespace {

constexpr const char *kPin = "pinned", *const kNightTag = "nightly";

bool has_tag(const RunRecord& run, const char* tag) { return std::ranges::find(run.tags, tag) != run.tags.end(); }

// Why nothing of this run is ever removed; empty: there is no such reason.
std::string why_whole(sqlite::Connection& connection, const RunRecord& run) {
  if (run.origin != "simulated") return fmt::format("{}, not simulated", run.origin);
  if (run.is_void()) return "void";
  if (has_tag(run, kPin)) return "pinned";
  sqlite::Statement reported(connection, "SELECT number FROM reports WHERE run = ? ORDER BY report_row DESC LIMIT 1");
  const auto number = reported.bind(run.run).first<std::string>();
  return number ? fmt::format("in the approved report {}", *number) : std::string();
}

}  // namespace

std::string RunStore::why_not_pruned(std::int64_t number) const {
  sqlite::Connection& connection = database_->connection;
  const RunRecord run = database_->run(number);
  if (run.outcome == Outcome::kIncomplete) return "not ended";
  if (std::string whole = why_whole(connection, run); !whole.empty()) return whole;
  if (!has_tag(run, kNightTag)) return "not of a night";
  if (pruned(number)) return "removed already";
  if (frame_count(number) == 0) return "without frames";
  // A verdict rests on the frames of the judged run and of the run that the models are from.
  sqlite::Statement others(connection,
                           "SELECT f.run FROM verdicts v JOIN fits f ON f.fit = v.fit WHERE v.run = ?1 AND f.run <> ?1 "
                           "UNION SELECT v.run FROM verdicts v JOIN fits f ON f.fit = v.fit "
                           "WHERE f.run = ?1 AND v.run <> ?1");
  others.bind(number);
  while (others.step()) {
    const auto other = others.value<std::int64_t>();
    if (const std::string whole = why_whole(connection, database_->run(other)); !whole.empty())
      return fmt::format("run {} is {}, and a verdict rests on both", other, whole);
  }
  return {};
}

std::optional<PrunedRecord> RunStore::pruned(std::int64_t run) const {
  sqlite::Statement row(database_->connection,
                        "SELECT run, frames, bytes, header, chain, frames_sha256, rule, pruned_utc FROM pruned "
                        "WHERE run = ?");
  if (!row.bind(run).step()) return std::nullopt;
  PrunedRecord pruned;
  row.read(pruned.run, pruned.frames, pruned.bytes, pruned.header, pruned.chain, pruned.frames_sha256, pruned.rule,
           pruned.pruned_utc);
  return pruned;
}

PrunedRecord RunStore::prune_frames(std::int64_t run, const std::string& rule, const std::string& utc) {
  check_said("the rule", rule, kLongestText);
  const auto refuse = [&](const std::string& what, const std::string& remedy) {
    throw StoreError("TB-STORE-CONFLICT", fmt::format("store {}: the frames of run {} stay: {}", path(), run, what),
                     remedy);
  };
  sqlite::Connection& connection = database_->connection;
  sqlite::Transaction transaction(connection);
  if (const std::string why = why_not_pruned(run); !why.empty()) refuse(why, "leave it out");
  const ContentCheck content = check_content(run);
  if (!content.holds())
    refuse(fmt::format("it is not what was stored: {}", content.difference),
           fmt::format("tactbench verify {} shows what differs", run));
  PrunedRecord pruned;
  pruned.run = run;
  pruned.frames = content.frames;
  pruned.header = database_->header_digest(run);
  pruned.frames_sha256 = frames_hash(*this, run);
  pruned.rule = rule;
  pruned.pruned_utc = utc;
  {
    sqlite::Statement last(connection,
                           "SELECT chain, (SELECT sum(length(counts) + length(trace)) FROM frames WHERE frame > ?1 AND "
                           "frame < ?2) FROM frames WHERE frame > ?1 AND frame < ?2 ORDER BY frame DESC LIMIT 1");
    if (last.bind(frames_above(run), frames_below(run)).step()) last.read(pruned.chain, pruned.bytes);
  }
  sqlite::Statement(connection, "DELETE FROM frames WHERE frame > ? AND frame < ?")
      .bind(frames_above(run), frames_below(run))
      .run();
  sqlite::Statement(connection,
                    "INSERT INTO pruned (run, frames, bytes, header, chain, frames_sha256, rule, pruned_utc) "
                    "VALUES (?, ?, ?, ?, ?, ?, ?, ?)")
      .bind(run, pruned.frames, pruned.bytes, pruned.header, pruned.chain, pruned.frames_sha256, rule, utc)
      .run();
  transaction.commit();
  return pruned;
}

void RunStore::shrink() { database_->connection.execute("VACUUM; PRAGMA wal_checkpoint(TRUNCATE)"); }

}  // namespace tactbench::db
