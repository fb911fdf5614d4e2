// runs export of a long run: the file is written frame by frame, and memory does not grow with the run.
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <filesystem>

#include "tests/bench/run/stored_past.h"
#include "tests/support/paths.h"
#include "tests/support/process.h"

using namespace tactbench;
using namespace tactbench::tests;

namespace {

std::int64_t store_frames(db::RunStore& store, int frames) {
  db::RunRecord run;
  run.uuid = db::new_uuid();
  run.origin = "simulated";
  run.state = "prepared";
  run.sequences = {{0, "long", "", "", 1, frames}};
  const std::int64_t number = store.begin_run(run);
  db::FrameRecord frame;
  frame.branch = store.begin_branch(number, {});
  frame.rows = frame.columns = 16;
  frame.scans = 2;
  frame.counts.assign(512, 0);
  for (int i = 0; i < frames; ++i) {
    frame.ordinal = i;
    frame.time_ns = 1'000'000'000LL * i;
    for (std::size_t c = 0; c < frame.counts.size(); ++c) frame.counts[c] = static_cast<std::uint16_t>(40'000 + c + i);
    store.append_frame(number, frame);
  }
  store.end_run(number, db::Outcome::kCompleted, "", db::SafeState::kVerified, "");
  return number;
}

// Of one call of the program, in MB.
double peak_memory(const TemporaryFolder& folder, std::vector<std::string> words) {
  words.insert(words.begin(), program_path());
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  const pid_t child = fork();
  if (child == 0) {
    if (chdir(folder.path().c_str()) != 0 || freopen("/dev/null", "w", stdout) == nullptr) _exit(126);
    execv(argv[0], argv.data());
    _exit(127);
  }
  int status = 0;
  rusage used{};
  REQUIRE(wait4(child, &status, 0, &used) == child);
  REQUIRE(WIFEXITED(status));
  REQUIRE(WEXITSTATUS(status) == 0);
  return static_cast<double>(used.ru_maxrss) / 1024.0;
}

}  // namespace

TEST_CASE("export: a run with ten times as many frames needs no more memory") {
  const TemporaryFolder folder;
  {
    db::RunStore store = db::RunStore::open(folder.path("runs.db"), db::Durability::kNormal);
    REQUIRE(store_frames(store, 1'000) == 1);
    REQUIRE(store_frames(store, 10'000) == 2);
  }
  for (const char* format : {"json", "csv"}) {
    const std::string file = std::string("2.") + format;
    const double brief = peak_memory(folder, {"runs", "export", "1", "--format", format, "-o", "1." + file});
    const double lengthy = peak_memory(folder, {"runs", "export", "2", "--format", format, "-o", file});
    INFO(format << ": " << brief << " MB for 1000 frames, " << lengthy << " MB for 10000");
    CHECK(std::filesystem::file_size(folder.path(file)) > 25'000'000);
    CHECK(lengthy < brief + 10.0);  // as one text 30 MB more, as one tree 150 MB
  }
}
