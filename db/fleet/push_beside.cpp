// What a push sends beside a run's content: fits, remarks, baselines.
#include <fmt/format.h>

#include "db/fleet/push.h"
#include "db/fleet/remarks.h"
#include "db/run_store.h"

namespace tactbench::db::fleet {

namespace {

void insert_fit(Link& link, std::int64_t run, const Fit& fit, const std::string& parent) {
  const auto text = [&](std::size_t i) { return fit.row[i].bytes; };
  const std::vector<TextRow> inserted = link.query(
      "INSERT INTO fleet.fits (run, sha256, copy, parent_sha256, model, options_json, summary_json, program_version, "
      "created_utc, patterns_json) VALUES ($1, $2, $3, $4, $5, $6, $7, $8, $9, $10) RETURNING fit",
      {std::to_string(run), fit.sha256, std::to_string(fit.copy), parent, text(1), text(2), text(3), text(4), text(5),
       text(6)});
  if (fit.taxels.empty()) return;
  const std::int64_t number = std::stoll(inserted.front().front());
  const Table& table = fit_taxels_table();
  std::size_t i = 0;
  link.copy_in(copy_into(table), [&](std::string& piece) {
    if (i == 0) add_copy_header(piece);
    for (; i < fit.taxels.size() && piece.size() < kPiece; ++i) {
      Row row = fit.taxels[i];
      row.front().integer = number;
      add_copy_row(piece, table.columns, row);
    }
    if (i == fit.taxels.size()) add_copy_trailer(piece);
    return i < fit.taxels.size();
  });
}

}  // namespace

int Push::send_fits(std::int64_t number, std::int64_t run) {
  std::set<std::pair<std::string, std::string>> there;
  for (const TextRow& row : link_.query("SELECT sha256, copy FROM fleet.fits WHERE run = $1", {std::to_string(number)}))
    there.emplace(row[0], row[1]);
  int sent = 0;
  for (const Fit& fit : fits_in(store_.connection(), run)) {
    if (there.contains({fit.sha256, std::to_string(fit.copy)})) continue;
    insert_fit(link_, number, fit, {});
    ++sent;
  }
  return sent;
}

void Push::send_rows(const Table& table, std::int64_t key, const std::vector<Row>& rows) {
  if (rows.empty()) return;
  link_.copy_in(copy_into(table), [&](std::string& piece) {
    add_copy_header(piece);
    for (Row row : rows) {
      row.front().integer = key;
      add_copy_row(piece, table.columns, row);
    }
    add_copy_trailer(piece);
    return false;
  });
}

bool Push::send_remarks(std::int64_t number, const LocalRun& run) {
  const std::vector<TextRow> last = link_.query(
      "SELECT fingerprint FROM fleet.revisions WHERE run = $1 AND source = $2 ORDER BY revision DESC LIMIT 1",
      {std::to_string(number), source_});
  if (!last.empty() && last.front().front() == run.fingerprint) return false;  // another push was faster
  const Remarks remarks = remarks_in(store_.connection(), run.run, fit_names_);
  const std::vector<TextRow> revision = link_.query(
      "INSERT INTO fleet.revisions (run, source, fingerprint, sha256, tags, notes, void_reason, void_by, void_utc) "
      "VALUES ($1, $2, $3, $4, $5, $6, $7, $8, $9) RETURNING revision",
      {std::to_string(number), source_, run.fingerprint, sha256_of(remarks), remarks.tags, remarks.notes,
       remarks.void_reason, remarks.void_by, remarks.void_utc});
  const std::int64_t key = std::stoll(revision.front().front());
  send_rows(verdicts_table(), key, remarks.verdicts);
  send_rows(figures_table(), key, remarks.figures);
  send_rows(reports_table(), key, remarks.reports);
  return true;
}

int Push::push_baselines() {
  struct Baseline {
    std::vector<std::string> said;  // subject, reason, accepted_by, accepted_utc
    std::set<std::string> runs;
  };
  std::map<std::int64_t, Baseline> baselines;
  {
    sqlite::Statement rows(
        store_.connection(),
        "SELECT b.baseline, b.subject, b.reason, b.accepted_by, b.accepted_utc, r.uuid FROM baselines "
        "b JOIN baseline_runs m ON m.baseline = b.baseline JOIN runs r ON r.run = m.run");
    while (rows.step()) {
      Baseline& baseline = baselines[rows.value<std::int64_t>()];
      std::vector<std::string> said(4);
      rows.read_from(1, said[0], said[1], said[2], said[3]);
      baseline.said = said;
      baseline.runs.insert(rows.value<std::string>(5));
    }
  }
  if (baselines.empty()) return 0;
  std::set<std::string> there;
  for (const TextRow& row : link_.query("SELECT sha256 FROM fleet.baselines")) there.insert(row.front());
  int sent = 0;
  for (const auto& [number, baseline] : baselines) {
    std::vector<std::string> values = baseline.said;
    values.insert(values.end(), baseline.runs.begin(), baseline.runs.end());
    Row row(values.size());
    for (std::size_t i = 0; i < values.size(); ++i) row[i].bytes = values[i];
    std::string bytes;
    add_to_digest(bytes, std::vector<Column>(row.size(), {"", Kind::kText}), row);
    const std::string sha256 = sha256_hex(bytes);
    if (there.contains(sha256)) continue;
    Transaction transaction(link_);
    const auto& said = baseline.said;
    const std::vector<TextRow> own = link_.query(
        "INSERT INTO fleet.baselines (sha256, subject, reason, accepted_by, accepted_utc) VALUES ($1, $2, $3, $4, $5) "
        "ON CONFLICT (sha256) DO NOTHING RETURNING baseline",
        {sha256, said[0], said[1], said[2], said[3]});
    if (own.empty()) continue;
    for (const std::string& uuid : baseline.runs)
      (void)link_.query("INSERT INTO fleet.baseline_runs VALUES ($1, $2)", {own.front().front(), uuid});
    transaction.commit();
    ++sent;
  }
  return sent;
}

bool add_fit(Link& link, std::int64_t run, sqlite::Connection& store, std::int64_t fit_in_store,
             const std::string& parent_sha256) {
  for (const Fit& fit : fits_in(store, run)) {
    if (fit.number != fit_in_store) continue;
    Transaction transaction(link);
    (void)link.query("SELECT pg_advisory_xact_lock(hashtextextended('fit of run ' || $1, 0))", {std::to_string(run)});
    if (!link.query("SELECT 1 FROM fleet.fits WHERE run = $1 AND sha256 = $2", {std::to_string(run), fit.sha256})
             .empty())
      return false;
    insert_fit(link, run, fit, parent_sha256);
    transaction.commit();
    return true;
  }
  return false;
}

}  // namespace tactbench::db::fleet
