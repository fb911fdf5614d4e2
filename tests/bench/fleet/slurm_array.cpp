// Parts of a night under a Slurm of scripts, which carry out the job as soon as it is submitted.
#include "bench/fleet/slurm_array.h"

#include <catch2/catch.hpp>
#include <csignal>
#include <filesystem>

#include "bench/common/error.h"
#include "bench/common/stop_request.h"
#include "tests/bench/fleet/shard_night.h"
#include "tests/support/process.h"
#include "tests/support/variable.h"

using namespace tactbench;
using namespace tactbench::tests;
namespace fs = std::filesystem;

namespace {

// A Slurm whose sbatch and squeue are these scripts. Stores of all parts lie ready beside them.
class ScriptedSlurm {
 public:
  ScriptedSlurm(const std::string& sbatch, const std::string& squeue)
      : variable_("PATH", place_.path()), folder_(place_.path("n"), night_of_three()) {
    for (int shard = 1; shard <= 3; ++shard)
      store_part(place_.path("ready-" + std::to_string(shard)), record_of_part(shard));
    write("sbatch", sbatch);
    write("squeue", squeue);
  }
  [[nodiscard]] std::vector<int> carry_out(bench::SlurmOptions options = {}) {
    return bench::carry_out_under_slurm(folder_, 3, options, [&](const std::string& line) { told_.push_back(line); });
  }
  [[nodiscard]] bench::Error refusal(bench::SlurmOptions options = {}) {
    try {
      (void)carry_out(options);
    } catch (const bench::Error& error) {
      return error;
    }
    FAIL("nothing was refused");
    throw 0;
  }
  [[nodiscard]] const bench::ShardFolder& folder() const { return folder_; }
  [[nodiscard]] std::string path(const std::string& name) const { return place_.path(name); }
  [[nodiscard]] std::string said(const std::string& name) const { return read_file(place_.path(name)); }
  [[nodiscard]] const std::vector<std::string>& told() const { return told_; }

 private:
  void write(const std::string& name, const std::string& text) const {
    write_file(place_.path(name), "#!/bin/sh\nPATH=/usr/bin:/bin\ncd '" + place_.path() + "'\n" + text);
    fs::permissions(place_.path(name), fs::perms::owner_all);
  }
  TemporaryFolder place_;
  Variable variable_;
  bench::ShardFolder folder_;
  std::vector<std::string> told_;
};

// Ends these parts well: "1 3".
std::string ends(const std::string& parts) {
  return "for k in " + parts + "; do cp ready-$k n/shard-$k.db; echo 0 >n/shard-$k.code; done\n";
}

}  // namespace

TEST_CASE("parts as Slurm's array: single ones and ranges") {
  CHECK(bench::array_text({}).empty());
  CHECK(bench::array_text({4}) == "4");
  CHECK(bench::array_text({1, 2}) == "1-2");
  CHECK(bench::array_text({1, 2, 3, 7}) == "1-3,7");
  CHECK(bench::array_text({1, 3, 4, 5, 9, 10}) == "1,3-5,9-10");
}

TEST_CASE("all parts of a night are submitted as one array with the options given, and nothing is left") {
  ScriptedSlurm slurm("printf '%s\\n' \"$@\" >asked; cat n/night.json >plan\n" + ends("1 2 3") + "echo '12;cluster'\n",
                      "exit 1\n");
  CHECK(slurm.carry_out({.sbatch = {"--partition=x", "-n1"}, .at_once = 2}).empty());
  CHECK(slurm.said("asked") == "--parsable\n--array=1-3%2\n--output=" + slurm.path("n/shard-%a.log") +
                                   "\n--partition=x\n-n1\n" + slurm.path("n/shard.sh") + "\n");
  CHECK(slurm.told() == std::vector<std::string>{"job 12: parts 1-3", "job 12: 3 of 3 parts ended"});
  CHECK(slurm.folder().job().empty());
}

TEST_CASE("a night of which all parts are done asks Slurm for nothing") {
  ScriptedSlurm slurm("exit 9\n", "exit 9\n");
  for (int shard = 1; shard <= 3; ++shard) store_part(slurm.folder().store_of(shard), record_of_part(shard));
  slurm.folder().set_job("5");  // of which nothing is missing
  CHECK(slurm.carry_out().empty());
  CHECK(slurm.told().empty());
}

TEST_CASE("a part that failed is told with its reason and submitted again, by itself, as often as said") {
  ScriptedSlurm slurm(
      "echo \"$2\" >>asked; echo 3 >n/shard-2.code; echo 'no disk' >n/shard-2.log\n" + ends("1 3") + "echo 7\n",
      "exit 1\n");
  CHECK(slurm.carry_out({.sbatch = {}, .tries = 2}) == std::vector<int>{2});
  CHECK(slurm.said("asked") == "--array=1-3\n--array=2\n");
  CHECK(slurm.told() == std::vector<std::string>{"job 7: parts 1-3", "job 7: 3 of 3 parts ended",
                                                 "part 2 failed: exit code 3; last line: no disk",
                                                 "job 7: part 2 again", "job 7: 1 of 1 part ended",
                                                 "part 2 failed: exit code 3; last line: no disk"});
}

