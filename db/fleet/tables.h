// Which rows of a store the fleet mirrors, and how a row of one becomes a row of the other. The fleet's tables are in
// migrations.cpp. Keys that a store's file assigns (branch, frame, event, fit) do not leave it: in the fleet a row of a
// run is known by its position in the run, from 1.
#pragma once

#include <string>
#include <vector>

#include "db/fleet/rows.h"

namespace tactbench::db::fleet {

struct Table {
  std::string name;             // fleet.NAME
  std::vector<Column> columns;  // of the fleet's table; the first one is `run`
  std::string from_store;       // SQL: rows of run ?1 in their order, all columns but the first
  std::string into_store;       // SQL: INSERT of a row, with ?1 for the fleet's number of the run
};

// Rows of a run that are measured and never change, in an order in which a store takes them; frames come last.
const std::vector<Table>& content_tables();
const Table& frames_table();

// The run's own row, without what people remark later. from_store: the row of run ?1. into_store is not used.
const Table& runs_table();
const Table& sensors_table();  // its first column is `serial`

// What comes after a run's end. `fits` and `fit_taxels` have the fleet's number of the fit in place of `run`.
const Table& fits_table();        // from_store: fits of run ?1, with the store's number of the fit in front
const Table& fit_taxels_table();  // from_store: taxels of the store's fit ?1
const Table& verdicts_table();
const Table& figures_table();
const Table& reports_table();

// "a, b" with each name in double quotes.
std::string names_of(const std::vector<Column>& columns);
// The COPY that takes rows of the table, and by how many bytes at a time they are sent.
std::string copy_into(const Table& table);
inline constexpr std::size_t kPiece = 256 * 1024;

}  // namespace tactbench::db::fleet
