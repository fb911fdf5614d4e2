// The fleet's verbs as a program: fleet push --follow until it is ended, beside a server that goes, and without libpq.
#include <signal.h>

#include <catch2/catch.hpp>
#include <map>
#include <string>
#include <vector>

#include "db/fleet/local_runs.h"
#include "db/fleet/postgres.h"
#include "tests/db/fleet/fleet_example.h"
#include "tests/support/child_process.h"
#include "tests/support/paths.h"
#include "tests/support/process.h"

namespace tactbench::tests::postgres {

TEST_CASE("fleet push --follow: what waits is sent, a server that went is noted, and SIGINT ends it with code 0") {
  if (!db::fleet::built_with_libpq()) return;
  const Fleet fleet;
  const db::fleet::LocalRun own = db::fleet::LocalRuns(fleet.store.path()).ended_runs().at(0);
  const std::string begun = done("BEGIN") + ready(), copied = done("COPY") + ready();
  std::vector<Answer> answers = {started(),        rows(1, {{"fleet.migrations"}}),
                                 rows(1, {{"2"}}), rows(3, {}),
                                 rows(1, {{""}}),  begun,
                                 rows(1, {{""}}),  rows(0, {}),
                                 rows(1, {{"41"}})};
  for (int table = 0; table < 7; ++table)
    for (const std::string& answer : {copy('G'), copied}) answers.emplace_back(answer);
  for (const Answer& answer : fleet.content(true)) answers.push_back(answer);
  for (const std::string& answer :
       {rows(2, {{fleet.fit.sha256, "0"}}), rows(1, {{own.fingerprint}}), copied, rows(1, {{"1"}})})
    answers.emplace_back(answer);
  answers.push_back(kHangsUp);
  const Server server(answers);
  const std::string log = fleet.folder.path("said");
  ChildProcess push({"/bin/sh", "-c", "exec \"$0\" fleet push --follow --every 0.1 --db \"$1\" --to \"$2\" 2>\"$3\"",
                     program_path(), fleet.store.path(), server.conninfo(), log});
  CHECK(push.line() == "run 1 is the fleet's run 41: 3 frames");
  const auto until = std::chrono::steady_clock::now() + std::chrono::seconds(60);
  const std::string said = "it is tried again until it works\n";
  while (read_file(log).find(said) == std::string::npos && std::chrono::steady_clock::now() < until) usleep(10'000);
  CHECK_THAT(read_file(log), Catch::StartsWith("warning: ") && Catch::Contains("\n  try: ") && Catch::Contains(said));
  CHECK_FALSE(push.ended_within(std::chrono::milliseconds(0)));
  push.signal(SIGINT);
  CHECK(push.wait() == 0);
  db::fleet::PushedNote note(fleet.store.path(), server.where());
  CHECK(note.fingerprints() == std::map<std::string, std::string>{{own.uuid, own.fingerprint}});
  CHECK_FALSE(note.last().error.empty());
}

TEST_CASE("fleet push --follow: what no waiting makes good ends it at once") {
  if (!db::fleet::built_with_libpq()) return;
  const Fleet fleet;
  const Finished nonsense =
      run_program(program_path(), {"fleet", "push", "--follow", "--db", fleet.store.path(), "--to", "nonsense"},
                  fleet.folder.path());
  CHECK(nonsense.code == 2);
  CHECK_THAT(nonsense.err, Catch::Contains("[TB-FLEET-CONNINFO]"));
  const Finished no_store = run_program(
      program_path(), {"fleet", "push", "--follow", "--db", fleet.folder.path("none.db"), "--to", "host=/nowhere"},
      fleet.folder.path());
  CHECK(no_store.code == 5);
  CHECK_THAT(no_store.err, Catch::Contains("[TB-STORE-OPEN]"));
}

TEST_CASE("fleet verbs: a libpq that cannot be loaded is named, with what else works") {
  if (!db::fleet::built_with_libpq()) return;
  const TemporaryFolder folder;
  write_file(folder.path("libpq.so.5"), "no library");
  db::RunStore::open(folder.path("runs.db"), db::Durability::kNormal);
  for (const char* verb : {"push", "status", "migrate"}) {
    std::vector<std::string> words = {
        "LD_LIBRARY_PATH=" + folder.path(), program_path(), "fleet", verb, "--to", "host=/nowhere"};
    if (std::string(verb) != "migrate") words.insert(words.end(), {"--db", folder.path("runs.db")});
    const Finished refused = run_program("/usr/bin/env", words, folder.path());
    CHECK(refused.code == 2);
    CHECK_THAT(refused.err, Catch::StartsWith("error: libpq cannot be loaded: ") &&
                                Catch::Contains(" [TB-FLEET-BUILD]\n  try: install libpq5; all but the fleet works "
                                                "without it\n"));
  }
}

}  // namespace tactbench::tests::postgres