TEST_CASE("parts that are done already are left out, in words") {
  ScriptedSlurm slurm("echo \"$2\" >asked\n" + ends("2") + "echo 'sbatch: a word'; echo 30\n", "exit 1\n");
  for (const int shard : {1, 3}) store_part(slurm.folder().store_of(shard), record_of_part(shard));
  CHECK(slurm.carry_out({.sbatch = {}, .tries = 1}).empty());
  CHECK(slurm.said("asked") == "--array=2\n");
  CHECK(slurm.told() ==
        std::vector<std::string>{"2 parts done already: 2 left", "job 30: part 2", "job 30: 1 of 1 part ended"});
}

TEST_CASE("a job of before is waited for, until its parts have ended or Slurm knows of none") {
  ScriptedSlurm slurm(ends("1 2") + "echo 31\n", "printf '%s\\n' \"$@\" >asked\n" + ends("3") +
                                                     "echo 5 >n/shard-1.code; echo 5 >n/shard-2.code; exit 0\n");
  slurm.folder().set_job("30");
  CHECK(slurm.carry_out({.sbatch = {}, .tries = 1}).empty());
  CHECK(slurm.said("asked") == "--noheader\n--array\n--jobs=30\n--format=%T\n");
  CHECK(slurm.told() == std::vector<std::string>{"job 30 of this night was submitted before: waiting for it",
                                                 "1 part done already: 1-2 left", "job 31: parts 1-2",
                                                 "job 31: 2 of 2 parts ended"});
}

TEST_CASE("a job that Slurm has forgotten is over, and what a node wrote late is still seen") {
  ScriptedSlurm slurm("echo 8\n", "( sleep 0.2;" + ends("1 2 3") +
                                      ") >/dev/null 2>&1 &\n echo 'slurm_load_jobs error: Invalid job id specified'; "
                                      "exit 1\n");
  CHECK(slurm.carry_out({.sbatch = {}, .tries = 1}).empty());
  CHECK(slurm.told() == std::vector<std::string>{"job 8: parts 1-3"});
}

TEST_CASE("while tasks are queued the night waits, and parts that end are told one by one") {
  ScriptedSlurm slurm("echo 9\n",
                      "if test -e n/shard-1.code; then\n" + ends("2 3") + "else\n" + ends("1") + "fi\necho RUNNING\n");
  CHECK(slurm.carry_out({.sbatch = {}, .tries = 1}).empty());
  CHECK(slurm.told() ==
        std::vector<std::string>{"job 9: parts 1-3", "job 9: 1 of 3 parts ended", "job 9: 3 of 3 parts ended"});
}

TEST_CASE("what sbatch says instead of a job's number is told in one line") {
  for (const char* answer : {"echo 'invalid'; echo 'partition'; exit 1\n", "echo 'invalid partition'\n"}) {
    ScriptedSlurm slurm(answer, "exit 1\n");
    const bench::Error error = slurm.refusal();
    CHECK(error.id() == "TB-FLEET-SLURM");
    CHECK(error.code() == bench::ExitCode::kInconclusive);
    CHECK(std::string(error.what()) == "sbatch did not take the job: invalid partition");
    CHECK(error.where() == slurm.folder().script());
    CHECK(error.remedy() == "check Slurm (sinfo), partition and limits; options of sbatch are given with --sbatch");
  }
  for (const char* answer : {"exit 0\n", "echo 12; exit 1\n", "echo 12x\n", "echo ';cluster'\n"}) {
    ScriptedSlurm slurm(answer, "exit 1\n");
    CHECK(slurm.refusal().id() == "TB-FLEET-SLURM");
  }
}

TEST_CASE("without Slurm's client nothing is submitted") {
  ScriptedSlurm slurm(ends("1 2 3") + "echo 1\n", "exit 1\n");
  fs::remove(slurm.path("squeue"));
  const bench::Error error = slurm.refusal();
  CHECK(error.id() == "TB-FLEET-NO-SLURM");
  CHECK(error.code() == bench::ExitCode::kUsage);
  CHECK(std::string(error.what()) == "squeue is not in PATH");
  CHECK(error.where() == "fleet slurm");
  CHECK_THAT(error.remedy(), Catch::Contains("fleet slurm --no-submit writes their script and says how"));
  fs::remove(slurm.path("sbatch"));
  CHECK(std::string(slurm.refusal().what()) == "sbatch is not in PATH");
  CHECK(slurm.told().empty());
}

TEST_CASE("a signal ends the waiting, and the job goes on and is waited for again") {
  const bench::StopRequest signals;
  ScriptedSlurm slurm("echo 77\n", "echo PENDING\n");
  std::raise(SIGTERM);
  const bench::Error error = slurm.refusal({.sbatch = {}, .signals = &signals});
  CHECK(error.id() == "TB-FLEET-STOPPED");
  CHECK(error.code() == bench::ExitCode::kTerminated);
  CHECK(std::string(error.what()) == "waiting was ended by a request to terminate; job 77 goes on");
  CHECK(error.where() == slurm.folder().script());
  CHECK(error.remedy() == "the same command waits for it again; scancel 77 ends it");
  CHECK(slurm.folder().job() == "77");
}
