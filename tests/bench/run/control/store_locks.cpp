// Locks of a store and of its runs, between processes as between objects of one: whoever opens the file anew is
// another.
#include <poll.h>
#include <signal.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cerrno>
#include <chrono>
#include <filesystem>

#include "bench/common/error.h"
#include "bench/common/utc.h"
#include "bench/run/control/control_client.h"
#include "bench/run/control/locks.h"
#include "tests/bench/run/control/apart.h"
#include "tests/support/process.h"
#include "tests/support/refusal.h"
#include "tests/support/small_run.h"
#include "tests/support/variable.h"

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
        lock.lock_new_run(kNumber);
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

TEST_CASE("store locks: runs share a store, a start that looks for dead runs locks it exclusively") {
  LockedStore own;
  const StoreLocks start(own.path);
  {
    const RunLock one(own.path), other(own.path);
    CHECK_FALSE(start.try_lock_store());
  }
  REQUIRE(start.try_lock_store());
  const StoreLocks late(own.path);
  CHECK_FALSE(late.try_lock_store());
  const auto begun = std::chrono::steady_clock::now();
  CHECK(lock_refused_as([&] { late.share(milliseconds(20)); }) == "TB-STORE-LOCK");
  CHECK(std::chrono::steady_clock::now() - begun >= milliseconds(20));
}

