// Tables, roles and views of the fleet database, as one SQL script.
#pragma once

#include "db/fleet/postgres.h"

namespace tactbench::db::fleet {

inline constexpr int kFleetSchema = 1;

// Version of the database's fleet schema; 0: it has none.
int schema_of(Link& link);
// TB-FLEET-EMPTY, and TB-FLEET-SCHEMA unless it is this program's.
void check_schema(Link& link);
// Makes tables, roles and views if there are none; returns the previous schema version. Several programs may do it at
// the same time. TB-FLEET-SCHEMA, TB-FLEET-TEXT if the database's encoding is not UTF8.
int make_fleet(Link& link, const std::string& program_version);

}  // namespace tactbench::db::fleet
