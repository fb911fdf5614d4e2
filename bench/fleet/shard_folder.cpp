#include "bench/fleet/shard_folder.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "analysis/json_io.h"
#include "bench/common/error.h"
#include "bench/common/file_text.h"
#include "bench/common/output_file.h"
#include "bench/fleet/tool.h"
#include "db/run_store.h"

namespace tactbench::bench {
namespace {

namespace fs = std::filesystem;

fs::path plan_in(const std::string& folder) { return fs::path(folder) / "night.json"; }

nlohmann::json plan_of(const std::string& folder) { return analysis::try_json(file_text(plan_in(folder))); }

std::string file_of(const std::string& folder, int shard, const char* ending) {
  return (fs::path(folder) / fmt::format("shard-{}{}", shard, ending)).string();
}

// The last line that says something.
std::string last_line(const std::string& text) {
  std::string last;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    if (text.find_first_not_of(" \t\r", begin) < end) last = text.substr(begin, end - begin);
    begin = end + 1;
  }
  return last;
}

}  // namespace

ShardFolder::ShardFolder(const std::string& path, const ShardedNight& night)
    : path_(fs::absolute(path).lexically_normal().string()), night_(night) {
  const auto refuse = [&](const std::string& what, const std::string& remedy) {
    throw Error(ExitCode::kUsage, "TB-FLEET-FOLDER", what, path_, remedy);
  };
  std::error_code failed;
  fs::create_directories(path_, failed);
  if (!fs::is_directory(path_, failed)) refuse("the folder of the parts cannot be made", "name another with --folder");
  if (!fs::exists(plan_in(path_))) {
    if (!fs::is_empty(path_, failed)) refuse("the folder holds files of others", "name a new one with --folder");
  } else {
    const nlohmann::json plan = plan_of(path_);
    if (!plan.is_object()) refuse("night.json in this folder cannot be read", "name a new one with --folder");
    const bool same = plan.value("suite_sha256", "") == db::sha256_hex(night.suite.text) &&
                      plan.value("selection", "") == night.selection_json && plan.value("shards", 0) == night.shards;
    if (plan.value("merged", false)) {
      for (int shard = 1; shard <= plan.value("shards", 0); ++shard)
        for (const char* ending : {".db", ".log", ".code"}) fs::remove(file_of(path_, shard, ending));
    } else if (!same) {
      refuse(fmt::format("the folder holds parts of another night that was not put together: {}, {} parts, {}",
                         plan.value("suite", "?"), plan.value("shards", 0), plan.value("selection", "?")),
             "end that night with the words that began it, or remove the folder, or name another with --folder");
    } else {
      write_script();
      return;
    }
  }
  write_plan("", false);
  write_script();
}

std::string ShardFolder::script() const { return (fs::path(path_) / "shard.sh").string(); }
std::string ShardFolder::store_of(int shard) const { return file_of(path_, shard, ".db"); }
std::string ShardFolder::log_of(int shard) const { return file_of(path_, shard, ".log"); }
std::string ShardFolder::log_for_slurm() const { return (fs::path(path_) / "shard-%a.log").string(); }

bool ShardFolder::is_done(int shard) const {
  if (!fs::exists(store_of(shard))) return false;
  try {
    const db::RunStore store = db::RunStore::open_read_only(store_of(shard));
    const std::vector<db::NightRecord> nights = store.nights();
    return nights.size() == 1 && nights.front().shard == shard && nights.front().shards == night_.shards &&
           nights.front().suite_toml == night_.suite.text && nights.front().selection_json == night_.selection_json;
  } catch (const db::StoreError&) {
    return false;
  }
}

bool ShardFolder::has_ended(int shard) const { return fs::exists(file_of(path_, shard, ".code")); }

std::string ShardFolder::why_failed(int shard) const {
  const std::string code = last_line(file_text(file_of(path_, shard, ".code")));
  const std::string said = last_line(file_text(log_of(shard)));
  return fmt::format(
      "{}{}",
      code.empty() ? "its process left no exit code: it was killed, or never began" : fmt::format("exit code {}", code),
      said.empty() ? "" : fmt::format("; last line: {}", said));
}

std::vector<int> ShardFolder::missing() const {
  std::vector<int> missing;
  for (int shard = 1; shard <= night_.shards; ++shard)
    if (!is_done(shard)) missing.push_back(shard);
  return missing;
}

void ShardFolder::forget_end(const std::vector<int>& shards) const {
  for (const int shard : shards) fs::remove(file_of(path_, shard, ".code"));
}

std::string ShardFolder::job() const { return plan_of(path_).value("job", ""); }
void ShardFolder::set_job(const std::string& job) const { write_plan(job, false); }
void ShardFolder::set_merged() const { write_plan("", true); }

void ShardFolder::write_plan(const std::string& job, bool merged) const {
  const nlohmann::ordered_json plan = {{"suite", night_.suite.name},
                                       {"suite_sha256", db::sha256_hex(night_.suite.text)},
                                       {"selection", night_.selection_json},
                                       {"shards", night_.shards},
                                       {"job", job},
                                       {"merged", merged}};
  write_whole(plan_in(path_).string(), analysis::json_line(plan) + "\n");
}

// A part's store is made on a disk of the machine that carries it out: SQLite does not write on a network's disk. It is
// copied under another name first, so that a store with its own name is whole.
void ShardFolder::write_script() const {
  std::vector<std::string> words;
  for (const std::string& word : night_.words) words.push_back(shell_word(word));
  const std::string text = fmt::format(
      R"(#!/bin/sh
#SBATCH --job-name=tactbench-night
#SBATCH --cpus-per-task={jobs}
#SBATCH --open-mode=truncate
# One of {shards} parts of a night. Slurm names the part; without it: sh shard.sh 3, parallel sh shard.sh ::: $(seq {shards})
set -u
part=${{SLURM_ARRAY_TASK_ID:-$1}}
folder={folder}
cd {where} || exit 2
rm -f "$folder/shard-$part.code" "$folder/shard-$part.db"
scratch=$(mktemp -d "${{SLURM_TMPDIR:-${{TMPDIR:-/tmp}}}}/tactbench-shard.XXXXXX") || exit 2
trap 'rm -rf "$scratch"' EXIT
{program} {words} --shard "$part/{shards}" --db "$scratch/shard.db"
code=$?
case $code in
  0|1|6)  # the night's own words: all as expected, a scenario is red, one moved
    if cp "$scratch/shard.db" "$folder/shard-$part.db.part" && mv "$folder/shard-$part.db.part" "$folder/shard-$part.db"
    then end=0; else code=5 end=5; fi ;;
  *) end=$code ;;
esac
echo "$code" >"$folder/shard-$part.code.part" && mv "$folder/shard-$part.code.part" "$folder/shard-$part.code"
exit $end
)",
      fmt::arg("jobs", night_.jobs), fmt::arg("shards", night_.shards), fmt::arg("folder", shell_word(path_)),
      fmt::arg("where", shell_word(fs::current_path().string())),
      fmt::arg("program", shell_word(fs::read_symlink("/proc/self/exe").string())),
      fmt::arg("words", fmt::join(words, " ")));
  write_whole(script(), text);
}

}  // namespace tactbench::bench
