// Who may do what, as the table of docs/safety.md says: other users of the machine against a run, on the machine's own
// names. Other users, and a group of their own for members, take root's rights; without them the tests say that they
// were skipped.
#include <sys/socket.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <thread>

#include "bench/run/control/locks.h"
#include "tests/bench/page/served_page.h"
#include "tests/bench/run/control/apart.h"
#include "tests/support/endless_run.h"
#include "tests/support/variable.h"

using namespace tactbench;
using namespace tactbench::tests;

namespace {

constexpr int kOwner = 5, kOther = kNobodyHere, kGroup = kGroupHere;

// Shell words before a program: another user, the group's member or not, on a machine that has such a group. `own`: a
// folder for what the user keeps.
std::string as_user(int user, bool member, const std::string& own) {
  return fmt::format(
      "unshare -m /bin/sh -c 'mount --bind \"$0/group\" /etc/group && exec setpriv --reuid={0} --regid={0} {1} env -u "
      "TACTBENCH_RUNTIME_DIR HOME=\"$0\" XDG_STATE_HOME=\"$0\" TMPDIR=\"$0\" \"$@\"' '{2}' ",
      user, member ? fmt::format("--groups {}", kGroup) : std::string("--clear-groups"), own);
}

struct Users {
  Users() {
    write_file(folder.path("group"), fmt::format("root:x:0:\ntactbench:x:{}:\n", kGroup));
    (void)run_program("/bin/sh", {"-c", "chmod -R a+rwX ."}, folder.path());
  }
  [[nodiscard]] Finished say(int user, bool member, const std::string& words) const {
    return run_program("/bin/sh", {"-c", as_user(user, member, folder.path()) + "'" + program_path() + "' " + words},
                       folder.path());
  }
  // That all of it is allowed here.
  [[nodiscard]] bool can() const {
    const Finished tried = say(kOther, true, "--version");
    if (tried.code != 0)
      WARN("skipped: this needs root, its capabilities and a program that all can read: " + tried.err);
    return tried.code == 0;
  }
  const TemporaryFolder folder;
};

// Another user's process that holds a name and answers whoever asks that it is run 1 of `store` on `bench` and takes
// all.
struct Stranger : Apart {
  Stranger(const std::string& what, const std::string& bench, const std::string& store = "x.db")
      : Apart([&](const Stay& stay) {
          become_nobody(kNobodyHere);
          const bench::MachineName name(what);
          const std::string lie = fmt::format(
              R"({{"bench":"{}","taken":true,"run":1,"state":"running","store":"{}","text":"run 1"}})", bench, store);
          std::thread([&] {
            for (;;) {
              const int client = accept4(name.descriptor(), nullptr, nullptr, SOCK_CLOEXEC);
              if (client >= 0) (void)send(client, lie.data(), lie.size(), MSG_NOSIGNAL);
              if (client < 0) usleep(1000);
            }
          }).detach();
          stay();
        }) {
    REQUIRE(ready());
  }
};

}  // namespace

TEST_CASE("users: root, the owner and members of the group of the owner may command a run") {
  const Users users;
  if (!users.can()) return;
  struct Row {
    int user;
    bool member, owner_is_member, may;
  };
  const Row row = GENERATE(values<Row>({{0, false, false, true},
                                        {kOwner, false, false, true},
                                        {kOther, false, false, false},
                                        {kOther, true, true, true},
                                        {kOther, true, false, false},
                                        {kOther, false, true, false}}));
  INFO("user " << row.user << ", member " << row.member << ", owner a member " << row.owner_is_member);
  const Variable scope("TACTBENCH_RUNTIME_DIR", std::nullopt);
  const std::string id = fmt::format("users-{}", getpid());
  EndlessRun run(id, as_user(kOwner, row.owner_is_member, users.folder.path()));
  REQUIRE(run.lives());  // root hears anybody
  const Finished word = users.say(row.user, row.member, "stop --bench " + id);
  INFO(word.err);
  CHECK(word.code == (row.may ? 0 : 2));
  if (!row.may) {
    CHECK_THAT(word.err, Catch::Contains("TB-RUN-DENIED"));
    CHECK_FALSE(run.process().ended_within(std::chrono::milliseconds(300)));
    CHECK(users.say(kOwner, row.owner_is_member, "stop --bench " + id).code == 0);
  }
  CHECK(run.process().wait() == 4);
}

