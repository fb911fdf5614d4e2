// The folder of a night in parts: its plan, its script, and what its parts left.
#include "bench/fleet/shard_folder.h"

#include <catch2/catch.hpp>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "bench/common/error.h"
#include "bench/fleet/tool.h"
#include "tests/bench/fleet/shard_night.h"
#include "tests/support/process.h"

using namespace tactbench;
using namespace tactbench::tests;
namespace fs = std::filesystem;

namespace {

std::string refusal_of_folder(const std::string& path, const bench::ShardedNight& night) {
  try {
    const bench::ShardFolder folder(path, night);
  } catch (const bench::Error& error) {
    CHECK(error.id() == "TB-FLEET-FOLDER");
    CHECK(error.code() == bench::ExitCode::kUsage);
    CHECK(error.where() == path);
    return std::string(error.what()) + " | " + error.remedy();
  }
  return "taken";
}

}  // namespace

TEST_CASE("a night's folder is made with its plan and its script, and all names of its parts") {
  const TemporaryFolder place;
  const std::string path = place.path("deep/er");
  const bench::ShardFolder folder(path + "/../er", night_of_three());
  CHECK(folder.script() == path + "/shard.sh");
  CHECK(folder.store_of(2) == path + "/shard-2.db");
  CHECK(folder.log_of(12) == path + "/shard-12.log");
  CHECK(folder.log_for_slurm() == path + "/shard-%a.log");
  CHECK(read_file(path + "/night.json") ==
        "{\"suite\":\"parts\",\"suite_sha256\":\"" + db::sha256_hex("schema = 1\n") +
            "\",\"selection\":\"{\\\"only\\\":\\\"\\\"}\",\"shards\":3,\"job\":\"\",\"merged\":false}\n");
  CHECK(folder.job().empty());
  folder.set_job("41");
  CHECK(folder.job() == "41");
  CHECK(bench::ShardFolder(path, night_of_three()).job() == "41");  // the same night goes on
  folder.set_merged();
  CHECK(folder.job().empty());
  CHECK(nlohmann::json::parse(read_file(path + "/night.json")).at("merged") == true);
}

TEST_CASE("the script of a night's parts, word by word") {
  const TemporaryFolder place;
  const bench::ShardFolder folder(place.path("n"), night_of_three());
  const std::string where = fs::current_path().string(), program = fs::read_symlink("/proc/self/exe").string();
  CHECK(read_file(folder.script()) ==
        "#!/bin/sh\n"
        "#SBATCH --job-name=tactbench-night\n"
        "#SBATCH --cpus-per-task=4\n"
        "#SBATCH --open-mode=truncate\n"
        "# One of 3 parts of a night. Slurm names the part; without it: sh shard.sh 3, parallel sh shard.sh ::: $(seq "
        "3)\n"
        "set -u\n"
        "part=${SLURM_ARRAY_TASK_ID:-$1}\n"
        "folder='" +
            place.path("n") +
            "'\n"
            "cd '" +
            where +
            "' || exit 2\n"
            "rm -f \"$folder/shard-$part.code\" \"$folder/shard-$part.db\"\n"
            "scratch=$(mktemp -d \"${SLURM_TMPDIR:-${TMPDIR:-/tmp}}/tactbench-shard.XXXXXX\") || exit 2\n"
            "trap 'rm -rf \"$scratch\"' EXIT\n"
            "'" +
            program +
            "' 'nightly' './it'\\''s.toml' '--jobs' '3' --shard \"$part/3\" --db \"$scratch/shard.db\"\n"
            "code=$?\n"
            "case $code in\n"
            "  0|1|6)  # the night's own words: all as expected, a scenario is red, one moved\n"
            "    if cp \"$scratch/shard.db\" \"$folder/shard-$part.db.part\" && mv \"$folder/shard-$part.db.part\" "
            "\"$folder/shard-$part.db\"\n"
            "    then end=0; else code=5 end=5; fi ;;\n"
            "  *) end=$code ;;\n"
            "esac\n"
            "echo \"$code\" >\"$folder/shard-$part.code.part\" && mv \"$folder/shard-$part.code.part\" "
            "\"$folder/shard-$part.code\"\n"
            "exit $end\n");
}

TEST_CASE("a part is done when its store holds that part of that night and nothing else") {
  const TemporaryFolder place;
  const bench::ShardFolder folder(place.path("n"), night_of_three());
  CHECK(folder.missing() == std::vector<int>{1, 2, 3});
  store_part(folder.store_of(2), record_of_part(2));
  CHECK(folder.is_done(2));
  CHECK(folder.missing() == std::vector<int>{1, 3});
  store_part(folder.store_of(3), record_of_part(3));
  CHECK(folder.missing() == std::vector<int>{1});
  const auto done_with = [&](auto change) {
    db::NightRecord record = record_of_part(1);
    change(record);
    store_part(folder.store_of(1), record);
    return folder.is_done(1);
  };
  CHECK(done_with([](db::NightRecord&) {}));
  CHECK_FALSE(done_with([](db::NightRecord& record) { record.shard = 2; }));
  CHECK_FALSE(done_with([](db::NightRecord& record) { record.shards = 4; }));
  CHECK_FALSE(done_with([](db::NightRecord& record) { record.suite_toml += "#"; }));
  CHECK_FALSE(done_with([](db::NightRecord& record) { record.selection_json = "{}"; }));
  CHECK(done_with([](db::NightRecord& record) { record.program = "another"; }));
  (void)db::RunStore::open(folder.store_of(1)).add_night(record_of_part(1));
  CHECK_FALSE(folder.is_done(1));  // two nights
  fs::remove(folder.store_of(1));
  { (void)db::RunStore::open(folder.store_of(1)).runs(); }
  CHECK_FALSE(folder.is_done(1));  // none
  write_file(folder.store_of(1), "no store");
  CHECK_FALSE(folder.is_done(1));
}

