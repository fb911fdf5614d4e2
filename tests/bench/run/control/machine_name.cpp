// Names that one process at a time holds, and who is at the other end of them.
#include "bench/run/control/machine_name.h"

#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cerrno>
#include <chrono>
#include <filesystem>

#include "bench/common/error.h"
#include "bench/run/control/control_client.h"
#include "bench/run/control/locks.h"
#include "bench/run/control/peer.h"
#include "bench/run/control/run_connection.h"
#include "tests/bench/run/control/apart.h"
#include "tests/support/process.h"
#include "tests/support/refusal.h"
#include "tests/support/variable.h"

using namespace tactbench;
using namespace tactbench::bench;
using namespace tactbench::tests;
using std::chrono::milliseconds;

namespace {

template <class Work>
std::string refusal_of(const Work& work) {
  const auto error = refusal_by(work);
  if (!error) return "not refused";
  return error->id() + ": " + error->what();
}

}  // namespace

TEST_CASE("machine names: one holder, listed while it lives, free when it is gone") {
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

TEST_CASE("machine names: do not depend on folders or the home of a login") {
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

TEST_CASE("machine names: TACTBENCH_RUNTIME_DIR is a separate scope, a folder of this user closed to others") {
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

TEST_CASE("machine names: the holder of a bench's name is named, and not trusted") {
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

TEST_CASE("machine names: root, the own user and the group are trusted, by what the process is and not by its name") {
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

TEST_CASE("machine names: a dead-man's name is waited for as long as is said, a bench's holder is named") {
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

TEST_CASE("machine names: names as they are shown, and those that are too long") {
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

TEST_CASE("machine names: which of the held names are runs, and what is known of those that stay silent") {
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
