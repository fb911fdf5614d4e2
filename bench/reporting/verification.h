// `tactbench verify`: checks a run's content and compares each stored result with the recomputed one.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "db/run_store.h"

namespace tactbench::bench {

struct VerifiedResult {
  std::int64_t fit = 0, fit_run = 0;
  std::string what;        // "elam", "verdicts"
  std::string compared;    // "bit for bit", "1e-12 relative: ...", or why it was not recomputed
  std::string difference;  // empty: equal
  bool recomputed = false;
  std::size_t rows = 0;
};

struct RunVerification {
  db::ContentCheck content;
  std::vector<std::string>
      changed_records;                  // changed records outside the content hash: fits, verdicts, approvals, voids
  std::vector<VerifiedResult> results;  // empty if the content has changed
  std::string first_difference;         // empty: everything present is as stored (content.pruned: frames were removed)
};

// Recomputes an ended run from its raw frames; writes nothing. Throws StoreError TB-STORE-NOT-FOUND.
RunVerification verify_run(const db::RunStore& store, std::int64_t run);

}  // namespace tactbench::bench
