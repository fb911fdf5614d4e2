// Locks of a store and of its runs, between processes as between objects of one: whoever opens the file anew is
// another.
#include <poll.h>
#include <signal.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <filesystem>

#include "bench/common/error.h"
#include "bench/common/utc.h"
#include "bench/run/control/locks.h"
#include "tests/support/process.h"
#include "tests/support/refusal.h"
#include "tests/support/small_run.h"

using namespace tactbench;
using namespace tactbench::bench;
using namespace tactbench::tests;
using std::chrono::milliseconds;

namespace {

template <class Work>
std::string lock_refused_as(const Work& work) {
  const auto error = refusal_by(work);
  if (!error) return "not refused";
  CHECK(error->code() == (error->id() == "TB-STORE-LOCK" ? ExitCode::kStore : ExitCode::kUsage));
  CHECK_THAT(error->where(), Catch::EndsWith("-lock"));
  CHECK_FALSE(error->remedy().empty());
  return error->id();
}

struct LockedStore {
  LockedStore() : path(folder.path("runs.db")), store(db::RunStore::open(path, db::Durability::kNormal)) {}
  std::int64_t begin() {
    const RunRequest request = small_request();
    if (!store.sensor(request.sensor.serial)) store.add_sensor(request.sensor);
    db::RunRecord run;
    run.sensor_serial = request.sensor.serial;
    run.bench_id = "b";
    run.state = "prepared";
    run.origin = "simulated";
    run.started_utc = utc_now();
    return store.begin_run(run);
  }
  const TemporaryFolder folder;
  const std::string path;
  db::RunStore store;
};

// A process that takes the lock of a new run as `run` does once it is told to, says so, and lives until it is killed.
// It has to be made before a lock that it is to meet: a copy of a process holds what the process held.
class OtherRun {
 public:
  explicit OtherRun(const std::string& db_path) {
    REQUIRE((pipe(ends_) == 0 && pipe(told_) == 0));
    child_ = fork();
    if (child_ == 0) {
      char byte = 0;
      try {
        if (read(told_[0], &byte, 1) != 1) _exit(1);
        const RunLock lock(db_path);
        lock.take_new(kNumber);
        (void)!write(ends_[1], "x", 1);
        pause();
      } catch (...) {
      }
      _exit(1);
    }
    close(ends_[1]);
  }
  ~OtherRun() {
    kill(child_, SIGKILL);
    waitpid(child_, nullptr, 0);
    for (const int end : {ends_[0], told_[0], told_[1]}) close(end);
  }
  static constexpr std::int64_t kNumber = 12;
  [[nodiscard]] Peer peer() const { return {child_, geteuid(), false}; }
  void begin() const { REQUIRE(write(told_[1], "x", 1) == 1); }
  OtherRun(const OtherRun&) = delete;
  OtherRun& operator=(const OtherRun&) = delete;
  [[nodiscard]] bool holds_within(int wait_ms) const {
    pollfd said{ends_[0], POLLIN, 0};
    return poll(&said, 1, wait_ms) == 1;
  }

 private:
  int ends_[2] = {-1, -1}, told_[2] = {-1, -1};
  pid_t child_ = -1;
};

}  // namespace

TEST_CASE("store locks: runs share a store, a start that searches for dead runs locks it exclusively") {
  LockedStore own;
  const StoreLocks start(own.path);
  {
    const RunLock one(own.path), other(own.path);
    CHECK_FALSE(start.take_whole());
  }
  REQUIRE(start.take_whole());
  const StoreLocks late(own.path);
  CHECK_FALSE(late.take_whole());
  const auto begun = std::chrono::steady_clock::now();
  CHECK(lock_refused_as([&] { late.share(milliseconds(20)); }) == "TB-STORE-LOCK");
  CHECK(std::chrono::steady_clock::now() - begun >= milliseconds(20));
}

