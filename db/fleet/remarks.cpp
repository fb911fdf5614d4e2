#include "db/fleet/remarks.h"

#include <set>

#include "db/run_store.h"

namespace tactbench::db::fleet {

namespace {

std::vector<Row> rows_in(sqlite::Connection& store, const Table& table, std::int64_t key, std::size_t first) {
  sqlite::Statement rows(store, table.from_store);
  rows.bind(key);
  std::vector<Row> found;
  while (rows.step()) read_row(rows, table.columns, found.emplace_back(), first);
  return found;
}

std::vector<Row> taxels_in(sqlite::Connection& store, std::int64_t fit) {
  return rows_in(store, fit_taxels_table(), fit, 1);
}

}  // namespace

std::string sha256_of(const Fit& fit) {
  std::string bytes;
  add_to_digest(bytes, fits_table().columns, fit.row, 1);
  for (const Row& taxel : fit.taxels) add_to_digest(bytes, fit_taxels_table().columns, taxel, 1);
  return sha256_hex(bytes);
}

std::vector<Fit> fits_in(sqlite::Connection& store, std::int64_t run) {
  std::vector<Fit> fits;
  std::map<std::string, std::int64_t> equal;
  for (Row& row : rows_in(store, fits_table(), run, 0)) {
    Fit& fit = fits.emplace_back();
    fit.number = row.front().integer;
    fit.row = std::move(row);
    fit.taxels = taxels_in(store, fit.number);
    fit.sha256 = sha256_of(fit);
    fit.copy = equal[fit.sha256]++;
  }
  return fits;
}

std::string sha256_of(const Remarks& remarks) {
  std::string bytes;
  const std::vector<Column> texts(5, {"", Kind::kText});
  Row said;
  for (const std::string* text :
       {&remarks.tags, &remarks.notes, &remarks.void_reason, &remarks.void_by, &remarks.void_utc})
    said.emplace_back().bytes = *text;
  add_to_digest(bytes, texts, said);
  for (const auto& [table, rows] :
       {std::pair(&verdicts_table(), &remarks.verdicts), std::pair(&figures_table(), &remarks.figures),
        std::pair(&reports_table(), &remarks.reports)}) {
    bytes += '|';
    for (const Row& row : *rows) {
      std::vector<Column> columns = table->columns;
      // A report without a reason has the hash that it had before there were reasons.
      if (table == &reports_table() && row.back().bytes.empty()) columns.pop_back();
      add_to_digest(bytes, columns, row, 1);
    }
  }
  return sha256_hex(bytes);
}

Remarks remarks_in(sqlite::Connection& store, std::int64_t run,
                   std::map<std::int64_t, std::pair<std::string, std::string>>& fit_names) {
  Remarks remarks;
  {
    sqlite::Statement row(store, "SELECT tags, notes, void_reason, void_by, void_utc FROM runs WHERE run = ?");
    if (row.bind(run).step())
      row.read(remarks.tags, remarks.notes, remarks.void_reason, remarks.void_by, remarks.void_utc);
  }
  remarks.verdicts = rows_in(store, verdicts_table(), run, 1);
  remarks.figures = rows_in(store, figures_table(), run, 1);
  remarks.reports = rows_in(store, reports_table(), run, 1);
  for (Row& verdict : remarks.verdicts) {
    Value& uuid = verdict[2];
    if (uuid.bytes.empty()) continue;
    const std::int64_t number = std::stoll(uuid.bytes);  // the store's, from verdicts_table()
    const auto [name, added] = fit_names.try_emplace(number);
    if (added) {
      sqlite::Statement row(store, "SELECT r.uuid, r.run FROM fits f JOIN runs r ON r.run = f.run WHERE f.fit = ?");
      if (row.bind(number).step()) {
        row.read(name->second.first);
        for (const Fit& fit : fits_in(store, row.value<std::int64_t>(1))) {
          if (fit.number == number) name->second.second = fit.sha256;
        }
      }
    }
    uuid.bytes = name->second.first;
    verdict[3].bytes = name->second.second;
  }
  return remarks;
}

}  // namespace tactbench::db::fleet
