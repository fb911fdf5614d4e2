// Parts of a night as a job array of Slurm.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "bench/fleet/shard_folder.h"

namespace tactbench::bench {

class StopRequest;

struct SlurmOptions {
  std::vector<std::string> sbatch;  // further options of sbatch
  int at_once = 0;                  // parts at once; 0: as many as Slurm gives
  int tries = 2;                    // of each part
  const StopRequest* signals = nullptr;
};

// Submits the parts that are not done, waits for them, and submits again those that failed. `tell` gets a line for each
// thing that happens. A job array of this folder that still runs is waited for. Returns the parts that are not done
// after all tries. Throws Error TB-FLEET-NO-SLURM, TB-FLEET-SLURM when Slurm refuses or no longer answers,
// TB-FLEET-STOPPED by a signal: the job goes on then, and the same call waits for it again.
std::vector<int> carry_out_under_slurm(const ShardFolder& folder, int shards, const SlurmOptions& options,
                                       const std::function<void(const std::string&)>& tell);

// 1, 2, 3, 7 -> "1-3,7"
std::string array_text(const std::vector<int>& shards);

}  // namespace tactbench::bench
