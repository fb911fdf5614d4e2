// Models, verdicts, approvals and voids come after a run's end and are not part of its content. Each kind has a row in
// seals, renewed with every change: the number of its rows, and their SHA-256.
#include <fmt/format.h>

#include "db/run_store_database.h"

namespace tactbench::db {

Digest HashChain::fits(const std::vector<FitRecord>& fits) {
  begin("fits");
  for (const FitRecord& fit : fits) {
    add(fit.fit);
    add(std::int64_t{fit.stands});
    add(std::int64_t{fit.fitted});
    for (const std::string* text : {&fit.model, &fit.document, &fit.made_by, &fit.program_version, &fit.created_utc})
      add(*text);
  }
  return finish();
}

Digest HashChain::verdicts(const std::vector<VerdictRecord>& verdicts) {
  begin("verdicts");
  for (const VerdictRecord& v : verdicts) {
    add(v.fit);
    for (const std::string* text :
         {&v.criterion, &v.scope_kind, &v.direction, &v.unit, &v.rule, &v.verdict, &v.limits_toml, &v.limits_sha256}) {
      add(*text);
    }
    for (const double number : {v.low_psi, v.high_psi, v.share, v.value, v.expanded, v.limit}) add(number);
  }
  return finish();
}

Digest HashChain::approvals(const std::vector<ReportRecord>& reports) {
  begin("approvals");
  for (const ReportRecord& r : reports) {
    for (const std::string* text : {&r.number, &r.content_sha256, &r.approved_by, &r.approved_utc, &r.replaces}) {
      add(*text);
    }
    if (!r.reason.empty()) add("reason: " + r.reason);  // no number begins so
    for (const ReportRecord::Evidence& one : r.evidence) add("evidence: " + one.content_sha256);
  }
  return finish();
}

Digest HashChain::voided(const RunRecord& run) {
  begin("void");
  for (const std::string* text : {&run.void_reason, &run.void_by, &run.void_utc}) add(*text);
  return finish();
}

RunStore::Sealed RunStore::sealed_now(std::int64_t run, const std::string& kind) const {
  HashChain& hasher = database_->hasher;
  if (kind == "fits") {
    const std::vector<FitRecord> rows = fits(run);
    return {static_cast<std::int64_t>(rows.size()), hex(hasher.fits(rows))};
  }
  if (kind == "verdicts") {
    const std::vector<VerdictRecord> rows = verdicts(run);
    return {static_cast<std::int64_t>(rows.size()), hex(hasher.verdicts(rows))};
  }
  if (kind == "approvals") {
    const std::vector<ReportRecord> rows = reports(run);
    return {static_cast<std::int64_t>(rows.size()), hex(hasher.approvals(rows))};
  }
  const RunRecord record = database_->run(run);
  return {record.is_void() ? 1 : 0, hex(hasher.voided(record))};
}

void RunStore::seal(std::int64_t run, const std::string& kind) {
  const Sealed now = sealed_now(run, kind);
  sqlite::Statement(database_->connection,
                    "INSERT INTO seals (run, kind, count, sha256) VALUES (?, ?, ?, ?) "
                    "ON CONFLICT (run, kind) DO UPDATE SET count = excluded.count, sha256 = excluded.sha256")
      .bind(run, kind, now.count, now.sha256)
      .run();
}

std::vector<std::string> RunStore::check_seals(std::int64_t run) const {
  std::vector<std::string> wrong;
  for (const char* kind : kSealed) {
    const Sealed now = sealed_now(run, kind);
    Sealed stored;
    sqlite::Statement row(database_->connection, "SELECT count, sha256 FROM seals WHERE run = ? AND kind = ?");
    const bool there = row.bind(run, kind).step();
    if (there) row.read(stored.count, stored.sha256);
    if (!there) {
      wrong.push_back(
          fmt::format("{}: the count and hash of what was stored are missing; {} there now", kind, now.count));
    } else if (stored.count != now.count) {
      wrong.push_back(fmt::format("{}: {} were stored, {} there now", kind, stored.count, now.count));
    } else if (stored.sha256 != now.sha256 && !(stored.count == 0 && stored.sha256.empty())) {
      wrong.push_back(fmt::format("{}: what is there is not what was stored", kind));
    }
  }
  return wrong;
}

}  // namespace tactbench::db
