// Finding runs of the fleet and the names of its servers: which questions are asked, and what the answers come to.
#include "db/fleet/find.h"

#include <catch2/catch.hpp>

#include "tests/db/fleet/scripted_postgres.h"

namespace tactbench::tests::postgres {

using namespace db::fleet;
using Catch::Contains;
using Runs = std::vector<std::int64_t>;

namespace {

std::string begun() { return db::fleet::built_with_libpq() ? done("BEGIN") + ready() : std::string(); }

// What a name comes to when the fleet answers so, and by how many questions.
struct Found {
  std::int64_t run = 0;
  Told error;
  std::size_t questions = 0;
};
Found named(const std::string& name, const std::vector<Answer>& answers) {
  std::vector<Answer> all = {started()};
  all.insert(all.end(), answers.begin(), answers.end());
  Server server(all);
  Found found;
  {
    Link link(server.conninfo());
    found.error = told([&] { found.run = run_named(link, name); });
  }
  for (const std::string& one : server.heard()) found.questions += one.front() == 'P' ? 1 : 0;
  return found;
}

}  // namespace

TEST_CASE("fleet find: a run is named by its number, its UUID, or four or more characters of one") {
  if (!built_with_libpq()) return;
  const Answer none = rows(1, {}), one = rows(1, {{"12"}}), two = rows(1, {{"12"}, {"13"}});
  CHECK(named("12", {one}).run == 12);
  CHECK(named("ab12", {one}).run == 12);
  CHECK(named("AB-f", {one}).run == 12);
  const Found both = named("1234", {none, one});  // no number of the fleet, but the beginning of a UUID
  CHECK((both.run == 12 && both.questions == 2));
  CHECK(named("1234", {one}).questions == 1);
  CHECK(named(std::string(18, '9'), {one}).questions == 1);
  const Found longer = named(std::string(19, '9'), {one});  // too long for a number
  CHECK((longer.run == 12 && longer.questions == 1));
  CHECK(named(std::string(18, '9'), {none, one}).questions == 2);
  for (const auto& [name, questions] : {std::pair("123", 1), std::pair("abc", 0), std::pair("", 0),
                                        std::pair("abcg", 0), std::pair("12 4", 0), std::pair("no-run", 0)}) {
    CAPTURE(name);
    const Found found = named(name, {none, none});
    CHECK(found.questions == static_cast<std::size_t>(questions));
    CHECK(found.error.id == "TB-FLEET-NOT-FOUND");
    CHECK(found.error.cause == FleetCause::kUsage);
    CHECK_THAT(found.error.message, Contains("has no run '" + std::string(name) + "'"));
  }
  const Found several = named("abcd", {two});
  CHECK((several.error.id == "TB-FLEET-NOT-FOUND" && several.questions == 1));
  CHECK_THAT(several.error.message, Contains("has several runs 'abcd'"));
}

TEST_CASE("fleet find: runs come once each in the order of the answer, under a condition that can only read") {
  if (!built_with_libpq()) return;
  Server server({started(), begun(), rows(1, {{"5"}, {"3"}, {"5"}, {"9"}}), begun(), begun(), rows(1, {}), begun()});
  {
    Link link(server.conninfo());
    CHECK(find_runs(link, "simulated", "bench_id = 'a'") == Runs{5, 3, 9});
    CHECK(find_runs(link, "hardware", "").empty());
  }
  const std::vector<std::string> heard = server.heard();
  std::vector<std::string> questions;
  for (const std::string& one : heard)
    if (one.front() == 'P' || one.front() == 'Q') questions.push_back(one);
  REQUIRE(questions.size() == 6);
  CHECK_THAT(questions[0], Contains("QBEGIN READ ONLY"));
  CHECK_THAT(questions[1], Contains("origin = $1 AND (bench_id = 'a'\n) ORDER BY started_utc, run"));
  CHECK_THAT(questions[2], Contains("QROLLBACK"));
  CHECK_THAT(questions[4], Contains("origin = $1 AND (true\n)"));
}

TEST_CASE("fleet find: a condition that cannot be used is the caller's, and an error without one is the fleet's") {
  if (!built_with_libpq()) return;
  const auto said = [](const std::string& where, const Answer& answer) {
    Server server({started(), begun(), answer, begun()});
    Link link(server.conninfo(), kSoon);
    return told([&] { (void)find_runs(link, "simulated", where); });
  };
  for (const char* code : {"42703", "42501"}) {
    const Told wrong = said("no_column = 1", error(code, "not that"));
    // Without its end the server is silent: that it is over is asked for, too.
    CHECK(wrong.id == "TB-FLEET-SILENT");
    const Told refused = said("no_column = 1", error(code, "not that") + ready());
    CHECK(refused.id == "TB-FLEET-WHERE");
    CHECK(refused.cause == FleetCause::kUsage);
    CHECK_THAT(refused.message, Contains("the condition \"no_column = 1\" cannot be used: ") && Contains("not that"));
    CHECK_THAT(refused.remedy, Contains("fleet.every_run"));
    CHECK(said("", error(code, "not that") + ready()).cause == FleetCause::kStore);
  }
  CHECK(said("", error("42501", "not that") + ready()).id == "TB-FLEET-DENIED");
  CHECK(said("true", error("53100", "full") + ready()).id == "TB-FLEET-FULL");
  CHECK(said("true", kHangsUp).id == "TB-FLEET-LOST");
}

TEST_CASE("fleet find: runs bring those that they rest on, each once, and numbers by run or origin") {
  if (!built_with_libpq()) return;
  Server server({started(), rows(1, {{"7"}, {"2"}}), rows(1, {{"9"}, {"7"}}), rows(2, {{"4", "0"}, {"2", "11"}}),
                 rows(2, {{"hardware", "3"}, {"simulated", "12"}})});
  Link link(server.conninfo());
  CHECK(with_what_they_rest_on(link, {2, 4}) == Runs{2, 4, 7, 9});
  CHECK(frame_counts(link, {4, 2}) == std::map<std::int64_t, std::int64_t>{{2, 11}, {4, 0}});
  CHECK(runs_by_origin(link) == std::map<std::string, std::int64_t>{{"hardware", 3}, {"simulated", 12}});
  CHECK(number_array({}) == "{}");
  CHECK(number_array({5}) == "{5}");
  CHECK(number_array({5, -6, 7}) == "{5,-6,7}");
}

}  // namespace tactbench::tests::postgres