TEST_CASE("store locks: a run waits while another start locks the store, and counts as live afterwards") {
  LockedStore own;
  {
    const OtherRun run(own.path);
    auto start = std::make_unique<StoreLocks>(own.path);
    REQUIRE(start->try_lock_store());
    run.begin();
    CHECK_FALSE(run.holds_within(200));
    start.reset();
    REQUIRE(run.holds_within(10'000));
    CHECK_FALSE(StoreLocks(own.path).try_lock_store());
  }
  CHECK(StoreLocks(own.path).try_lock_store());  // gone with its process
}

TEST_CASE("store locks: a run with a live process is not marked interrupted, a run with a dead process is") {
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

TEST_CASE("store locks: a run has only one process, another run of the store may have another") {
  LockedStore own;
  const RunLock one(own.path), other(own.path);
  CHECK(is_carried_out(own.path, 7) == false);
  one.lock_for_resume(7);
  CHECK(is_carried_out(own.path, 7) == true);
  CHECK(is_carried_out(own.path, 9) == false);
  CHECK(is_carried_out(own.folder.path("none.db"), 7) == std::nullopt);
  CHECK(lock_refused_as([&] { other.lock_for_resume(7); }) == "TB-RUN-LIVE");
  for (const std::int64_t beside : {6, 8})
    CHECK(lock_refused_as([&] { other.lock_for_resume(beside); }) == "not refused");
  const RunRequest request = [&] {
    RunRequest made = small_request();
    made.resume = own.begin();
    return made;
  }();
  const RunLock holder(own.path);
  holder.lock_for_resume(request.resume);
  CHECK(lock_refused_as([&] { (void)run_small(request, own.store); }) == "TB-RUN-LIVE");
  CHECK(own.store.run(request.resume).outcome == db::Outcome::kIncomplete);
}

TEST_CASE("store locks: a process is recognised as executing a run of a store only by its lock") {
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

TEST_CASE("store locks: a removed lock file is created again with its locks, unless another process was faster") {
  LockedStore own;
  const std::string lock = own.path + "-lock";
  RunLock run(own.path);
  run.lock_for_resume(7);
  CHECK_FALSE(run.renew(7));
  for (const bool replaced : {false, true}) {
    std::filesystem::remove(lock);
    if (replaced) write_file(lock, "");
    CHECK(is_carried_out(own.path, 7) != true);
    CHECK(run.renew(7));
    CHECK(is_carried_out(own.path, 7) == true);
    CHECK_FALSE(StoreLocks(own.path).try_lock_store());
  }
  std::filesystem::remove(lock);
  const StoreLocks start(own.path);
  REQUIRE(start.try_lock_store());
  CHECK(lock_refused_as([&] { (void)run.renew(7); }) == "TB-STORE-LOCK");
}

TEST_CASE("store locks: one empty file next to the store, never the target of a link") {
  LockedStore own;
  for (int i = 0; i < 3; ++i) const RunLock lock(own.path);
  struct stat found {};
  REQUIRE(stat((own.path + "-lock").c_str(), &found) == 0);
  CHECK(found.st_size == 0);
  const std::filesystem::directory_iterator files(own.folder.path());
  CHECK(std::distance(files, std::filesystem::directory_iterator()) <= 4);  // store, wal, shm, lock
  std::filesystem::create_symlink(own.path, own.folder.path("other.db"));
  const StoreLocks here(own.path), there(own.folder.path("other.db"));  // one store, two names
  REQUIRE(here.try_lock_store());
  CHECK_FALSE(there.try_lock_store());
  const std::string precious = own.folder.path("precious");
  write_file(precious, "kept");
  std::filesystem::remove(own.path + "-lock");
  std::filesystem::create_symlink(precious, own.path + "-lock");
  CHECK(lock_refused_as([&] { const RunLock lock(own.path); }) == "TB-STORE-LOCK");
  CHECK(read_file(precious) == "kept");
}

TEST_CASE("store locks: use one descriptor while they exist, and no descriptor after a failure") {
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

TEST_CASE("store locks: a lock path that is not a regular file, and a missing store are rejected") {
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

TEST_CASE("store locks: the lock file has the access rights and the owner of the store, whatever the umask is") {
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

// Names that one process at a time holds, and the identification of the peer.

namespace {

template <class Work>
std::string refusal_of(const Work& work) {
  const auto error = refusal_by(work);
  if (!error) return "not refused";
  return error->id() + ": " + error->what();
}

}  // namespace

TEST_CASE("machine names: have one holder, are listed while it lives, and are free when it ends") {
  const auto listed = [](const std::string& name) {
    const auto names = held_names();
    return std::find(names.begin(), names.end(), name) != names.end();
  };
  {
    const Apart other([](const Stay& stay) {
      const MachineName name("rig/dead-man");
      if (name.held()) stay();
    });
    REQUIRE(other.ready());
    const MachineName second("rig/dead-man");
    CHECK_FALSE(second.held());
    CHECK(second.owner() == peer_text({other.process(), geteuid(), false}));
    CHECK(listed("rig/dead-man"));
  }
  CHECK_FALSE(listed("rig/dead-man"));
  CHECK(MachineName("rig/dead-man").held());
}

TEST_CASE("machine names: do not depend on folders or on the home of the user") {
  BenchConfig config;
  config.id = "machine-" + std::to_string(getpid());
  const Variable scope("TACTBENCH_RUNTIME_DIR", std::nullopt);  // the machine's own names
  const Apart other([&](const Stay& stay) {
    const BenchLock lock(config);
    stay();
  });
  REQUIRE(other.ready());
  const TemporaryFolder folder;
  const Variable runtime("XDG_RUNTIME_DIR", folder.path()), temporary("TMPDIR", folder.path()),
      home("HOME", std::nullopt);
  const std::string refused = refusal_of([&] { const BenchLock lock(config); });
  CHECK_THAT(refused,
             Catch::StartsWith("TB-BENCH-LOCKED") && Catch::Contains("pid " + std::to_string(other.process())));
  config.in_process = true;  // no rig to share
  CHECK(refusal_of([&] { const BenchLock lock(config); }) == "not refused");
}

TEST_CASE(
    "locks and sockets: with TACTBENCH_RUNTIME_DIR they are apart from the machine's, the folder must be private") {
  const TemporaryFolder folder;
  const MachineName mine("rig");
  REQUIRE(mine.held());
  {
    const Variable scope("TACTBENCH_RUNTIME_DIR", folder.path());
    CHECK(held_names().empty());
    CHECK(MachineName("rig").held());
    std::filesystem::create_directory_symlink(folder.path(), folder.path("link"));
  }
  const auto hold = [] { const MachineName name("rig"); };
  {
    const Variable scope("TACTBENCH_RUNTIME_DIR", folder.path("link"));
    CHECK_THAT(refusal_of(hold), Catch::StartsWith("TB-FOLDER-UNSAFE") && Catch::Contains("link"));
  }
  const Variable scope("TACTBENCH_RUNTIME_DIR", folder.path());
  REQUIRE(chmod(folder.path().c_str(), 0755) == 0);
  CHECK_THAT(refusal_of(hold), Catch::StartsWith("TB-FOLDER-UNSAFE"));
  REQUIRE(chmod(folder.path().c_str(), 0700) == 0);
  if (geteuid() != 0) return;
  REQUIRE(chown(folder.path().c_str(), kNobodyHere, kNobodyHere) == 0);
  CHECK_THAT(refusal_of(hold), Catch::StartsWith("TB-FOLDER-UNSAFE") && Catch::Contains("65534"));
}

TEST_CASE("machine names: another user who holds the name of a bench is named, and not trusted") {
  if (geteuid() != 0) {
    WARN("skipped: only root can be another user");
    return;
  }
  BenchConfig config;
  config.id = "squatted-" + std::to_string(getpid());
  const Variable scope("TACTBENCH_RUNTIME_DIR", std::nullopt);
  const Apart stranger([&](const Stay& stay) {
    become_nobody(kNobodyHere);
    const MachineName name(config.id);
    if (name.held()) stay();
  });
  REQUIRE(stranger.ready());
  CHECK_THAT(refusal_of([&] { const BenchLock lock(config); }),
             Catch::StartsWith("TB-BENCH-LOCKED") && Catch::Contains("nobody (pid "));
  const int connected = connect_to_name(config.id);
  REQUIRE(connected >= 0);
  const std::optional<Peer> peer = peer_of(connected, kGroupHere);
  close(connected);
  REQUIRE(peer);
  CHECK(peer->user == kNobodyHere);
  CHECK(peer->process == stranger.process());
  CHECK_FALSE(peer->in_group);
  CHECK_FALSE(is_trusted(*peer, 5));
  CHECK_FALSE(is_trusted(*peer, 0));
  CHECK(is_trusted(*peer, kNobodyHere));
}

TEST_CASE("machine names: root, the same user and the group are trusted, by process credentials and not by name") {
  CHECK(is_trusted({1, 0, false}, 1000));
  CHECK(is_trusted({1, 1000, false}, 1000));
  CHECK(is_trusted({1, 1001, true}, 1000));
  CHECK_FALSE(is_trusted({1, 1001, false}, 1000));
  if (geteuid() != 0) return;
  for (const bool member : {true, false}) {
    const MachineName name("rig-" + std::to_string(member));
    REQUIRE(name.held());
    const Apart client([&](const Stay& stay) {
      become_nobody(member ? kGroupHere : kNobodyHere);
      if (connect_to_name(name.text()) >= 0) stay();
    });
    // The scope's folder is root's: another user is refused there.
    CHECK_FALSE(client.ready());
    const Variable scope("TACTBENCH_RUNTIME_DIR", std::nullopt);
    const MachineName open("group-" + std::to_string(getpid()) + "-" + std::to_string(member));
    const Apart other([&](const Stay& stay) {
      become_nobody(member ? kGroupHere : kNobodyHere);
      if (connect_to_name(open.text()) >= 0) stay();
    });
    REQUIRE(other.ready());
    const int accepted = accept4(open.descriptor(), nullptr, nullptr, SOCK_CLOEXEC);
    REQUIRE(accepted >= 0);
    const std::optional<Peer> peer = peer_of(accepted, kGroupHere);
    close(accepted);
    REQUIRE(peer);
    CHECK(peer->in_group == member);
    CHECK(is_trusted(*peer, 5) == member);
  }
}

TEST_CASE("machine names: waiting for a dead-man name lasts the given time, the holder of a bench is named") {
  {
    const MachineName dead_man = dead_man_name("rig 1", std::chrono::seconds(0));
    CHECK(dead_man.held());
    CHECK(dead_man.text().ends_with("/dead-man"));
    const auto begun = std::chrono::steady_clock::now();
    CHECK_FALSE(dead_man_name("rig 1", milliseconds(30)).held());
    CHECK(std::chrono::steady_clock::now() - begun >= milliseconds(30));
    CHECK(dead_man_name("rig 2", milliseconds(0)).held());
  }
  BenchConfig config;
  config.id = "rig";
  const BenchLock first(config);
  REQUIRE(first.name() != nullptr);
  CHECK(first.name()->text() == "rig");
  const std::vector<std::string> names = held_names();
  CHECK(std::is_sorted(names.begin(), names.end()));
  CHECK(std::count(names.begin(), names.end(), "rig") == 1);
  config.in_process = true;
  CHECK(BenchLock(config).name() == nullptr);
}

TEST_CASE("machine names: printed form, and names that are too long") {
  const std::string shown = shown_name("rig");
  CHECK(shown.front() == '@');
  CHECK(shown.ends_with("/rig"));
  {
    const Variable scope("TACTBENCH_RUNTIME_DIR", std::nullopt);
    CHECK(shown_name("rig") == "@tactbench/rig");
    const Variable none("TACTBENCH_RUNTIME_DIR", "");
    CHECK(shown_name("rig") == "@tactbench/rig");
    // 107 bytes after the first, which is 0.
    CHECK(MachineName(std::string(107 - 10, 'x')).held());
    CHECK_THAT(refusal_of([] { const MachineName name(std::string(108 - 10, 'x')); }),
               Catch::StartsWith("TB-BENCH-NAME"));
  }
  const TemporaryFolder folder;
  const Variable scope("TACTBENCH_RUNTIME_DIR", folder.path());
  const std::string here = shown_name("rig");
  CHECK(here.size() == 1 + 10 + 16 + 1 + 3);  // "@tactbench:", a part of the folder's hash, "/rig"
  CHECK(here.starts_with("@tactbench:"));
  const int none = connect_to_name("rig"), why = errno;
  CHECK(none == -1);
  CHECK(why == ECONNREFUSED);
  const MachineName name("rig");
  CHECK(name.owner() == peer_text({getpid(), geteuid(), false}));
  MachineName moved = MachineName("other");
  CHECK(moved.held());
  const MachineName last = std::move(moved);
  CHECK(last.held());
  CHECK(held_names() == std::vector<std::string>{"other", "rig"});
  { const MachineName lone("lone"); }
  CHECK(MachineName("nobody's").owner() == peer_text({getpid(), geteuid(), false}));
}

TEST_CASE("machine names: which held names are runs, and which data of silent ones are available") {
  const TemporaryFolder folder;
  const Variable scope("TACTBENCH_RUNTIME_DIR", folder.path());
  CHECK(run_names().empty());
  std::vector<MachineName> held;
  for (const char* name : {"b2", "b", "b/dead-man", "b/run/7", "b/process/12", "b/process/12/run/9", "b/processes/3"})
    held.emplace_back(name);
  using Names = std::vector<std::string>;
  CHECK(run_names() == Names{"b", "b/process/12", "b2"});
  CHECK(run_names("b") == Names{"b", "b/process/12"});
  CHECK(run_names("b2") == Names{"b2"});
  CHECK(run_names("b3").empty());
  ListenOptions options;
  options.longest = milliseconds(20);
  const RunReplies heard = send_to_runs({"b", "none", "b/process/12", "b2"}, Command::kStatus, options);
  CHECK(heard.answers.empty());
  REQUIRE(heard.silent.size() == 3);
  const auto told = [](const SilentBench& one) {
    CHECK_FALSE(one.stranger);
    CHECK(one.server->process == getpid());
    return one.name + " of " + one.bench + ", run " + std::to_string(one.run);
  };
  CHECK(told(heard.silent[0]) == "b of b, run 7");
  CHECK(told(heard.silent[1]) == "b/process/12 of b, run 9");
  CHECK(told(heard.silent[2]) == "b2 of b2, run 0");
  CHECK_FALSE(send_command("none", Command::kStatus));
  RunConnection gone("none", "follow"), silent("b", "follow");
  CHECK_FALSE(gone.open());
  CHECK_FALSE(gone.newest());
  CHECK(silent.open());
  CHECK_FALSE(silent.newest());
  CHECK(silent.open());
}