TEST_CASE("store locks: a run waits while another start holds the store, and counts as live afterwards") {
  LockedStore own;
  {
    const OtherRun run(own.path);
    auto start = std::make_unique<StoreLocks>(own.path);
    REQUIRE(start->take_whole());
    run.begin();
    CHECK_FALSE(run.holds_within(200));
    start.reset();
    REQUIRE(run.holds_within(10'000));
    CHECK_FALSE(StoreLocks(own.path).take_whole());
  }
  CHECK(StoreLocks(own.path).take_whole());  // gone with its process
}

TEST_CASE("store locks: a live process's run is not marked interrupted, a dead one's is") {
  LockedStore own;
  const std::int64_t run = own.begin();
  const BenchConfig config = small_request().bench;
  {
    const OtherRun live(own.path);
    live.begin();
    REQUIRE(live.holds_within(10'000));
    (void)open_for_running(own.path, config);
    CHECK(own.store.run(run).outcome == db::Outcome::kIncomplete);
  }
  (void)open_for_running(own.path, config);
  CHECK(own.store.run(run).outcome == db::Outcome::kInterrupted);
}

TEST_CASE("store locks: a run has one process, another run of the store can have another") {
  LockedStore own;
  const RunLock one(own.path), other(own.path);
  CHECK(is_carried_out(own.path, 7) == false);
  one.take_again(7);
  CHECK(is_carried_out(own.path, 7) == true);
  CHECK(is_carried_out(own.path, 9) == false);
  CHECK(is_carried_out(own.folder.path("none.db"), 7) == std::nullopt);
  CHECK(lock_refused_as([&] { other.take_again(7); }) == "TB-RUN-LIVE");
  for (const std::int64_t beside : {6, 8}) CHECK(lock_refused_as([&] { other.take_again(beside); }) == "not refused");
  const RunRequest request = [&] {
    RunRequest made = small_request();
    made.resume = own.begin();
    return made;
  }();
  const RunLock holder(own.path);
  holder.take_again(request.resume);
  CHECK(lock_refused_as([&] { (void)run_small(request, own.store); }) == "TB-RUN-LIVE");
  CHECK(own.store.run(request.resume).outcome == db::Outcome::kIncomplete);
}

TEST_CASE("store locks: a process is known to carry out a run of a store by the lock that it holds, and by no other") {
  const LockedStore own, other;
  const OtherRun run(own.path);
  const RunLock shared(own.path), beside(other.path);
  CHECK_FALSE(carries_out_run_of(run.peer(), own.path));
  run.begin();
  REQUIRE(run.holds_within(10'000));
  CHECK(is_carried_out(own.path, OtherRun::kNumber) == true);
  CHECK(carries_out_run_of(run.peer(), own.path));
  CHECK_FALSE(carries_out_run_of(run.peer(), other.path));
  CHECK_FALSE(carries_out_run_of(run.peer(), own.folder.path("none.db")));
  CHECK_FALSE(carries_out_run_of({run.peer().process, geteuid() + 1, false}, own.path));  // the number was another's
  CHECK_FALSE(carries_out_run_of({getpid(), geteuid(), false}, own.path));  // has the file open, and carries out none
}

TEST_CASE("store locks: a lock file that goes is made again with its locks, unless another process was quicker") {
  LockedStore own;
  const std::string lock = own.path + "-lock";
  RunLock run(own.path);
  run.take_again(7);
  CHECK_FALSE(run.renew(7));
  for (const bool replaced : {false, true}) {
    std::filesystem::remove(lock);
    if (replaced) write_file(lock, "");
    CHECK(is_carried_out(own.path, 7) != true);
    CHECK(run.renew(7));
    CHECK(is_carried_out(own.path, 7) == true);
    CHECK_FALSE(StoreLocks(own.path).take_whole());
  }
  std::filesystem::remove(lock);
  const StoreLocks start(own.path);
  REQUIRE(start.take_whole());
  CHECK(lock_refused_as([&] { (void)run.renew(7); }) == "TB-STORE-LOCK");
}

TEST_CASE("store locks: one empty file beside the store, never the target of a link") {
  LockedStore own;
  for (int i = 0; i < 3; ++i) const RunLock lock(own.path);
  struct stat found {};
  REQUIRE(stat((own.path + "-lock").c_str(), &found) == 0);
  CHECK(found.st_size == 0);
  const std::filesystem::directory_iterator files(own.folder.path());
  CHECK(std::distance(files, std::filesystem::directory_iterator()) <= 4);  // store, wal, shm, lock
  std::filesystem::create_symlink(own.path, own.folder.path("other.db"));
  const StoreLocks here(own.path), there(own.folder.path("other.db"));  // one store, two names
  REQUIRE(here.take_whole());
  CHECK_FALSE(there.take_whole());
  const std::string precious = own.folder.path("precious");
  write_file(precious, "kept");
  std::filesystem::remove(own.path + "-lock");
  std::filesystem::create_symlink(precious, own.path + "-lock");
  CHECK(lock_refused_as([&] { const RunLock lock(own.path); }) == "TB-STORE-LOCK");
  CHECK(read_file(precious) == "kept");
}

TEST_CASE("store locks: they hold one descriptor while they live, none where they refuse") {
  const LockedStore kept;
  const auto next_descriptor = [] {
    const int next = ::dup(STDERR_FILENO);
    ::close(next);
    return next;
  };
  const int before = next_descriptor();
  for (int turn = 0; turn < 2; ++turn) {  // one that makes the file, and one that finds it
    const StoreLocks locks(kept.path);
    CHECK(next_descriptor() == before + 1);
  }
  CHECK(next_descriptor() == before);
  std::filesystem::remove(kept.path + "-lock");
  REQUIRE(::mkfifo((kept.path + "-lock").c_str(), 0600) == 0);
  CHECK(lock_refused_as([&] { const StoreLocks locks(kept.path); }) == "TB-STORE-LOCK");
  CHECK(next_descriptor() == before);
}

TEST_CASE("store locks: a lock file that is none, and a store that is not there") {
  LockedStore own;
  const std::string lock = own.path + "-lock";
  REQUIRE(mkfifo(lock.c_str(), 0600) == 0);
  const auto refused = [&] { return lock_refused_as([&] { const StoreLocks locks(own.path); }); };
  CHECK(refused() == "TB-STORE-LOCK");
  std::filesystem::remove(lock);
  std::filesystem::create_directory(lock);
  CHECK(refused() == "TB-STORE-LOCK");
  std::filesystem::remove(lock);
  std::filesystem::create_symlink("elsewhere", lock);
  CHECK(refused() == "TB-STORE-LOCK");
  CHECK(is_carried_out(own.path, 7) == std::nullopt);
  std::filesystem::remove(lock);
  std::filesystem::remove(own.path);
  CHECK(refused() == "TB-STORE-LOCK");
  CHECK_FALSE(std::filesystem::exists(lock));
}

TEST_CASE("store locks: the lock file has the store's rights and owner, whatever the umask takes") {
  LockedStore own;
  const std::string lock = own.path + "-lock";
  for (const mode_t mode : {0757, 0666, 0600}) {
    REQUIRE(chmod(own.path.c_str(), mode) == 0);
    std::filesystem::remove(lock);
    const mode_t before = umask(0177);
    { const StoreLocks locks(own.path); }
    umask(before);
    struct stat made {};
    REQUIRE(stat(lock.c_str(), &made) == 0);
    CHECK((made.st_mode & 07777) == (mode & 0666U));
  }
  if (geteuid() != 0) return;
  REQUIRE(chown(own.path.c_str(), 65534, 54321) == 0);
  std::filesystem::remove(lock);
  { const StoreLocks locks(own.path); }
  struct stat made {};
  REQUIRE(stat(lock.c_str(), &made) == 0);
  CHECK((made.st_uid == 65534 && made.st_gid == 54321));
}
