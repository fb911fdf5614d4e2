// What fleet push sends, tells and keeps in the note beside the store, with a server by script.
#include <unistd.h>

#include <array>
#include <catch2/catch.hpp>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "bench/cli/fleet/fleet.h"
#include "db/fleet/local_runs.h"
#include "db/fleet/postgres.h"
#include "tests/bench/cli/fleet/fleet_verb.h"
#include "tests/db/fleet/fleet_example.h"

namespace tactbench::tests::postgres {

namespace {

using PushScript = std::vector<Answer>;

void append(PushScript& answers, const PushScript& more) { answers.insert(answers.end(), more.begin(), more.end()); }

PushScript when_asked_what_is_there(const std::vector<std::vector<Field>>& there) {
  PushScript answers = of_this_schema();
  answers.emplace_back(rows(3, there));
  return answers;
}

// Of a run of seven tables that is new to the server, until it is read back.
PushScript until_sent() {
  PushScript answers = {rows(1, {{""}}), ended("BEGIN"), rows(1, {{""}}), rows(0, {}), rows(1, {{"41"}})};
  for (int table = 0; table < 7; ++table) append(answers, {copy('G'), ended("COMMIT")});
  return answers;
}

// The verb's answer with the server's name and the store's taken out.
struct PushedTo {
  PushedTo(const Fleet& fleet, const PushScript& answers, std::vector<std::string> words = {}) {
    words.insert(words.begin(), {"push", "--db", fleet.store.path()});
    finished = fleet_verb(answers, words, &where);
    for (const auto& [name, mark] : {std::pair{where, "WHERE"}, {fleet.store.path(), "STORE"}})
      for (std::string* text : {&finished.out, &finished.err})
        for (std::size_t at = text->find(name); at != std::string::npos; at = text->find(name))
          text->replace(at, name.size(), mark);
  }
  db::fleet::PushedNote note(const Fleet& fleet) const { return {fleet.store.path(), where}; }
  Finished finished;
  std::string where;
};

db::fleet::LocalRun run_of(const Fleet& fleet) { return db::fleet::LocalRuns(fleet.store.path()).ended_runs().at(0); }

}  // namespace

TEST_CASE("fleet push: a new run with its fits, told run by run, summed up, and kept in the note") {
  if (!db::fleet::built_with_libpq()) return;
  const Fleet fleet;
  const db::fleet::LocalRun own = run_of(fleet);
  PushScript known = when_asked_what_is_there({});
  append(known, until_sent());
  append(known, fleet.content(true));
  PushScript anew = known;
  append(known, {rows(2, {{fleet.fit.sha256, "0"}}), rows(1, {{own.fingerprint}}), ended("COMMIT")});
  append(anew,
         {rows(2, {}), rows(1, {{"7"}}), copy('G'), ended("COPY"), rows(1, {{own.fingerprint}}), ended("COMMIT")});
  {
    const PushedTo pushed(fleet, known);
    CHECK(pushed.finished.err.empty());
    CHECK(pushed.finished.code == 0);
    CHECK(pushed.finished.out ==
          "run 1 is the fleet's run 41: 3 frames\nWHERE: 1 run, 3 frames sent now; 1 run has ended in STORE, and all "
          "are there\n");
    CHECK(pushed.note(fleet).fingerprints() == std::map<std::string, std::string>{{own.uuid, own.fingerprint}});
    CHECK_FALSE(pushed.note(fleet).last().pushed_utc.empty());
    CHECK_FALSE(pushed.note(fleet).last().tried_utc.empty());
    CHECK(pushed.note(fleet).last().error.empty());
  }
  CHECK(PushedTo(fleet, anew).finished.out ==
        "run 1 is the fleet's run 41: 3 frames, 1 fit\nWHERE: 1 run, 3 frames sent now; 1 run has ended in STORE, and "
        "all are there\n");
  CHECK(PushedTo(fleet, anew, {"-q"}).finished.out.empty());
  const PushedTo as_json(fleet, anew, {"--json"});
  const nlohmann::json told = nlohmann::json::parse(as_json.finished.out);
  CHECK(told.at("schema") == "tactbench.fleet.push");
  CHECK((told.at("fleet") == "WHERE" && told.at("store") == "STORE"));
  CHECK((told.at("ended_runs") == 1 && told.at("frames") == 3 && told.at("baselines") == 0 &&
         told.at("not_pushed") == 0));
  CHECK(told.at("pushed") ==
        nlohmann::json::parse(R"([{"run": 1, "uuid": ")" + own.uuid +
                              R"(", "fleet_run": 41, "frames": 3, "fits": 1, "remarks": false}])"));
}

TEST_CASE("fleet push: a store is named by its host and its whole path") {
  const TemporaryFolder folder;
  std::array<char, 256> host{};
  REQUIRE(gethostname(host.data(), host.size()) == 0);
  write_file(folder.path("runs.db"), "");
  const std::string whole = std::filesystem::canonical(folder.path()).string();
  CHECK(bench::source_name(folder.path("x/../runs.db")) == std::string(host.data()) + ":" + whole + "/runs.db");
}

