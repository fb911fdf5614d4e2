#include "bench/fleet/slurm_array.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <optional>
#include <thread>

#include "analysis/counted.h"
#include "bench/common/error.h"
#include "bench/common/stop_request.h"
#include "bench/fleet/tool.h"

namespace tactbench::bench {
namespace {

using RealClock = std::chrono::steady_clock;

constexpr double kToolLimitS = 60.0;
constexpr std::chrono::minutes kNoAnswer{10};  // after so long without an answer of Slurm waiting ends
constexpr std::chrono::seconds kLateFiles{5};  // until what a node has written is seen here
constexpr std::chrono::milliseconds kFirstLook{500}, kLongestLook{10'000};

std::string slurm_tool(const std::string& name) {
  if (const auto file = find_program(name)) return *file;
  throw Error(
      ExitCode::kUsage, "TB-FLEET-NO-SLURM", fmt::format("{} is not in PATH", name), "fleet slurm",
      "install Slurm's client (Debian: slurm-client), or carry the parts out without it: fleet slurm --no-submit "
      "writes their script and says how");
}

std::string one_text(std::string said) {
  std::ranges::replace(said, '\n', ' ');
  said.erase(said.find_last_not_of(' ') + 1);
  return said;
}

class SlurmArray {
 public:
  SlurmArray(const ShardFolder& folder, const SlurmOptions& options,
             const std::function<void(const std::string&)>& tell)
      : folder_(folder), options_(options), tell_(tell), sbatch_(slurm_tool("sbatch")), squeue_(slurm_tool("squeue")) {}

  std::string submit(const std::vector<int>& shards) const {
    std::vector<std::string> words = {sbatch_, "--parsable",
                                      fmt::format("--array={}{}", array_text(shards),
                                                  options_.at_once > 0 ? fmt::format("%{}", options_.at_once) : ""),
                                      "--output=" + folder_.log_for_slurm()};
    words.insert(words.end(), options_.sbatch.begin(), options_.sbatch.end());
    words.push_back(folder_.script());
    const ToolResult done = run_tool(words, kToolLimitS);
    // "12" or "12;cluster", after what else Slurm has to say
    const std::string said = one_text(done.said);
    const std::string last = said.substr(said.rfind(' ') + 1);
    std::string job = last.substr(0, last.find(';'));
    if (done.code != 0 || job.empty() || job.find_first_not_of("0123456789") != std::string::npos)
      throw Error(ExitCode::kInconclusive, "TB-FLEET-SLURM", fmt::format("sbatch did not take the job: {}", said),
                  folder_.script(),
                  "check Slurm (sinfo), partition and limits; options of sbatch are given with --sbatch");
    return job;
  }

  // Until no task of the job is left, or all its parts have ended.
  void wait_for(const std::string& job, const std::vector<int>& shards) const {
    auto answered = RealClock::now();
    std::size_t told = 0;
    for (auto pause = kFirstLook;; pause = std::min(pause * 2, kLongestLook)) {
      const std::size_t ended = ended_of(shards);
      if (ended > told)
        tell_(fmt::format("job {}: {} of {} ended", job, ended, analysis::counted(shards.size(), "part")));
      told = ended;
      if (ended == shards.size()) return;
      const std::optional<bool> left = is_queued(job);
      if (left) answered = RealClock::now();
      if (left && !*left) break;
      if (RealClock::now() - answered > kNoAnswer)
        throw Error(ExitCode::kInconclusive, "TB-FLEET-SLURM",
                    fmt::format("Slurm has not answered for 10 minutes; job {} may go on", job), squeue_,
                    "the same command waits for it again");
      sleep(job, pause, shards, ended);
    }
    const auto last = RealClock::now() + kLateFiles;
    while (RealClock::now() < last && std::ranges::any_of(shards, [&](int shard) { return !folder_.has_ended(shard); }))
      sleep(job, kFirstLook, shards, shards.size());
  }

 private:
  // None: Slurm did not answer.
  std::optional<bool> is_queued(const std::string& job) const {
    const ToolResult done = run_tool({squeue_, "--noheader", "--array", "--jobs=" + job, "--format=%T"}, kToolLimitS);
    if (done.code == 0) return !one_text(done.said).empty();
    if (done.said.find("Invalid job id") != std::string::npos) return false;  // ended, and forgotten by Slurm
    return std::nullopt;
  }

  [[nodiscard]] std::size_t ended_of(const std::vector<int>& shards) const {
    return static_cast<std::size_t>(std::ranges::count_if(shards, [&](int shard) { return folder_.has_ended(shard); }));
  }

  // Not longer than until another part has ended than the `ended` ones.
  void sleep(const std::string& job, std::chrono::milliseconds time, const std::vector<int>& shards,
             std::size_t ended) const {
    auto look = RealClock::now() + kFirstLook;
    for (const auto last = RealClock::now() + time; RealClock::now() < last;) {
      if (RealClock::now() > look) {
        if (ended_of(shards) > ended) return;
        look = RealClock::now() + kFirstLook;
      }
      if (options_.signals != nullptr && options_.signals->signal() != 0)
        throw Error(
            code_of_signal(options_.signals->signal()), "TB-FLEET-STOPPED",
            fmt::format("waiting was ended by {}; job {} goes on", signal_text(options_.signals->signal()), job),
            folder_.script(), fmt::format("the same command waits for it again; scancel {} ends it", job));
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
    }
  }

  const ShardFolder& folder_;
  const SlurmOptions& options_;
  const std::function<void(const std::string&)>& tell_;
  std::string sbatch_, squeue_;
};

}  // namespace

std::string array_text(const std::vector<int>& shards) {
  std::string text;
  for (std::size_t i = 0; i < shards.size();) {
    std::size_t last = i;
    while (last + 1 < shards.size() && shards[last + 1] == shards[last] + 1) ++last;
    if (!text.empty()) text += ",";
    text += last == i ? std::to_string(shards[i]) : fmt::format("{}-{}", shards[i], shards[last]);
    i = last + 1;
  }
  return text;
}

std::vector<int> carry_out_under_slurm(const ShardFolder& folder, int shards, const SlurmOptions& options,
                                       const std::function<void(const std::string&)>& tell) {
  const SlurmArray array(folder, options, tell);
  std::vector<int> missing = folder.missing();
  const std::string before = folder.job();
  if (!before.empty() && !missing.empty()) {
    tell(fmt::format("job {} of this night was submitted before: waiting for it", before));
    array.wait_for(before, missing);
    missing = folder.missing();
  }
  if (const std::size_t done = static_cast<std::size_t>(shards) - missing.size(); done > 0 && !missing.empty())
    tell(fmt::format("{} done already: {} left", analysis::counted(done, "part"), array_text(missing)));
  for (int attempt = 1; attempt <= options.tries && !missing.empty(); ++attempt) {
    folder.forget_end(missing);
    const std::string job = array.submit(missing);
    folder.set_job(job);
    tell(fmt::format("job {}: {} {}{}", job, missing.size() == 1 ? "part" : "parts", array_text(missing),
                     attempt > 1 ? " again" : ""));
    array.wait_for(job, missing);
    folder.set_job("");
    missing = folder.missing();
    for (const int shard : missing) tell(fmt::format("part {} failed: {}", shard, folder.why_failed(shard)));
  }
  return missing;
}

}  // namespace tactbench::bench
