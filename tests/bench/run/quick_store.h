// A temporary store of a test whose writes do not wait for the disk.
#pragma once

#include "db/run_store.h"
#include "tests/support/process.h"

namespace tactbench::tests {

class QuickStore : TemporaryFolder, public db::RunStore {
 public:
  QuickStore() : RunStore(open(TemporaryFolder::path("runs.db"), db::Durability::kNormal)) {}
  using RunStore::path;
};

}  // namespace tactbench::tests
