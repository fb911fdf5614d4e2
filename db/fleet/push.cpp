#include "db/fleet/push.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "db/run_store.h"

namespace tactbench::db::fleet {

namespace {

// The store's one state for as long as a run is sent.
class Reading {
 public:
  explicit Reading(sqlite::Connection& store) : store_(store) { store_.execute("BEGIN"); }
  ~Reading() {
    try {
      store_.execute("ROLLBACK");
    } catch (const StoreError&) {  // nothing was changed
    }
  }
  Reading(const Reading&) = delete;
  Reading& operator=(const Reading&) = delete;

 private:
  sqlite::Connection& store_;
};

// "{"a","b"}"
std::string text_array(const std::vector<LocalRun>& runs) {
  std::string text = "{";
  for (const LocalRun& run : runs) {
    text += text.size() > 1 ? ",\"" : "\"";
    for (const char c : run.uuid) text += c == '"' || c == '\\' ? std::string("\\") + c : std::string(1, c);
    text += '"';
  }
  return text + "}";
}

}  // namespace

// Columns of a row that is inserted, as text; those that are NULL are left out.
struct Push::InsertedRow {
  std::string names, places;
  std::vector<std::string> values;
  void add(const std::string& name, const std::string& value) {
    values.push_back(value);
    names += fmt::format("{}\"{}\"", names.empty() ? "" : ", ", name);
    places += fmt::format("{}${}", places.empty() ? "" : ", ", values.size());
  }
};

Push::Push(Link& link, LocalRuns& store, std::string source, std::string scratch, std::uintmax_t largest_scratch)
    : link_(link),
      store_(store),
      source_(std::move(source)),
      scratch_(std::move(scratch)),
      largest_scratch_(largest_scratch) {}

std::vector<Waiting> Push::waiting() {
  const std::vector<LocalRun> runs = store_.ended_runs();
  // By UUID and content: the fingerprint that this store pushed last.
  std::map<std::pair<std::string, std::string>, std::string> there;
  for (const TextRow& row : link_.query(
           "SELECT r.uuid, r.content_sha256, coalesce((SELECT n.fingerprint FROM fleet.revisions n WHERE n.run = r.run "
           "AND n.source = $2 ORDER BY n.revision DESC LIMIT 1), '') FROM fleet.runs r WHERE r.uuid = ANY($1::text[])",
           {text_array(runs), source_}))
    there[{row[0], row[1]}] = row[2];
  std::vector<Waiting> waiting;
  for (const LocalRun& run : runs) {
    const auto known = there.find({run.uuid, run.content_sha256});
    if (known == there.end())
      waiting.push_back({run, true});
    else if (known->second != run.fingerprint)
      waiting.push_back({run, false});
  }
  return waiting;
}

// The registration of the run's sensor is sent, too, and named in `row`.
void Push::add_sensor(std::int64_t run, InsertedRow& row) {
  const Table& sensors = sensors_table();
  sqlite::Statement rows(
      store_.connection(),
      fmt::format("SELECT {} FROM sensors WHERE serial = (SELECT sensor_serial FROM runs WHERE run = ?1)",
                  names_of(sensors.columns)));
  rows.bind(run);
  if (!rows.step()) return;
  Row sensor;
  read_row(rows, sensors.columns, sensor);
  std::vector<std::string> values;
  for (const Value& value : sensor) values.push_back(value.bytes);
  (void)link_.query("INSERT INTO fleet.sensors VALUES ($1, $2, $3, $4, $5, $6, $7) ON CONFLICT DO NOTHING", values);
  row.add("sensor_type_sha256", values[3]);
  row.add("sensor_scanner", values[4]);
}

std::int64_t Push::insert_run(const LocalRun& run, bool* is_new) {
  InsertedRow own;
  {
    const std::vector<Column>& columns = runs_table().columns;
    sqlite::Statement rows(store_.connection(), runs_table().from_store);
    rows.bind(run.run);
    Row row;
    if (!rows.step())
      throw StoreError("TB-STORE-CONFLICT", fmt::format("store {}: run {} is gone", store_.path(), run.run),
                       "another program changed the store: tactbench db check");
    read_row(rows, columns, row, 1);
    for (std::size_t i = 1; i < columns.size(); ++i) {
      if (row[i].null) continue;
      if (columns[i].kind == Kind::kInteger)
        own.add(columns[i].name, std::to_string(row[i].integer));
      else if (columns[i].kind == Kind::kReal)
        own.add(columns[i].name, fmt::format("{}", row[i].real));  // the shortest text that gives this number back
      else
        own.add(columns[i].name, row[i].bytes);
    }
  }
  add_sensor(run.run, own);
  own.add("frames", std::to_string(store_.frame_count(run.run)));
  own.add("month", std::to_string(month_of(run.started_utc)));
  std::vector<TextRow> row = link_.query(
      fmt::format("INSERT INTO fleet.runs ({}) VALUES ({}) ON CONFLICT (uuid, content_sha256) DO NOTHING RETURNING run",
                  own.names, own.places),
      own.values);
  *is_new = !row.empty();
  if (row.empty())
    row = link_.query("SELECT run FROM fleet.runs WHERE uuid = $1 AND content_sha256 = $2",
                      {run.uuid, run.content_sha256});
  return std::stoll(row.at(0).at(0));
}

std::int64_t Push::send(const Table& table, std::int64_t number, const LocalRun& run) {
  sqlite::Statement rows(store_.connection(), table.from_store);
  rows.bind_at(1, run.run);
  if (&table == &frames_table()) rows.bind_at(2, month_of(run.started_utc));
  if (!rows.step()) return 0;
  Row row(1);
  row.front().integer = number;
  std::int64_t count = 0;
  link_.copy_in(copy_into(table), [&](std::string& piece) {
    if (count == 0) add_copy_header(piece);
    bool more = true;
    while (more && piece.size() < kPiece) {
      read_row(rows, table.columns, row, 1);
      add_copy_row(piece, table.columns, row);
      ++count;
      more = rows.step();
    }
    if (!more) add_copy_trailer(piece);
    return more;
  });
  return count;
}

void Push::compare(std::int64_t number, const LocalRun& run) {
  if (read_back_ && read_back_->bytes() > largest_scratch_) {
    const std::string old = read_back_->path();
    read_back_.reset();
    std::filesystem::remove(old);
  }
  if (!read_back_)
    read_back_ = std::make_unique<CopyBack>(link_, fmt::format("{}/read-back-{}.db", scratch_, ++scratch_files_));
  read_back_->add_content({number}, Frames::kWith);
  const std::string found = read_back_->content_hash(number);
  if (found == run.content_sha256) return;
  const ContentCheck own = RunStore::open_read_only(store_.path()).check_content(run.run);
  throw FleetError(
      FleetCause::kStore, "TB-FLEET-DIFFERS",
      fmt::format("fleet {}: run {}: what came to the server has content {}, the run has {}{}", link_.where(), run.run,
                  found, run.content_sha256,
                  own.holds() ? std::string() : fmt::format("; the store itself has changed: {}", own.difference)),
      own.holds() ? "nothing was kept there: push again, and report it when it comes again"
                  : "the run was not pushed: tactbench verify RUN, and take the last snapshot of the store");
}

PushedRun Push::push(const Waiting& waiting) {
  const LocalRun& run = waiting.run;
  const std::int64_t month = month_of(run.started_utc);
  if (waiting.content && !months_.contains(month)) {  // by itself: its lock on the table of frames is short
    (void)link_.query("SELECT fleet.make_month($1)", {std::to_string(month)});
    months_.insert(month);
  }
  const Reading one_state(store_.connection());
  Transaction transaction(link_);
  (void)link_.query("SELECT pg_advisory_xact_lock(hashtextextended($1, 0))", {run.uuid});
  PushedRun pushed;
  bool is_new = false;
  pushed.number = insert_run(run, &is_new);
  if (is_new) {
    for (const Table& table : content_tables()) (void)send(table, pushed.number, run);
    pushed.frames = send(frames_table(), pushed.number, run);
    try {
      compare(pushed.number, run);
    } catch (...) {
      read_back_.reset();  // half of a run may be in it
      throw;
    }
  }
  pushed.fits = send_fits(pushed.number, run.run);
  pushed.remarks = send_remarks(pushed.number, run);
  transaction.commit();
  return pushed;
}

}  // namespace tactbench::db::fleet
