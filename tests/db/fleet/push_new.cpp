// A push of a run that the fleet does not have, against a server by script: every row that is sent, and the comparison
// with what came there.
#include <algorithm>
#include <catch2/catch.hpp>
#include <filesystem>

#include "db/fleet/push.h"
#include "tests/db/fleet/fleet_example.h"

namespace tactbench::tests::postgres {

using Catch::Contains;
using db::fleet::LocalRun;
using db::fleet::Push;

namespace {

std::string finished(const std::string& tag) { return done(tag) + ready(); }

// Until all of a new run was sent, whose seven tables have rows.
std::vector<Answer> until_sent(bool month_is_new) {
  std::vector<Answer> answers;
  if (month_is_new) answers.emplace_back(rows(1, {{""}}));
  for (const std::string& answer : {finished("BEGIN"), rows(1, {{""}}), rows(0, {}), rows(1, {{std::to_string(kRun)}})})
    answers.emplace_back(answer);
  for (int table = 0; table < 7; ++table) {
    answers.emplace_back(copy('G'));
    answers.emplace_back(finished("COPY"));
  }
  return answers;
}

void add(std::vector<Answer>& answers, const std::vector<Answer>& more) {
  answers.insert(answers.end(), more.begin(), more.end());
}

}  // namespace

TEST_CASE("fleet push: a new run is sent table by table, read back, compared and kept") {
  if (!db::fleet::built_with_libpq()) return;
  const Fleet fleet;
  LocalRuns local(fleet.store.path());
  const LocalRun own = local.ended_runs().at(0);
  std::vector<Answer> answers = {started()};
  add(answers, until_sent(true));
  add(answers, fleet.content(true));
  add(answers, {rows(2, {{fleet.fit.sha256, "0"}}), rows(1, {{own.fingerprint}}), finished("COMMIT")});
  Server server(answers);
  const TemporaryFolder scratch;
  {
    db::fleet::Link link(server.conninfo(), kSoon);
    const db::fleet::PushedRun pushed = Push(link, local, "host:/runs.db", scratch.path()).push({own, true});
    CHECK((pushed.number == kRun && pushed.frames == 3 && pushed.fits == 0 && !pushed.remarks));
    CHECK_FALSE(local.connection().in_transaction());
  }
  const std::vector<std::string> heard = server.heard();
  for (const Table& table : db::fleet::content_tables()) {
    CAPTURE(table.name);
    const std::vector<Row> sent = sent_for(heard, table), stored = rows_of(local, table);
    REQUIRE(sent.size() == stored.size());
    for (std::size_t i = 0; i < sent.size(); ++i) {
      CHECK(sent[i][0].integer == kRun);
      std::string one, other;
      db::fleet::add_to_digest(one, table.columns, sent[i]);
      db::fleet::add_to_digest(other, table.columns, stored[i]);
      CHECK(one == other);
    }
  }
  const std::vector<Row> frames = sent_for(heard, db::fleet::frames_table());
  REQUIRE(frames.size() == 3);
  for (std::size_t i = 0; i < 3; ++i) {
    const auto position = static_cast<std::int64_t>(i) + 1;
    CHECK((frames[i][0].integer == kRun && frames[i][1].integer == 202405 && frames[i][2].integer == position));
    CHECK(frames[i][3].integer == (i == 0 ? 1 : 2));  // branches by their places in the run
    CHECK(frames[i][4].integer == (i == 2 ? 1 : 0));
  }
  CHECK(heard.back() == "X");
  CHECK(heard[heard.size() - 2] == "QCOMMIT" + std::string(1, '\0'));
  CHECK_THAT(heard[1], Contains("make_month"));
}

TEST_CASE("fleet push: the month is made once, and a copy that is read back serves for several runs") {
  if (!db::fleet::built_with_libpq()) return;
  const Fleet fleet;
  LocalRuns local(fleet.store.path());
  const LocalRun own = local.ended_runs().at(0);
  std::vector<Answer> answers = {started()};
  add(answers, until_sent(true));
  add(answers, fleet.content(true));
  add(answers, {rows(2, {{fleet.fit.sha256, "0"}}), rows(1, {{own.fingerprint}}), finished("COMMIT")});
  add(answers, until_sent(false));
  add(answers, {error("53100", "no room") + ready(), finished("ROLLBACK")});
  add(answers, until_sent(false));
  add(answers, fleet.content(true));
  add(answers, {rows(2, {{fleet.fit.sha256, "0"}}), rows(1, {{own.fingerprint}}), finished("COMMIT")});
  Server server(answers);
  const TemporaryFolder scratch;
  {
    db::fleet::Link link(server.conninfo(), kSoon);
    Push push(link, local, "host:/runs.db", scratch.path());
    CHECK(push.push({own, true}).frames == 3);
    CHECK(told([&] { (void)push.push({own, true}); }).id == "TB-FLEET-FULL");
    CHECK(push.push({own, true}).frames == 3);  // into a new copy: half of a run may be in the other
  }
  std::size_t months = 0;
  for (const std::string& one : server.heard()) months += one.find("make_month") != std::string::npos ? 1 : 0;
  CHECK(months == 1);
  CHECK(std::filesystem::exists(scratch.path("read-back-1.db")));
  CHECK(std::filesystem::exists(scratch.path("read-back-2.db")));
}

TEST_CASE(
    "fleet push: a copy that is read back begins anew when it is larger than may be, and not when it is as large") {
  if (!db::fleet::built_with_libpq()) return;
  const Fleet fleet;
  LocalRuns local(fleet.store.path());
  const LocalRun own = local.ended_runs().at(0);
  CHECK(db::fleet::kLargestScratch == 67'108'864);
  std::uintmax_t size = 1;
  for (const int less : {-1, 0, 1}) {  // what may be, below what one run takes; before that is known
    std::vector<Answer> answers = {started()};
    for (const bool first : {true, false}) {
      add(answers, until_sent(first));
      add(answers, fleet.content(true));
      add(answers, {rows(2, {{fleet.fit.sha256, "0"}}), rows(1, {{own.fingerprint}}), finished("COMMIT")});
    }
    Server server(answers);
    const TemporaryFolder scratch;
    const std::string one = scratch.path("read-back-1.db"), two = scratch.path("read-back-2.db");
    db::fleet::Link link(server.conninfo(), kSoon);
    Push push(link, local, "host:/runs.db", scratch.path(),
              less < 0 ? db::fleet::kLargestScratch : size - static_cast<std::uintmax_t>(less));
    CHECK(push.push({own, true}).frames == 3);
    CHECK((std::filesystem::exists(one) && !std::filesystem::exists(two)));
    if (less < 0) {
      size = std::filesystem::file_size(one);
    } else if (less == 0) {
      CHECK_FALSE(store_error([&] { (void)push.push({own, true}); }).empty());  // the copy has a run of this number
      CHECK((std::filesystem::exists(one) && !std::filesystem::exists(two)));
    } else {
      CHECK(push.push({own, true}).frames == 3);
      CHECK((!std::filesystem::exists(one) && std::filesystem::exists(two)));
    }
  }
}

TEST_CASE("fleet push: what comes to the server otherwise is not kept, and a store that changed is told as such") {
  if (!db::fleet::built_with_libpq()) return;
  Fleet fleet;
  const auto pushed = [&](const std::vector<Answer>& content) {
    LocalRuns local(fleet.store.path());
    std::vector<Answer> answers = {started()};
    add(answers, until_sent(true));
    add(answers, content);
    answers.emplace_back(finished("ROLLBACK"));
    Server server(answers);
    Told error;
    {
      db::fleet::Link link(server.conninfo(), kSoon);
      const TemporaryFolder scratch;
      Push push(link, local, "host:/runs.db", scratch.path());
      error = told([&] { (void)push.push({local.ended_runs().at(0), true}); });
    }
    CHECK(server.statements().back() == "ROLLBACK");
    return error;
  };
  std::vector<Answer> less = fleet.content(true);
  less[5] = handed_out(db::fleet::content_tables()[3].columns, {});  // no event came there
  const Told differs = pushed(less);
  CHECK((differs.id == "TB-FLEET-DIFFERS" && differs.cause == db::fleet::FleetCause::kStore));
  CHECK_THAT(differs.message, Contains("run 1: what came to the server has content ") &&
                                  Contains("the run has " + fleet.store.run(1).content_sha256) &&
                                  !Contains("the store itself has changed"));
  CHECK_THAT(differs.remedy, Contains("push again"));
  db::sqlite::Connection(fleet.store.path(), db::sqlite::Access::kReadWrite)
      .execute("UPDATE frames SET status = 9 WHERE frame = 1000000002");
  const Told changed = pushed(fleet.content(true));
  CHECK(changed.id == "TB-FLEET-DIFFERS");
  CHECK_THAT(changed.message, Contains("; the store itself has changed: frame 2 "));
  CHECK_THAT(changed.remedy, Contains("tactbench verify RUN"));
}

TEST_CASE("fleet push: many frames go in pieces of a quarter of a megabyte, each row whole") {
  if (!db::fleet::built_with_libpq()) return;
  const TemporaryFolder folder;
  RunStore store = RunStore::open(folder.path("runs.db"), db::Durability::kNormal);
  const Begun begun = begin_example(store);
  db::FrameRecord frame = example_frame(begun.branch, 0);
  frame.trace.resize(2000);  // 32 kB
  for (int i = 0; i < 25; ++i) {
    frame.ordinal = i;
    store.append_frame(begun.run, frame);
  }
  store.append_event(begun.run, {1, "note", "", ""});
  store.append_check(begun.run, {begun.run, 4, "seating", "pass", "{}", {}});
  store.append_series(begun.run, {{0, 3, {0.5}, {2.5}}});
  store.end_run(begun.run, db::Outcome::kCompleted, "", db::SafeState::kVerified, kUtc);
  LocalRuns local(store.path());
  std::vector<Answer> answers = {started()};
  add(answers, until_sent(true));
  add(answers, {error("53100", "no room") + ready(), finished("ROLLBACK")});
  Server server(answers);
  {
    db::fleet::Link link(server.conninfo(), kSoon);
    Push push(link, local, "host:/runs.db", folder.path());
    CHECK(told([&] { (void)push.push({local.ended_runs().at(0), true}); }).id == "TB-FLEET-FULL");
  }
  const std::vector<std::string> heard = server.heard();
  const std::vector<Row> frames = sent_for(heard, db::fleet::frames_table());
  REQUIRE(frames.size() == 25);
  for (std::size_t i = 0; i < 25; ++i) CHECK(frames[i][2].integer == static_cast<std::int64_t>(i) + 1);
  std::size_t pieces = 0;
  for (const std::string& one : heard) {
    if (one.front() != 'd' || one.size() < 100'000) continue;
    ++pieces;
    CHECK(one.size() < 256 * 1024 + 33'000);
  }
  CHECK(pieces == 3);
}

}  // namespace tactbench::tests::postgres
