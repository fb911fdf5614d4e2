// Times of a run without reading the frames themselves, for time estimates.
#include "db/run_store_database.h"

namespace tactbench::db {

std::vector<TimedSequence> RunStore::timed_sequences(const std::string& bench_id, int newest) const {
  sqlite::Statement rows(
      database_->connection,
      "SELECT r.run, r.overrides_json, s.sequence, s.recipe_sha256, s.repeats, s.frames_per_repeat "
      "FROM (SELECT run, overrides_json FROM runs WHERE outcome = 'completed' AND bench_id = ? AND void_utc = '' "
      "ORDER BY run DESC LIMIT ?) r JOIN sequences s ON s.run = r.run ORDER BY r.run DESC, s.sequence");
  rows.bind(bench_id, newest);
  std::vector<TimedSequence> found;
  while (rows.step()) {
    TimedSequence& s = found.emplace_back();
    rows.read(s.run, s.overrides_json, s.sequence, s.recipe_sha256, s.repeats, s.frames_per_repeat);
  }
  return found;
}

std::int64_t RunStore::last_position(std::int64_t run) const {
  sqlite::Statement row(database_->connection,
                        "SELECT frame FROM frames WHERE frame > ? AND frame < ? ORDER BY frame DESC LIMIT 1");
  const auto last = row.bind(frames_above(run), frames_below(run)).first<std::int64_t>();
  return last ? *last - frames_above(run) : 0;
}

std::optional<FrameTime> RunStore::frame_time(std::int64_t run, std::int64_t position) const {
  if (!database_->time_statement) {
    database_->time_statement =
        std::make_unique<sqlite::Statement>(database_->connection,
                                            "SELECT b.sequence, b.\"repeat\", f.ordinal, b.void, f.time_ns "
                                            "FROM frames f JOIN branches b ON b.branch = f.branch WHERE f.frame = ?");
  }
  sqlite::Statement& row = *database_->time_statement;
  std::optional<FrameTime> found;
  if (row.bind(frames_above(run) + position).step()) {
    FrameTime& time = found.emplace();
    row.read(time.sequence, time.repeat, time.ordinal, time.is_void, time.time_ns);
  }
  row.run();
  return found;
}

std::vector<TimedEvent> RunStore::timed_events(std::int64_t run) const {
  sqlite::Statement rows(database_->connection,
                         "SELECT time_ns, kind, detail FROM events WHERE run = ? AND kind IN ('state', 'way-back') "
                         "ORDER BY event");
  rows.bind(run);
  std::vector<TimedEvent> found;
  while (rows.step()) {
    TimedEvent& event = found.emplace_back();
    rows.read(event.time_ns, event.kind, event.detail);
  }
  return found;
}

}  // namespace tactbench::db
