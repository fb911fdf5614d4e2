#include "db/frames_hash.h"

#include <map>

#include "db/hash_chain.h"

namespace tactbench::db {

std::string frames_hash(const RunStore& store, std::int64_t run) {
  if (const std::optional<PrunedRecord> pruned = store.pruned(run)) return pruned->frames_sha256;
  std::map<std::int64_t, BranchRecord> branches;
  for (const BranchRecord& branch : store.branches(run)) branches[branch.branch] = branch;
  HashChain hasher;
  Digest chain{};
  store.each_frame(run, [&](const FrameRecord& frame) { chain = hasher.frame(chain, branches[frame.branch], frame); });
  return hex(chain);
}

}  // namespace tactbench::db