TEST_CASE("users: an answer of another user is not trusted, and the run it names is not shown") {
  const Users users;
  if (!users.can()) return;
  const Variable scope("TACTBENCH_RUNTIME_DIR", std::nullopt);
  const std::string id = fmt::format("stranger-{}", getpid());
  const Stranger stranger(id, "x");
  const Finished panic = users.say(kOwner, false, "panic --bench " + id);
  CHECK(panic.code == 2);
  CHECK_THAT(panic.err, Catch::Contains("TB-RUN-DENIED") && Catch::Contains("nobody (pid "));
  // Nor does it stand in the way of a word to a run that is real.
  EndlessRun run(fmt::format("real-{}", getpid()), as_user(kOwner, false, users.folder.path()));
  REQUIRE(run.lives());
  const Finished real = users.say(kOwner, false, fmt::format("panic --db '{}'", run.folder.path("runs.db")));
  INFO(real.err);
  CHECK(real.code == 0);
  CHECK(run.process().wait() == 4);
}

TEST_CASE("users: a false answer in the name of a run does not block the panic of root") {
  const Users users;
  if (!users.can()) return;
  const Variable scope("TACTBENCH_RUNTIME_DIR", std::nullopt);
  const std::string id = fmt::format("doubled-{}", getpid());
  EndlessRun run(id, as_user(kOwner, false, users.folder.path()));
  REQUIRE(run.lives());
  const Stranger stranger(id + "/process/1", id);
  const Finished panic = users.say(0, false, "panic --bench " + id);
  INFO(panic.err);
  CHECK(panic.code == 0);
  CHECK(run.process().wait() == 4);
}

TEST_CASE("users: root does not trust another user who claims to be a run of the store, by command or on the page") {
  const Users users;
  if (!users.can()) return;
  const Variable scope("TACTBENCH_RUNTIME_DIR", std::nullopt);
  const std::string id = fmt::format("{}", getpid());
  EndlessRun run("run-" + id, as_user(kOwner, false, users.folder.path()));
  const std::string store = run.folder.path("runs.db");
  // Before the run's name in the alphabet, as many as an impatient look might give up at.
  std::vector<std::unique_ptr<Stranger>> strangers;
  for (const char* name : {"a", "b", "c", "d"})
    strangers.push_back(std::make_unique<Stranger>(name + id, name + id, store));
  const std::string named = fmt::format("nobody (pid {})", strangers[0]->process());
  for (const char* word : {"panic", "stop", "stop --abort"}) {
    const Finished said = users.say(0, false, fmt::format("{} --bench a{}", word, id));
    INFO(said.err);
    CHECK(said.code == 2);
    CHECK_THAT(said.err, Catch::Contains("TB-RUN-DENIED") && Catch::Contains(named));
  }
  const Finished status = users.say(0, false, fmt::format("status --json --bench a{}", id));
  CHECK(nlohmann::json::parse(status.out)["live"] == false);
  REQUIRE(run.lives());
  const WordsPage page([&](bench::PageOptions& options) { options.db = store; });
  RawClient viewer(page.server->port());
  REQUIRE(viewer.send(page.head("GET /events", page.server->access().read_token)));
  CHECK_THAT(viewer.read(20'000, "\"live\":true"), Catch::Contains("\"bench\":\"run-" + id));
  const nlohmann::json panic = page.command({{"word", "panic"}, {"run", 1}});
  CHECK(panic["taken"] == true);
  CHECK_THAT(panic["by"].get<std::string>(), Catch::Contains("pid") && !Catch::Contains("nobody"));
  CHECK(run.process().wait() == 4);
}
