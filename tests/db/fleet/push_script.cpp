// What a push asks a server and what it makes of the answers, against a server by script: which runs wait, remarks that
// came later, baselines, fits of the fleet's own.
#include <sqlite3.h>

#include <catch2/catch.hpp>

#include "db/fleet/push.h"
#include "db/fleet/remarks.h"
#include "tests/db/fleet/fleet_example.h"
#include "tests/db/fleet/scripted_postgres.h"
#include "tests/db/store_example.h"

namespace tactbench::tests::postgres {

using Catch::Contains;
using db::RunStore;
using db::fleet::LocalRun;
using db::fleet::LocalRuns;
using db::fleet::Push;
using db::fleet::PushedRun;
using db::fleet::Waiting;
using Words = std::vector<std::string>;

namespace {

std::int64_t with_uuid(RunStore& store, const std::string& uuid) {
  db::RunRecord record = example_run();
  record.uuid = uuid;
  return store_example(store, record);
}

std::string ok(const std::string& tag) { return done(tag) + ready(); }

// Of what a server heard: each statement, each list of values, each copied piece and its end.
Words said(Server& server) {
  Words found;
  for (const std::string& one : server.heard()) {
    if (one.front() == 'Q') found.push_back(one.substr(1, one.size() - 2));
    if (one.front() == 'P') found.push_back(one.substr(2, one.find('\0', 2) - 2));
    if (one.front() == 'B') found.back() += " <- " + one.substr(9);
    if (one.front() == 'c') found.emplace_back("end of a copy");
  }
  return found;
}

}  // namespace

TEST_CASE("fleet push: a run waits whole when its content is not there, with its remarks when these differ, else not") {
  if (!db::fleet::built_with_libpq()) return;
  const TemporaryFolder folder;
  RunStore store = RunStore::open(folder.path("runs.db"));
  for (const char* uuid : {"one", "two", "three", "f\"o\\ur"}) with_uuid(store, uuid);
  LocalRuns local(store.path());
  const std::vector<LocalRun> own = local.ended_runs();
  REQUIRE(own.size() == 4);
  const auto row = [](const LocalRun& run, const std::string& content, const std::string& print) {
    return std::vector<Field>{run.uuid, content, print};
  };
  Server server({started(), rows(3, {row(own[0], own[0].content_sha256, own[0].fingerprint),
                                     row(own[1], own[1].content_sha256, "an earlier one"),
                                     row(own[2], "other content", own[2].fingerprint)})});
  {
    db::fleet::Link link(server.conninfo());
    const std::vector<Waiting> waiting = Push(link, local, "host:/runs.db", folder.path()).waiting();
    REQUIRE(waiting.size() == 3);
    CHECK((waiting[0].run.run == 2 && !waiting[0].content));
    CHECK((waiting[1].run.run == 3 && waiting[1].content));
    CHECK((waiting[2].run.run == 4 && waiting[2].content));
  }
  const Words heard = said(server);
  REQUIRE(heard.size() == 1);
  CHECK_THAT(heard[0], Contains("{\"one\",\"two\",\"three\",\"f\\\"o\\\\ur\"}") && Contains("host:/runs.db"));
}

TEST_CASE("fleet push: of a run that is there its new fits and remarks alone are sent, in one transaction") {
  if (!db::fleet::built_with_libpq()) return;
  const TemporaryFolder folder;
  RunStore store = RunStore::open(folder.path("runs.db"));
  const std::int64_t run = with_uuid(store, "one");
  store.set_rest(begin_example(store).run, 1.0);
  db::FitTaxelRecord taxel;
  taxel.status = "fitted";
  (void)store.add_fit({0, run, "elam", "{}", "{}", "0.1.0", kUtc, "{}"}, {taxel});
  (void)store.add_fit({0, run, "gpi", "{}", "{}", "0.1.0", kUtc, "{}"}, {});
  (void)store.add_fit({0, run, "gpi", "{}", "{}", "0.1.0", kUtc, "{}"}, {});
  store.replace_figures(run, "rig", {{"x_psi", 0.5}});
  store.add_note(run, "a note");
  LocalRuns local(store.path());
  const LocalRun own = local.ended_runs().at(0);
  const std::vector<db::fleet::Fit> fits = db::fleet::fits_in(local.connection(), run);
  // Transaction, lock, sensor, run (which is there), its number, fits that are there: the first of the two equal ones.
  Server server({started(), ok("BEGIN"), rows(1, {{""}}), rows(0, {}), rows(1, {}), rows(1, {{"41"}}),
                 rows(2, {{fits[1].sha256, "0"}}), rows(1, {{"7"}}), copy('G'), ok("COPY"), rows(1, {{"8"}}),
                 rows(1, {{"an earlier one"}}), rows(1, {{"9"}}), copy('G'), ok("COPY"), ok("COMMIT")});
  {
    db::fleet::Link link(server.conninfo());
    int read_states = 0;  // of the store, each from BEGIN to ROLLBACK
    sqlite3_rollback_hook(
        local.connection().handle(), [](void* count) { ++*static_cast<int*>(count); }, &read_states);
    const PushedRun pushed = Push(link, local, "host:/runs.db", folder.path()).push({own, false});
    CHECK((pushed.number == 41 && pushed.frames == 0 && pushed.fits == 2 && pushed.remarks));
    CHECK((read_states == 1 && !local.connection().in_transaction()));
    sqlite3_rollback_hook(local.connection().handle(), nullptr, nullptr);
  }
  const Words heard = said(server);
  REQUIRE(heard.size() == 15);
  CHECK_THAT(heard[0], Contains("BEGIN"));
  CHECK_THAT(heard[1], Contains("pg_advisory_xact_lock") && Contains("one"));
  CHECK_THAT(heard[2],
             Contains("INSERT INTO fleet.sensors VALUES ($1, $2, $3, $4, $5, $6, $7)") && Contains("array-3x2"));
  CHECK_THAT(heard[3], Contains("INSERT INTO fleet.runs (\"uuid\", \"origin\", ") &&
                           Contains("\"sensor_type_sha256\", "
                                    "\"sensor_scanner\", \"frames\", \"month\") VALUES ($1, $2, ") &&
                           !Contains("rest_s") && Contains("202405"));
  CHECK_THAT(heard[4], Contains("SELECT run FROM fleet.runs WHERE uuid = $1") && Contains(own.content_sha256));
  CHECK_THAT(heard[5], Contains("SELECT sha256, copy FROM fleet.fits WHERE run = $1") && Contains("41"));
  CHECK_THAT(heard[6], Contains("INSERT INTO fleet.fits") && Contains(fits[0].sha256) && Contains("elam"));
  CHECK_THAT(heard[7], Contains("COPY fleet.fit_taxels"));
  CHECK_THAT(heard[9], Contains("INSERT INTO fleet.fits") && Contains(fits[2].sha256) && Contains("gpi"));
  CHECK_THAT(heard[10], Contains("SELECT fingerprint FROM fleet.revisions"));
  CHECK_THAT(heard[11], Contains("INSERT INTO fleet.revisions") && Contains("a note") && Contains(own.fingerprint));
  CHECK_THAT(heard[12], Contains("COPY fleet.figures"));
  CHECK(heard[14] == "COMMIT");
  const std::vector<std::string> messages = server.heard();
  const std::vector<db::fleet::Row> taxels = sent_for(messages, db::fleet::fit_taxels_table()),
                                    figures = sent_for(messages, db::fleet::figures_table());
  REQUIRE((taxels.size() == 1 && figures.size() == 1));
  CHECK((taxels[0][0].integer == 7 && taxels[0][2].bytes == "fitted"));
  CHECK((figures[0][0].integer == 9 && figures[0][2].bytes == "x_psi" && figures[0][3].real == 0.5));
}

TEST_CASE("fleet push: remarks that another push brought are not sent again, and nothing stays of a push that failed") {
  if (!db::fleet::built_with_libpq()) return;
  const TemporaryFolder folder;
  RunStore store = RunStore::open(folder.path("runs.db"));
  with_uuid(store, "one");
  LocalRuns local(store.path());
  const LocalRun own = local.ended_runs().at(0);
  const std::vector<Answer> until_remarks = {started(),   ok("BEGIN"),       rows(1, {{""}}), rows(0, {}),
                                             rows(1, {}), rows(1, {{"41"}}), rows(2, {})};
  std::vector<Answer> there = until_remarks, refused = until_remarks;
  there.emplace_back(rows(1, {{own.fingerprint}}));
  there.emplace_back(ok("COMMIT"));
  refused.emplace_back(error("42501", "not you") + ready());
  refused.emplace_back(ok("ROLLBACK"));
  {
    Server server(there);
    db::fleet::Link link(server.conninfo());
    const PushedRun pushed = Push(link, local, "host:/runs.db", folder.path()).push({own, false});
    CHECK((pushed.number == 41 && pushed.fits == 0 && !pushed.remarks));
  }
  Server server(refused);
  {
    db::fleet::Link link(server.conninfo());
    Push push(link, local, "host:/runs.db", folder.path());
    CHECK(told([&] { (void)push.push({own, false}); }).id == "TB-FLEET-DENIED");
    CHECK_FALSE(local.connection().in_transaction());
  }
  CHECK(said(server).back() == "ROLLBACK");
  LocalRun gone = own;
  gone.run = 77;
  Server other({started(), ok("BEGIN"), rows(1, {{""}}), ok("ROLLBACK")});
  db::fleet::Link link(other.conninfo());
  Push push(link, local, "host:/runs.db", folder.path());
  std::string message;
  CHECK(store_error([&] { (void)push.push({gone, false}); }, &message) == "TB-STORE-CONFLICT");
  CHECK_THAT(message, Contains("run 77 is gone"));
}

TEST_CASE("fleet push: baselines that are not there are sent with their runs, each in a transaction, and counted") {
  if (!db::fleet::built_with_libpq()) return;
  const TemporaryFolder folder;
  RunStore store = RunStore::open(folder.path("runs.db"));
  LocalRuns local(store.path());
  {
    Server server({started()});
    db::fleet::Link link(server.conninfo());
    CHECK(Push(link, local, "s", folder.path()).push_baselines() == 0);  // asks nothing
  }
  const std::int64_t one = with_uuid(store, "uuid-b"), two = with_uuid(store, "uuid-a");
  store.take_baseline({0, "rig", "as made", "K. Lee", "2026-01-01", {one, two}});
  store.take_baseline({0, "rig", "new film", "K. Lee", "2026-02-02", {one}});
  store.take_baseline({0, "sensor", "of another push", "K. Lee", "2026-03-03", {two}});
  // The hash of a baseline: its four texts, then the UUIDs of its runs in their order.
  std::string bytes;
  for (const std::string text : {"rig", "new film", "K. Lee", "2026-02-02", "uuid-b"})
    bytes += "t" + number(text.size(), 8) + text;
  Server server({started(), rows(1, {{db::sha256_hex(bytes)}}), ok("BEGIN"), rows(1, {{"5"}}), rows(0, {}), rows(0, {}),
                 ok("COMMIT"), ok("BEGIN"), rows(1, {}), ok("ROLLBACK")});
  {
    db::fleet::Link link(server.conninfo());
    CHECK(Push(link, local, "s", folder.path()).push_baselines() == 1);
  }
  const Words heard = said(server);
  REQUIRE(heard.size() == 9);
  CHECK_THAT(heard[2], Contains("INSERT INTO fleet.baselines") && Contains("as made") && Contains("2026-01-01"));
  CHECK_THAT(heard[3], Contains("INSERT INTO fleet.baseline_runs") && Contains("uuid-a"));
  CHECK_THAT(heard[4], Contains("uuid-b"));
  CHECK((heard[5] == "COMMIT" && heard[8] == "ROLLBACK"));
}

TEST_CASE("fleet push: a fit that was made in the fleet is added once") {
  if (!db::fleet::built_with_libpq()) return;
  const TemporaryFolder folder;
  RunStore store = RunStore::open(folder.path("runs.db"));
  const std::int64_t run = with_uuid(store, "one");
  (void)store.add_fit({0, run, "gpi", "{}", "{}", "0.1.0", kUtc, "{}"}, {});
  const std::int64_t fit = store.add_fit({0, run, "elam", "{}", "{}", "0.1.0", kUtc, "{}"}, {});
  LocalRuns local(store.path());
  Server server({started(), ok("BEGIN"), rows(1, {{""}}), rows(1, {}), rows(1, {{"7"}}), ok("COMMIT"), ok("BEGIN"),
                 rows(1, {{""}}), rows(1, {{"1"}}), ok("ROLLBACK")});
  {
    db::fleet::Link link(server.conninfo());
    CHECK(db::fleet::add_fit(link, run, local.connection(), fit, "its parent"));
    CHECK_FALSE(db::fleet::add_fit(link, run, local.connection(), fit, "its parent"));
    CHECK_FALSE(db::fleet::add_fit(link, run, local.connection(), 99, ""));  // there is none: nothing is asked
  }
  const Words heard = said(server);
  REQUIRE(heard.size() == 9);
  CHECK_THAT(heard[3], Contains("INSERT INTO fleet.fits") && Contains("elam") && Contains("its parent"));
  CHECK((heard[4] == "COMMIT" && heard[8] == "ROLLBACK"));
}

}  // namespace tactbench::tests::postgres
