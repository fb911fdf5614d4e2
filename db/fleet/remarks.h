// What is stored beside a run's content, as it travels: fits, and one revision of all else (tags, notes, void,
// verdicts, figures, approvals), each with its hash, which leaves out the keys that a store assigns.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "db/fleet/rows.h"
#include "db/fleet/tables.h"

namespace tactbench::db::fleet {

struct Fit {
  std::int64_t number = 0;  // where it was read from
  Row row;                  // of fits_table()
  std::vector<Row> taxels;  // of fit_taxels_table()
  std::string sha256;
  std::int64_t copy = 0;  // counted among equal ones
};
std::string sha256_of(const Fit& fit);
std::vector<Fit> fits_in(sqlite::Connection& store, std::int64_t run);

struct Remarks {
  std::string tags, notes, void_reason, void_by, void_utc;
  std::vector<Row> verdicts, figures, reports;  // of their tables
};
std::string sha256_of(const Remarks& remarks);
// Throws StoreError. `fit_names`: (UUID of the run, hash) of fits that verdicts rest on, filled as they are needed.
Remarks remarks_in(sqlite::Connection& store, std::int64_t run,
                   std::map<std::int64_t, std::pair<std::string, std::string>>& fit_names);

}  // namespace tactbench::db::fleet
