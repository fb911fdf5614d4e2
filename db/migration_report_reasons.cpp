// Schema 9: why a signed report replaces an earlier one.
#include "db/schema.h"

namespace tactbench::db {

std::string report_reasons_migration() {
  return "ALTER TABLE reports ADD COLUMN reason TEXT NOT NULL DEFAULT ''";  // '': replaces none, or is older than
                                                                            // schema 9
}

}  // namespace tactbench::db
