// What `tactbench verify` found of a run: its content, and each stored result beside the recomputed one.
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
  std::vector<std::string> beside;      // what of fits, verdicts, approvals and void is not what was stored
  std::vector<VerifiedResult> results;  // none when the content does not hold
  std::string first_difference;         // empty: all as stored
};

// Recomputes an ended run from its raw frames; writes nothing. Throws StoreError TB-STORE-NOT-FOUND.
RunVerification verify_run(const db::RunStore& store, std::int64_t run);

}  // namespace tactbench::bench
