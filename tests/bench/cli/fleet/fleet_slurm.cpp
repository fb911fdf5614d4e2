// fleet slurm with a Slurm of scripts: parts that fail, and what is said of them.
#include <catch2/catch.hpp>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include "tests/bench/cli/verb_here.h"
#include "tests/support/variable.h"

using namespace tactbench;
using namespace tactbench::tests;

namespace {

// Its job ends the parts at once, each with this exit code.
struct SlurmThatEnds {
  explicit SlurmThatEnds(const std::string& code) : variable("PATH", folder.path()) {
    write_file(suite,
               "schema = 1\nname = \"s\"\n[[scenario]]\nname = \"a\"\nabout = \"b\"\n[[scenario]]\nname = \"c\"\nabout "
               "= \"d\"\n[[scenario]]\nname = \"e\"\nabout = \"f\"\n");
    const std::string head = "#!/bin/sh\nPATH=/usr/bin:/bin\ncd '" + folder.path() + "'\n";
    write_file(folder.path("sbatch"), head + "echo \"$@\" >>asked\nfor k in 1 2; do echo " + code +
                                          " >parts/shard-$k.code; echo the cause >parts/shard-$k.log; done\necho 7\n");
    write_file(folder.path("squeue"), head + "exit 1\n");
    for (const char* name : {"sbatch", "squeue"})
      std::filesystem::permissions(folder.path(name), std::filesystem::perms::owner_all);
  }
  Finished night(const std::vector<std::string>& before = {}) const {
    std::vector<std::string> words = {"fleet", "slurm", "--shards", "2", "--folder", parts, "--sbatch=--mem=4G"};
    words.insert(words.end(), before.begin(), before.end());
    words.insert(words.end(), {"--", "nightly", suite, "--db", store});
    return verb_here(bench::add_fleet, words);
  }
  TemporaryFolder folder;
  std::string suite = folder.path("suite.toml"), store = folder.path("night.db"), parts = folder.path("parts");
  Variable variable;
};

}  // namespace

TEST_CASE("fleet slurm: parts that fail are named with their logs and causes, and nothing is put together") {
  const SlurmThatEnds slurm("3");
  const Finished failed = slurm.night({"--tries", "1", "--at-once", "1"});
  CHECK(failed.code == 6);
  CHECK(failed.out.empty());
  const std::string told =
      "job 7: parts 1-2\njob 7: 2 of 2 parts ended\npart 1 failed: exit code 3; last line: the cause\npart 2 failed: "
      "exit code 3; last line: the cause\n";
  const std::string error = "error: 2 of 2 parts failed; nothing was put together. part 1 (" + slurm.parts +
                            "/shard-1.log): exit code 3; last line: the cause. part 2 (" + slurm.parts +
                            "/shard-2.log): exit code 3; last line: the cause [TB-FLEET-SHARDS]\n  at: " + slurm.parts +
                            "/shard.sh\n  try: mend the cause; the same command then carries out these parts alone\n";
  CHECK(failed.err == told + error);
  CHECK_FALSE(std::filesystem::exists(slurm.store));
  const std::string asked = read_file(slurm.folder.path("asked"));
  CHECK_THAT(asked, Catch::Contains("--mem=4G") && Catch::Contains("1-2%1"));
  CHECK(slurm.night({"--tries", "1", "-q"}).err == error);
  // Twice each where nothing else is asked for.
  const Finished twice = slurm.night();
  CHECK(twice.code == 6);
  CHECK_THAT(twice.err, Catch::StartsWith(told + "job 7: parts 1-2 again\n"));
  for (const std::vector<std::string>& wrong : std::vector<std::vector<std::string>>{
           {"--tries", "0"}, {"--tries", "21"}, {"--at-once", "0"}, {"--shards", "0"}, {"--sbatch"}}) {
    std::vector<std::string> words = {"fleet", "slurm"};
    words.insert(words.end(), wrong.begin(), wrong.end());
    if (wrong[0] != "--shards") words.insert(words.end(), {"--shards", "2"});
    words.insert(words.end(), {"--", "nightly", slurm.suite, "--db", slurm.store});
    CHECK_THAT(verb_here(bench::add_fleet, words).err, Catch::StartsWith("parse: "));
  }
}
