#include "db/fleet/copy_back.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <set>

#include "db/fleet/remarks.h"
#include "db/run_store.h"

namespace tactbench::db::fleet {

namespace {

// "ANY('{1,2}')"
std::string any_of(const std::vector<std::int64_t>& numbers) {
  return fmt::format("ANY('{{{}}}'::bigint[])", fmt::join(numbers, ","));
}

void read(Link& link, const std::vector<Column>& columns, const std::string& select,
          const std::function<void(const Row&)>& take) {
  CopyReader reader(columns, take);
  link.copy_out(fmt::format("COPY ({}) TO STDOUT (FORMAT binary)", select),
                [&](std::string_view piece) { reader.piece(piece); });
}

std::string qualified(const std::vector<Column>& columns, const char* table) {
  std::string text;
  for (const Column& column : columns) text += fmt::format("{}{}.\"{}\"", text.empty() ? "" : ", ", table, column.name);
  return text;
}

// The newest revision of each run in the list.
std::string newest_revisions(const std::string& list) {
  return fmt::format(
      "SELECT DISTINCT ON (run) run, revision, sha256, tags, notes, void_reason, void_by, void_utc FROM "
      "fleet.revisions "
      "WHERE run = {} ORDER BY run, revision DESC",
      list);
}

[[noreturn]] void changed(const Link& link, std::int64_t run, const std::string& what) {
  throw FleetError(FleetCause::kStore, "TB-FLEET-CHANGED",
                   fmt::format("fleet {}: run {}: {} not what was pushed", link.where(), run, what),
                   "somebody changed the fleet's tables: the bench's own store has what was measured");
}

}  // namespace

CopyBack::CopyBack(Link& link, const std::string& path) : link_(link), path_(path) {
  (void)RunStore::open(path, Durability::kNormal);
  store_ = std::make_unique<sqlite::Connection>(std::filesystem::absolute(path).string(), sqlite::Access::kReadWrite);
  // A copy that can be made again: no log, no waiting for the disk.
  (void)store_->text("PRAGMA journal_mode = MEMORY");
  store_->execute("PRAGMA synchronous = OFF");
}

void CopyBack::copy(const Table& table, const std::string& from_where, const std::string& order) {
  sqlite::Statement insert(*store_, table.into_store);
  read(link_, table.columns,
       fmt::format("SELECT {} FROM {} ORDER BY {}", qualified(table.columns, "t"), from_where, order),
       [&](const Row& row) {
         bind_row(insert, table.columns, row);
         insert.run();
       });
}

void CopyBack::add_sensors(const std::string& list, bool exactly) {
  const Table& table = sensors_table();
  sqlite::Statement insert(*store_, table.into_store + " ON CONFLICT (serial) DO NOTHING");
  std::map<std::string, std::string> registered;
  read(link_, table.columns,
       fmt::format(
           "SELECT {} FROM fleet.sensors t WHERE (serial, type_sha256, scanner_serial) IN "
           "(SELECT sensor_serial, sensor_type_sha256, sensor_scanner FROM fleet.runs WHERE run = {}) ORDER BY 1",
           qualified(table.columns, "t"), list),
       [&](const Row& row) {
         const auto [known, added] = registered.try_emplace(row[0].bytes, row[3].bytes + row[4].bytes);
         if (exactly && !added)
           throw FleetError(FleetCause::kUsage, "TB-FLEET-CONFLICT",
                            fmt::format("fleet {}: these runs have sensor '{}' registered with two types or scanners",
                                        link_.where(), row[0].bytes),
                            "name runs of one registration");
         bind_row(insert, table.columns, row);
         insert.run();
       });
}

void CopyBack::add_run_rows(const std::string& list) {
  std::vector<Column> columns = runs_table().columns;
  for (const char* name : {"tags", "notes", "void_reason", "void_by", "void_utc"})
    columns.push_back({name, Kind::kText});
  const std::string names = names_of(columns);
  std::string places;
  for (std::size_t i = 0; i < columns.size(); ++i) places += fmt::format("{}?{}", i == 0 ? "" : ", ", i + 1);
  sqlite::Statement insert(*store_, fmt::format("INSERT INTO runs ({}) VALUES ({})", names, places));
  read(link_, columns,
       fmt::format("SELECT {}, coalesce(v.tags, ''), coalesce(v.notes, ''), coalesce(v.void_reason, ''), "
                   "coalesce(v.void_by, ''), coalesce(v.void_utc, '') FROM fleet.runs t LEFT JOIN ({}) v "
                   "ON v.run = t.run WHERE t.run = {} ORDER BY t.run",
                   qualified(runs_table().columns, "t"), newest_revisions(list), list),
       [&](const Row& row) {
         bind_row(insert, columns, row);
         insert.run();
       });
}

void CopyBack::add_content(const std::vector<std::int64_t>& runs, Frames frames) {
  const std::string list = any_of(runs);
  store_->execute("BEGIN");
  add_sensors(list, false);
  add_run_rows(list);
  for (const Table& table : content_tables())
    copy(table, fmt::format("fleet.{} t WHERE t.run = {}", table.name, list), "1, 2");
  if (frames == Frames::kWith) {
    std::set<std::int64_t> months;
    for (const TextRow& row : link_.query(fmt::format("SELECT month FROM fleet.runs WHERE run = {}", list)))
      months.insert(std::stoll(row.front()));
    copy(frames_table(),
         fmt::format("fleet.frames t WHERE t.month = {} AND t.run = {}", any_of({months.begin(), months.end()}), list),
         "t.month, t.run, t.position");
  }
  store_->execute("COMMIT");
}

void CopyBack::add_fits(const std::string& list) {
  std::map<std::int64_t, Fit> fits;
  std::map<std::int64_t, std::int64_t> run_of_fit;
  std::vector<Column> columns = fits_table().columns;
  columns.push_back({"run", Kind::kInteger});
  columns.push_back({"sha256", Kind::kText});
  read(link_, columns,
       fmt::format("SELECT {} FROM fleet.fits t WHERE run = {} ORDER BY fit", qualified(columns, "t"), list),
       [&](const Row& row) {
         Fit& fit = fits[row[0].integer];
         fit.row.assign(row.begin(), row.end() - 2);
         fit.sha256 = row.back().bytes;
         run_of_fit[row[0].integer] = row[row.size() - 2].integer;
       });
  const Table& taxels = fit_taxels_table();
  read(
      link_, taxels.columns,
      fmt::format("SELECT {} FROM fleet.fit_taxels t JOIN fleet.fits f ON f.fit = t.fit WHERE f.run = {} ORDER BY 1, 2",
                  qualified(taxels.columns, "t"), list),
      [&](const Row& row) { fits[row[0].integer].taxels.push_back(row); });
  const std::string names = names_of(fits_table().columns);
  sqlite::Statement insert(*store_,
                           fmt::format("INSERT INTO fits ({}, run) VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8)", names));
  sqlite::Statement insert_taxel(*store_, taxels.into_store);
  for (const auto& [number, fit] : fits) {
    const std::int64_t run = run_of_fit[number];
    if (sha256_of(fit) != fit.sha256) changed(link_, run, fmt::format("fit {} is", number));
    bind_row(insert, fits_table().columns, fit.row);
    insert.bind_at(8, run);
    insert.run();
    for (const Row& taxel : fit.taxels) {
      bind_row(insert_taxel, taxels.columns, taxel);
      insert_taxel.run();
    }
  }
}

void CopyBack::add_remarks(const std::string& list) {
  struct Revision {
    std::int64_t run = 0;
    std::string sha256;
    Remarks remarks;
  };
  std::map<std::int64_t, Revision> revisions;
  const std::vector<Column> columns = {
      {"run", Kind::kInteger}, {"revision", Kind::kInteger}, {"sha256", Kind::kText},  {"tags", Kind::kText},
      {"notes", Kind::kText},  {"void_reason", Kind::kText}, {"void_by", Kind::kText}, {"void_utc", Kind::kText}};
  read(link_, columns, newest_revisions(list), [&](const Row& row) {
    revisions[row[1].integer] = {row[0].integer,
                                 row[2].bytes,
                                 {row[3].bytes, row[4].bytes, row[5].bytes, row[6].bytes, row[7].bytes, {}, {}, {}}};
  });
  std::vector<std::int64_t> numbers;
  for (const auto& [number, revision] : revisions) numbers.push_back(number);
  for (const auto& [table, rows] :
       {std::pair(&verdicts_table(), &Remarks::verdicts), std::pair(&figures_table(), &Remarks::figures),
        std::pair(&reports_table(), &Remarks::reports)}) {
    read(link_, table->columns,
         fmt::format("SELECT {} FROM fleet.{} t WHERE t.revision = {} ORDER BY 1, 2, 3", qualified(table->columns, "t"),
                     table->name, any_of(numbers)),
         [&](const Row& row) { (revisions[row.front().integer].remarks.*rows).push_back(row); });
  }
  // Fits that are here, by UUID of their run and hash.
  std::map<std::pair<std::string, std::string>, std::int64_t> fit_of;
  for (const TextRow& row :
       link_.query(fmt::format("SELECT r.uuid, f.sha256, f.fit FROM fleet.fits f JOIN fleet.runs r "
                               "ON r.run = f.run WHERE f.run = {} ORDER BY f.fit DESC",
                               list)))
    fit_of[{row[0], row[1]}] = std::stoll(row[2]);
  const auto by_bytes = [](const Row& a, const Row& b) {
    return std::pair(a[1].bytes, a[2].bytes) < std::pair(b[1].bytes, b[2].bytes);
  };
  for (auto& [number, revision] : revisions) {
    std::ranges::sort(revision.remarks.figures, by_bytes);  // as a store sorts text, whatever the database's language
    if (sha256_of(revision.remarks) != revision.sha256) changed(link_, revision.run, "what was said of it is");
    for (const auto& [table, rows] :
         {std::pair(&verdicts_table(), &Remarks::verdicts), std::pair(&figures_table(), &Remarks::figures),
          std::pair(&reports_table(), &Remarks::reports)}) {
      sqlite::Statement insert(*store_, table->into_store);
      for (Row row : revision.remarks.*rows) {
        row.front().integer = revision.run;
        std::vector<Column> bound = table->columns;
        if (table == &verdicts_table()) {
          const auto fit = fit_of.find({row[2].bytes, row[3].bytes});
          bound[2].kind = Kind::kInteger;
          row[2].null = fit == fit_of.end();
          if (fit != fit_of.end()) row[2].integer = fit->second;
        }
        bind_row(insert, bound, row);
        insert.run();
      }
    }
  }
}

// Those of which at least one run is here.
void CopyBack::add_baselines() {
  std::map<std::string, std::int64_t> run_of;
  {
    sqlite::Statement rows(*store_, "SELECT uuid, run FROM runs");
    while (rows.step()) run_of[rows.value<std::string>(0)] = rows.value<std::int64_t>(1);
  }
  sqlite::Statement insert(*store_, "INSERT OR IGNORE INTO baselines VALUES (?, ?, ?, ?, ?)");
  sqlite::Statement member(*store_, "INSERT OR IGNORE INTO baseline_runs VALUES (?, ?)");
  std::map<std::string, std::int64_t> numbers;  // in the order of acceptance, since the last one of a subject counts
  for (const TextRow& row : link_.query(
           "SELECT b.baseline, b.subject, b.reason, b.accepted_by, b.accepted_utc, r.uuid FROM fleet.baselines b "
           "JOIN fleet.baseline_runs r ON r.baseline = b.baseline ORDER BY b.accepted_utc, b.baseline")) {
    const auto run = run_of.find(row[5]);
    if (run == run_of.end()) continue;
    const std::int64_t number =
        numbers.try_emplace(row[0], static_cast<std::int64_t>(numbers.size()) + 1).first->second;
    insert.bind(number, row[1], row[2], row[3], row[4]).run();
    member.bind(number, run->second).run();
  }
}

void CopyBack::add_runs(const std::vector<std::int64_t>& runs, Frames frames) {
  const std::string list = any_of(runs);
  const Transaction one_state(link_, "ISOLATION LEVEL REPEATABLE READ READ ONLY");
  if (frames == Frames::kWith) add_sensors(list, true);
  add_content(runs, frames);
  store_->execute("BEGIN");
  add_fits(list);
  add_remarks(list);
  add_baselines();
  // Counts alone, as in a store of before seals: what was pushed was compared by its hashes here.
  store_->execute(
      "INSERT OR REPLACE INTO seals SELECT r.run, 'fits', (SELECT count(*) FROM fits f WHERE f.run = r.run), '' FROM "
      "runs r; "
      "INSERT OR REPLACE INTO seals SELECT r.run, 'verdicts', (SELECT count(*) FROM verdicts v WHERE v.run = r.run), "
      "'' FROM runs r; "
      "INSERT OR REPLACE INTO seals SELECT r.run, 'approvals', (SELECT count(*) FROM reports p WHERE p.run = r.run), "
      "'' FROM runs r; "
      "INSERT OR REPLACE INTO seals SELECT run, 'void', void_utc <> '', '' FROM runs");
  store_->execute("COMMIT");
}

std::string CopyBack::content_hash(std::int64_t run) const { return RunStore::open_read_only(path_).content_hash(run); }

std::uintmax_t CopyBack::bytes() const { return std::filesystem::file_size(path_); }

}  // namespace tactbench::db::fleet
