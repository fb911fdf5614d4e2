// Reopens an interrupted or ended run: its complete branches are kept, an incomplete branch becomes void, and after a
// long rest the whole repeat.
#pragma once

#include <set>
#include <string>
#include <vector>

#include "db/run_store.h"
#include "devices/clock.h"
#include "sequences/recipe.h"

namespace tactbench::bench {

struct ResumePoint {
  std::set<sequences::BranchKey> done;
  devices::Nanoseconds offset{
      0};                 // added to the new process's clock, so that the run's time continues, including the rest
  double rest_s = 0.0;    // since the run's last sign of life, by the wall clock
  int voided = 0;         // branches made void now
  std::string had_ended;  // how the run had ended, as text
};

// Reopens the run (db::RunWriter::reopen_run) and voids what must be repeated; deletes nothing. `steps`: compile()
// of the recipes. Throws StoreError; Error TB-RUN-COMPLETED, and TB-RUN-CHANGED if the stored data do not fit `recipes`
// and `steps`.
ResumePoint reopen(db::RunWriter& store, std::int64_t run, const std::vector<sequences::Recipe>& recipes,
                   const std::vector<sequences::Step>& steps);

}  // namespace tactbench::bench
