// Finding runs of the fleet: by the words of the command line, and what else a run needs to be read.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "db/fleet/postgres.h"

namespace tactbench::db::fleet {

// The fleet's number of a run named by that number, its UUID, or the UUID's first characters (four or more).
// TB-FLEET-NOT-FOUND.
std::int64_t run_named(Link& link, const std::string& name);

// Runs of an origin, oldest first. `where`: a condition in SQL over the columns of the view fleet.every_run, evaluated
// with the rights of who logged in and without a possibility to write; empty: all. TB-FLEET-WHERE.
std::vector<std::int64_t> find_runs(Link& link, const std::string& origin, const std::string& where);
std::map<std::string, std::int64_t> runs_by_origin(Link& link);

// The runs, and those that their verdicts and dynamic models rest on: what `verify` needs.
std::vector<std::int64_t> with_what_they_rest_on(Link& link, const std::vector<std::int64_t>& runs);

std::map<std::int64_t, std::int64_t> frame_counts(Link& link, const std::vector<std::int64_t>& runs);

// "{1,2}", for a parameter of type bigint[].
std::string number_array(const std::vector<std::int64_t>& numbers);

}  // namespace tactbench::db::fleet
