// The write-ahead log of a durable run has its full length at the first frame: commits then write over it, which needs
// no commit of the file system's journal.
#include <catch2/catch.hpp>
#include <filesystem>

#include "tests/db/store_example.h"
#include "tests/support/process.h"

using namespace tactbench::db;
using namespace tactbench::tests;

namespace {

constexpr std::uintmax_t kFullLog = 1000 * (4096 + 24) + 32;

}  // namespace

TEST_CASE("a durable run writes over its log and does not lengthen it") {
  const TemporaryFolder folder;
  const std::string path = folder.path("runs.db");
  RunStore store = RunStore::open(path, Durability::kFull);
  const auto [run, branch] = begin_example(store);
  const std::uintmax_t length = std::filesystem::file_size(path + "-wal");
  CHECK(length >= kFullLog);
  for (int i = 0; i < 50; ++i) store.append_frame(run, example_frame(branch, i));
  CHECK(std::filesystem::file_size(path + "-wal") == length);
  const RunStore reader = RunStore::open_read_only(path);  // a rolled-back transaction has no content
  CHECK(reader.frame_count(run) == 50);
  CHECK(reader.check_structure().empty());
  store.end_run(run, Outcome::kCompleted, "", SafeState::kVerified, "");
  CHECK(store.check_content(run).holds());
}

TEST_CASE("a run under the turned clock does not lengthen the log") {
  const TemporaryFolder folder;
  RunStore store = RunStore::open(folder.path("runs.db"), Durability::kNormal);
  begin_example(store);
  CHECK(std::filesystem::file_size(folder.path("runs.db-wal")) < 400'000);
}

TEST_CASE("a log that is long enough is left alone") {
  const TemporaryFolder folder;
  const std::string path = folder.path("runs.db");
  RunStore store = RunStore::open(path, Durability::kFull);
  begin_example(store);
  const std::uintmax_t length = std::filesystem::file_size(path + "-wal");
  const std::int64_t run = store.begin_run(example_run());
  CHECK(std::filesystem::file_size(path + "-wal") == length);
  CHECK(store.run(run).sequences.size() == 2);
}
