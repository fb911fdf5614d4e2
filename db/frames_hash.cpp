#include "db/frames_hash.h"

#include <map>

#include "db/hash_chain.h"

namespace tactbench::db {

std::string frames_hash(const RunStore& store, std::int64_t run) {
  std::map<std::int64_t, BranchRecord> branches;
  for (const BranchRecord& branch : store.branches(run)) branches[branch.branch] = branch;
  HashChain hasher;
  Digest chain{};
  for (const FrameRecord& frame : store.frames(run)) chain = hasher.frame(chain, branches[frame.branch], frame);
  return hex(chain);
}

}  // namespace tactbench::db
