// The folder of a night that several machines carry out in parts: a script that carries out one part (under Slurm, GNU
// parallel or by hand), and what the parts leave: shard-K.db, shard-K.log, shard-K.code.
#pragma once

#include <string>
#include <vector>

#include "bench/nightly/suite.h"

namespace tactbench::bench {

// What is carried out.
struct ShardedNight {
  std::vector<std::string> words;  // of the program, from "nightly" on, without --shard and --db
  Suite suite;                     // with its seeds
  std::string selection_json;      // which scenarios and seeds
  int shards = 1;
  int jobs = 2;  // scenarios at once in a part
};

class ShardFolder {
 public:
  // Makes the folder, or goes on with what it holds of the same night; parts of a night that was put together already
  // are removed. It must be seen under the same name wherever parts are carried out. Throws Error TB-FLEET-FOLDER when
  // it holds parts of another night, or files of others.
  ShardFolder(const std::string& path, const ShardedNight& night);

  [[nodiscard]] std::string script() const;  // its argument, or SLURM_ARRAY_TASK_ID: the part
  [[nodiscard]] std::string store_of(int shard) const;
  [[nodiscard]] std::string log_of(int shard) const;
  [[nodiscard]] std::string log_for_slurm() const;  // with %a in place of the part's number
  // The store of the part is there, whole, and of this night.
  [[nodiscard]] bool is_done(int shard) const;
  [[nodiscard]] bool has_ended(int shard) const;          // its last process has, in one way or the other
  [[nodiscard]] std::string why_failed(int shard) const;  // of one that is not done: its exit code and last line
  [[nodiscard]] std::vector<int> missing() const;         // parts that are not done
  void forget_end(const std::vector<int>& shards) const;  // before they are carried out again

  // The job array that carries out parts now; empty: none.
  [[nodiscard]] std::string job() const;
  void set_job(const std::string& job) const;
  void set_merged() const;  // the next night begins anew

 private:
  void write_plan(const std::string& job, bool merged) const;
  void write_script() const;
  std::string path_;
  ShardedNight night_;
};

}  // namespace tactbench::bench