TEST_CASE("why a part failed: its exit code, and the last line of its log that says something") {
  const TemporaryFolder place;
  const bench::ShardFolder folder(place.path("n"), night_of_three());
  CHECK_FALSE(folder.has_ended(1));
  CHECK(folder.why_failed(1) == "its process left no exit code: it was killed, or never began");
  write_file(folder.log_of(1), "first\nsecond");
  CHECK(folder.why_failed(1) == "its process left no exit code: it was killed, or never began; last line: second");
  write_file(place.path("n/shard-1.code"), "5\n");
  CHECK(folder.has_ended(1));
  CHECK_FALSE(folder.has_ended(2));
  CHECK(folder.why_failed(1) == "exit code 5; last line: second");
  write_file(folder.log_of(1), "first\n  x \n \t\r\n\n");
  CHECK(folder.why_failed(1) == "exit code 5; last line:   x ");
  write_file(folder.log_of(1), " \n");
  CHECK(folder.why_failed(1) == "exit code 5");
  write_file(place.path("n/shard-2.code"), "0\n");
  folder.forget_end({1});
  CHECK_FALSE(folder.has_ended(1));
  CHECK(folder.has_ended(2));
  folder.forget_end({1, 2, 3});
  CHECK_FALSE(folder.has_ended(2));
}

TEST_CASE("a folder of others, of a file or of another night's parts is refused, and says why") {
  const TemporaryFolder place;
  write_file(place.path("file"), "x");
  CHECK(refusal_of_folder(place.path("file"), night_of_three()) ==
        "the folder of the parts cannot be made | name another with --folder");
  fs::create_directories(place.path("others"));
  write_file(place.path("others/x"), "x");
  CHECK(refusal_of_folder(place.path("others"), night_of_three()) ==
        "the folder holds files of others | name a new one with --folder");
  fs::create_directories(place.path("empty"));
  CHECK(refusal_of_folder(place.path("empty"), night_of_three()) == "taken");
  CHECK(refusal_of_folder(place.path("empty"), night_of_three()) == "taken");
  const std::string another =
      "the folder holds parts of another night that was not put together: parts, 3 parts, {\"only\":\"\"} | end that "
      "night with the words that began it, or remove the folder, or name another with --folder";
  bench::ShardedNight other = night_of_three();
  other.suite.text += "#";
  CHECK(refusal_of_folder(place.path("empty"), other) == another);
  other = night_of_three();
  other.selection_json = "{}";
  CHECK(refusal_of_folder(place.path("empty"), other) == another);
  other = night_of_three();
  other.shards = 2;
  CHECK(refusal_of_folder(place.path("empty"), other) == another);
  write_file(place.path("empty/night.json"), "[]");
  CHECK(refusal_of_folder(place.path("empty"), night_of_three()) ==
        "night.json in this folder cannot be read | name a new one with --folder");
  write_file(place.path("empty/night.json"), "{}");
  CHECK(refusal_of_folder(place.path("empty"), night_of_three()) ==
        "the folder holds parts of another night that was not put together: ?, 0 parts, ? | end that night with the "
        "words that began it, or remove the folder, or name another with --folder");
}

TEST_CASE("the folder of a night that was put together begins anew without its parts, even for another night") {
  const TemporaryFolder place;
  const bench::ShardFolder before(place.path("n"), night_of_three());
  for (const int shard : {1, 3}) {
    write_file(before.store_of(shard), "s");
    write_file(before.log_of(shard), "l");
    write_file(place.path("n/shard-" + std::to_string(shard) + ".code"), "0");
  }
  write_file(place.path("n/kept"), "k");
  before.set_merged();
  bench::ShardedNight other = night_of_three();
  other.shards = 2;
  other.suite.name = "next";
  const bench::ShardFolder after(place.path("n"), other);
  std::vector<std::string> left;
  for (const auto& file : fs::directory_iterator(place.path("n"))) left.push_back(file.path().filename().string());
  std::ranges::sort(left);
  CHECK(left == std::vector<std::string>{"kept", "night.json", "shard.sh"});
  const auto plan = nlohmann::json::parse(read_file(place.path("n/night.json")));
  CHECK(plan.at("suite") == "next");
  CHECK(plan.at("shards") == 2);
  CHECK(plan.at("merged") == false);
  CHECK(after.missing() == std::vector<int>{1, 2});
}