TEST_CASE("fleet push: of a run that is there what was said later, baselines, and a note that was lost") {
  if (!db::fleet::built_with_libpq()) return;
  Fleet fleet;
  const db::fleet::LocalRun own = run_of(fleet);
  PushScript later = when_asked_what_is_there({{own.uuid, own.content_sha256, "of before"}});
  append(later, {ended("BEGIN"), rows(1, {{""}}), rows(0, {}), rows(1, {}), rows(1, {{"41"}}), rows(2, {}),
                 rows(1, {{"7"}}), copy('G'), ended("COPY"), rows(1, {{own.fingerprint}}), ended("COMMIT")});
  CHECK(PushedTo(fleet, later).finished.out ==
        "run 1 is the fleet's run 41: what was said of it later, 1 fit\nWHERE: 1 run, 0 frames sent now; 1 run has "
        "ended in STORE, and all are there\n");
  const PushScript nothing = when_asked_what_is_there({{own.uuid, own.content_sha256, own.fingerprint}});
  {
    const PushedTo idle(fleet, nothing);
    CHECK(idle.finished.out == "WHERE: 0 runs, 0 frames sent now; 1 run has ended in STORE, and all are there\n");
    // The server has it, and the note does not.
    CHECK(idle.note(fleet).fingerprints() == std::map<std::string, std::string>{{own.uuid, own.fingerprint}});
  }
  {  // The note has it, too, and stays as it is.
    const Server server(nothing);
    db::fleet::PushedNote(fleet.store.path(), server.where()).keep(own, "2020-01-01T00:00:00Z");
    CHECK(verb_here(bench::add_fleet, {"fleet", "push", "--db", fleet.store.path(), "--to", server.conninfo()}).code ==
          0);
    CHECK(db::fleet::PushedNote(fleet.store.path(), server.where()).last().pushed_utc == "2020-01-01T00:00:00Z");
  }
  (void)begin_example(fleet.store);  // has not ended: is not told of
  fleet.store.take_baseline({0, "rig", "as made", "K. Lee", "2026-01-01", {1}});
  PushScript baseline = nothing;
  append(baseline, {rows(1, {}), ended("BEGIN"), rows(1, {{"5"}}), rows(0, {}), ended("COMMIT")});
  CHECK(PushedTo(fleet, baseline).finished.out ==
        "WHERE: 0 runs, 0 frames sent now, 1 baseline; 1 run has ended in STORE, and all are there\n");
  CHECK(nlohmann::json::parse(PushedTo(fleet, baseline, {"--json"}).finished.out).at("baselines") == 1);
}

TEST_CASE("fleet push: a run that comes otherwise is left for the end, and what is in the way is noted") {
  if (!db::fleet::built_with_libpq()) return;
  Fleet fleet;
  PushScript differs = when_asked_what_is_there({});
  append(differs, until_sent());
  std::vector<Answer> less = fleet.content(true);
  less[5] = handed_out(db::fleet::content_tables()[3].columns, {});  // no event came there
  append(differs, less);
  append(differs, {ended("ROLLBACK")});
  {
    const PushedTo pushed(fleet, differs);
    CHECK(pushed.finished.code == 5);
    CHECK(pushed.finished.out == "WHERE: 0 runs, 0 frames sent now; 1 run has ended in STORE, 1 could not be sent\n");
    CHECK_THAT(pushed.finished.err, Catch::Contains("[TB-FLEET-DIFFERS]"));
    CHECK(pushed.note(fleet).fingerprints().empty());
    CHECK_THAT(pushed.note(fleet).last().error, Catch::Contains("what came to the server has content "));
  }
  const PushedTo as_json(fleet, differs, {"--json"});
  CHECK(as_json.finished.code == 5);
  CHECK(nlohmann::json::parse(as_json.finished.out).at("not_pushed") == 1);
  PushScript full = when_asked_what_is_there({});
  append(full, {rows(1, {{""}}), ended("BEGIN"), error("53100", "no room") + ready(), ended("ROLLBACK")});
  const PushedTo refused(fleet, full);
  CHECK(refused.finished.code == 5);
  CHECK(refused.finished.out.empty());
  CHECK_THAT(refused.finished.err, Catch::Contains("[TB-FLEET-FULL]"));
  CHECK_FALSE(refused.note(fleet).last().error.empty());
  const TemporaryFolder nobody;
  const std::string to = "host=" + nobody.path() + " dbname=tactile";
  const Finished away = verb_here(bench::add_fleet, {"fleet", "push", "--db", fleet.store.path(), "--to", to});
  CHECK(away.code == 3);
  CHECK(away.out.empty());
  db::fleet::PushedNote note(fleet.store.path(), "tactile on " + nobody.path() + ":5432");
  CHECK_FALSE(note.last().error.empty());
  CHECK_FALSE(note.last().tried_utc.empty());
  CHECK(note.last().pushed_utc.empty());
  const PushedTo old(fleet, {started(), rows(1, {{"fleet.migrations"}}), rows(1, {{"1"}})});
  CHECK(old.finished.code != 0);  // an older schema
  for (const std::vector<std::string>& wrong : std::vector<std::vector<std::string>>{
           {"--every", "0"}, {"--every", "3601"}, {"--patience", "0"}, {"--patience", "3601"}}) {
    std::vector<std::string> words = {"fleet", "push", "--db", fleet.store.path(), "--to", to};
    words.insert(words.end(), wrong.begin(), wrong.end());
    CHECK_THAT(verb_here(bench::add_fleet, words).err, Catch::StartsWith("parse: "));
  }
}

}  // namespace tactbench::tests::postgres
