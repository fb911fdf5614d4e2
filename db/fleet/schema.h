// Tables, roles and views of the fleet database, as one SQL script.
#pragma once

#include "db/fleet/postgres.h"

namespace tactbench::db::fleet {

inline constexpr int kFleetSchema = 1;

// The database's schema of the fleet; 0: it has none.
int schema_of(Link& link);
// TB-FLEET-EMPTY, and TB-FLEET-SCHEMA unless it is this program's.
void check_schema(Link& link);
// Makes tables, roles and views where there are none; returns the schema before. Any number of programs may do it at
// once. TB-FLEET-SCHEMA, TB-FLEET-TEXT when the database's encoding is not UTF8.
int make_fleet(Link& link, const std::string& program_version);

}  // namespace tactbench::db::fleet
