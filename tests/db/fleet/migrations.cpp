// The fleet's schema against a server by script: what each version is told, and which steps bring it up to date.
#include "db/fleet/migrations.h"

#include <catch2/catch.hpp>

#include "tests/db/fleet/scripted_postgres.h"

namespace tactbench::tests::postgres {

using Catch::Contains;
using db::fleet::Link;

namespace {

// To the two questions for a schema's version.
std::vector<Answer> of_version(const std::string& version) {
  if (version.empty()) return {rows(1, {{Field()}})};
  return {rows(1, {{"fleet.migrations"}}), rows(1, {{version}})};
}

Told checked(const std::string& version) {
  std::vector<Answer> answers = of_version(version);
  answers.insert(answers.begin(), started());
  Server server(answers);
  Link link(server.conninfo(), kSoon);
  return told([&] { db::fleet::check_schema(link); });
}

struct Migrated {
  int before = -1;
  Told error;
  std::vector<std::string> statements, versions;  // without parameters; the values that were kept as reached
};
Migrated migrated_from(const std::string& version) {
  const std::string ok = done("DONE") + ready();
  std::vector<Answer> answers = {started(), ok, rows(1, {{""}})};
  for (const Answer& answer : of_version(version)) answers.push_back(answer);
  if (version == "3")
    for (const Answer& answer : of_version(version)) answers.push_back(answer);
  for (int step = version.empty() ? 0 : std::stoi(version); step < 2; ++step) {
    answers.emplace_back(ok);
    answers.emplace_back(rows(0, {}));
  }
  answers.emplace_back(ok);
  Server server(answers);
  Migrated found;
  {
    Link link(server.conninfo(), kSoon);
    found.error = told([&] { found.before = db::fleet::migrate(link, "9.8.7"); });
  }
  for (const std::string& one : server.heard())
    if (one.front() == 'B' && one.find("9.8.7") != std::string::npos) found.versions.push_back(one.substr(11, 1));
  found.statements = server.statements();
  return found;
}

}  // namespace

TEST_CASE("fleet schema: an empty, an older and a newer one each are told what to do, and this program's is right") {
  if (!db::fleet::built_with_libpq()) return;
  CHECK(checked("2").id.empty());
  const Told empty = checked(""), older = checked("1"), newer = checked("3");
  CHECK(empty.id == "TB-FLEET-EMPTY");
  CHECK_THAT(empty.message, Contains("this database holds no fleet yet"));
  CHECK(checked("0").id == "TB-FLEET-EMPTY");
  CHECK(older.id == "TB-FLEET-OLDER");
  CHECK_THAT(older.message, Contains("it has schema 1, this program needs 2"));
  CHECK(checked("-1").id == "TB-FLEET-OLDER");
  CHECK(newer.id == "TB-FLEET-NEWER");
  CHECK_THAT(newer.message, Contains("it has schema 3, this program knows up to 2"));
  for (const Told* error : {&empty, &older, &newer}) {
    CHECK(error->cause == db::fleet::FleetCause::kStore);
    CHECK_FALSE(error->remedy.empty());
  }
}

TEST_CASE("fleet schema: each missing step is made and noted in one transaction, and a newer schema is left alone") {
  if (!db::fleet::built_with_libpq()) return;
  const Migrated fresh = migrated_from(""), older = migrated_from("1"), same = migrated_from("2"),
                 newer = migrated_from("3");
  CHECK((fresh.before == 0 && older.before == 1 && same.before == 2));
  REQUIRE(fresh.statements.size() == 4);
  CHECK((fresh.statements.front() == "BEGIN " && fresh.statements.back() == "COMMIT"));
  CHECK_THAT(fresh.statements[1], Contains("CREATE SCHEMA") && Contains("tactbench_bench"));
  CHECK_THAT(fresh.statements[2], Contains("ALTER TABLE fleet.reports ADD COLUMN reason"));
  CHECK(fresh.versions == std::vector<std::string>{"1", "2"});
  REQUIRE(older.statements.size() == 3);
  CHECK_THAT(older.statements[1], Contains("ALTER TABLE fleet.reports ADD COLUMN reason"));
  CHECK(older.versions == std::vector<std::string>{"2"});
  CHECK(same.statements == std::vector<std::string>{"BEGIN ", "COMMIT"});
  CHECK(newer.error.id == "TB-FLEET-NEWER");
  CHECK(newer.statements == std::vector<std::string>{"BEGIN ", "ROLLBACK"});
}

}  // namespace tactbench::tests::postgres
