// The fleet's tables as numbered migrations. After the first release none is edited; each change is a new one.
#pragma once

#include "db/fleet/postgres.h"

namespace tactbench::db::fleet {

inline constexpr int kFleetSchema = 2;

// The fleet's schema; 0: the database has none.
int schema_of(Link& link);
// Throws FleetError TB-FLEET-EMPTY, TB-FLEET-OLDER, TB-FLEET-NEWER unless it is this program's.
void check_schema(Link& link);
// Brings the database to this program's schema; makes roles that are missing. Returns the schema before. Any number of
// programs may do it at once.
int migrate(Link& link, const std::string& program_version);

}  // namespace tactbench::db::fleet
