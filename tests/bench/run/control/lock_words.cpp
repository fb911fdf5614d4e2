// What the locks of benches, stores and runs say and leave behind, the names that processes hold, and commands that are
// told of events.
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cerrno>
#include <chrono>
#include <filesystem>
#include <string>
#include <thread>
#include <vector>

#include "bench/common/error.h"
#include "bench/run/control/control_client.h"
#include "bench/run/control/locks.h"
#include "bench/run/control/machine_name.h"
#include "bench/run/control/notify.h"
#include "bench/run/control/peer.h"
#include "bench/run/control/run_connection.h"
#include "db/run_store.h"
#include "tests/support/process.h"
#include "tests/support/refusal.h"
#include "tests/support/variable.h"

using namespace tactbench;
using namespace tactbench::bench;
using namespace tactbench::tests;
using std::chrono::milliseconds;

namespace {

template <class Work>
std::string lock_refusal(const Work& work) {
  const auto error = refusal_by(work);
  if (!error) return "not refused";
  return std::to_string(static_cast<int>(error->code())) + " " + error->id() + ": " + error->what() + " | " +
         error->where() + " | " + error->remedy();
}

struct StoreToLock {
  StoreToLock() { (void)db::RunStore::open(path, db::Durability::kNormal); }
  const TemporaryFolder folder;
  const std::string path = folder.path("runs.db");
  const std::string lock = std::filesystem::weakly_canonical(path).string() + "-lock";
};

bool appears(const std::string& path, const std::string& text) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(20);
  while (std::chrono::steady_clock::now() < end) {
    if (std::filesystem::exists(path) && read_file(path) == text) return true;
    std::this_thread::sleep_for(milliseconds(2));
  }
  return false;
}

}  // namespace

TEST_CASE("lock words: a store that another start holds, a run that another process carries out") {
  const StoreToLock own;
  const StoreLocks start(own.path), late(own.path);
  REQUIRE(start.take_whole());
  const auto begun = std::chrono::steady_clock::now();
  CHECK(lock_refusal([&] { late.share(milliseconds(20)); }) ==
        "5 TB-STORE-LOCK: another start has held the store for 0.02 s | " + own.lock +
            " | see what has the store open, and try again");
  CHECK(std::chrono::steady_clock::now() - begun >= milliseconds(20));
  CHECK(lock_refusal([&] { late.share(milliseconds(0)); }).find(" for 0 s | ") != std::string::npos);
  start.take_run(7, milliseconds(0));
  CHECK(lock_refusal([&] { late.take_run(7, milliseconds(10)); }) ==
        "2 TB-RUN-LIVE: another process carries out run 7 of this store | " + own.lock +
            " | wait for it to end, or end it: tactbench stop 7");
  CHECK(lock_refusal([&] { late.take_run(6, milliseconds(0)); }) == "not refused");
  CHECK(lock_refusal([&] { late.take_run(8, milliseconds(0)); }) == "not refused");
  CHECK(is_carried_out(own.path, 7) == true);
  CHECK(is_carried_out(own.path, 9) == false);
}

TEST_CASE("lock words: a lock file that is none, and a store that is not there") {
  const StoreToLock own;
  REQUIRE(mkfifo(own.lock.c_str(), 0600) == 0);
  const auto refused = [&](const std::string& why) {
    return "5 TB-STORE-LOCK: the store's lock file cannot be used: " + why + " | " + own.lock +
           " | check folder and permissions; a file that no process holds may be removed";
  };
  CHECK(lock_refusal([&] { const StoreLocks locks(own.path); }) == refused("it is no file"));
  std::filesystem::remove(own.lock);
  std::filesystem::create_directory(own.lock);
  CHECK(lock_refusal([&] { const StoreLocks locks(own.path); }) == refused("Is a directory"));
  std::filesystem::remove(own.lock);
  std::filesystem::create_symlink("elsewhere", own.lock);
  CHECK(lock_refusal([&] { const StoreLocks locks(own.path); }) == refused("Too many levels of symbolic links"));
  CHECK(is_carried_out(own.path, 7) == std::nullopt);
  std::filesystem::remove(own.lock);
  std::filesystem::remove(own.path);
  CHECK(lock_refusal([&] { const StoreLocks locks(own.path); }) == refused("No such file or directory"));
  CHECK_FALSE(std::filesystem::exists(own.lock));
}

TEST_CASE("lock words: the lock file has the store's rights and owner, whatever the umask takes") {
  const StoreToLock own;
  for (const mode_t mode : {0757, 0666, 0600}) {
    REQUIRE(chmod(own.path.c_str(), mode) == 0);
    std::filesystem::remove(own.lock);
    const mode_t before = umask(0177);
    { const StoreLocks locks(own.path); }
    umask(before);
    struct stat made {};
    REQUIRE(stat(own.lock.c_str(), &made) == 0);
    CHECK((made.st_mode & 07777) == (mode & 0666U));
  }
  if (geteuid() != 0) return;
  REQUIRE(chown(own.path.c_str(), 65534, 54321) == 0);
  std::filesystem::remove(own.lock);
  { const StoreLocks locks(own.path); }
  struct stat made {};
  REQUIRE(stat(own.lock.c_str(), &made) == 0);
  CHECK((made.st_uid == 65534 && made.st_gid == 54321));
}

TEST_CASE("lock words: a dead-man's name is waited for as long as is said, a bench's holder is named") {
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

TEST_CASE("lock words: names as they are shown, and those that are too long") {
  const std::string shown = shown_name("rig");
  CHECK(shown.front() == '@');
  CHECK(shown.ends_with("/rig"));
  {
    const Variable scope("TACTBENCH_RUNTIME_DIR", std::nullopt);
    CHECK(shown_name("rig") == "@tactbench/rig");
    const Variable none("TACTBENCH_RUNTIME_DIR", "");
    CHECK(shown_name("rig") == "@tactbench/rig");
    // 107 bytes beside the first, which is 0.
    CHECK(MachineName(std::string(107 - 10, 'x')).held());
    CHECK(lock_refusal([] { const MachineName name(std::string(108 - 10, 'x')); }) ==
          "2 TB-BENCH-NAME: the name is too long for the system | tactbench/" + std::string(98, 'x') +
              " | give the bench a shorter id");
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

TEST_CASE("lock words: which of the held names are runs, and what is known of those that stay silent") {
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
  const Heard heard = say_to({"b", "none", "b/process/12", "b2"}, Command::kStatus, options);
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

TEST_CASE("lock words: a command is told event, run and reason, in a shell of its own") {
  const TemporaryFolder folder;
  const std::string told = folder.path("told");
  const Variable own("TACTBENCH_EVENT", "of an outer run");
  const Notify notify("printf '%s|%s|%s' \"$TACTBENCH_EVENT\" \"$TACTBENCH_RUN\" \"$TACTBENCH_REASON\" >'" +
                      folder.path("new") + "'; mv '" + folder.path("new") + "' '" + told + "' # a comment");
  notify.tell("done", 17, "all steps 'done'; \"really\"");
  CHECK(appears(told, "done|17|all steps 'done'; \"really\""));
  std::filesystem::remove(told);
  Notify("").tell("done", 17, "x");
  notify.tell("waiting", -1, "");
  CHECK(appears(told, "waiting|-1|"));
}
