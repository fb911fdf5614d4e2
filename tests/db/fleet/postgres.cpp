// The link to the fleet's server, against a server by script: what is sent, what comes back, and what each failure is
// called.
#include "db/fleet/postgres.h"

#include <signal.h>
#include <sys/time.h>

#include <catch2/catch.hpp>
#include <chrono>

#include "tests/db/fleet/scripted_postgres.h"

namespace tactbench::tests::postgres {

using namespace db::fleet;
using Catch::Contains;

namespace {

// What a statement without parameters is told when the server answers so.
Told told_after(const Answer& answer) {
  Server server({started(), answer});
  Link link(server.conninfo(), kSoon);
  return told([&] { link.execute("SELECT 1"); });
}

}  // namespace

TEST_CASE("fleet link: rows come with all their fields, NULL as an empty text, and parameters go in their order") {
  if (!built_with_libpq()) return;
  Server server({started(), rows(3, {{"a", Field(), ""}, {"b", "two words", std::string("x\ny", 3)}}), rows(1, {}),
                 rows(0, {{}, {}})});
  {
    Link link(server.conninfo());
    CHECK(link.user() == "bench_a");
    CHECK(link.where() == server.where());
    CHECK(link.query("SELECT $1, $2", {"first", "second"}) ==
          std::vector<TextRow>{{"a", "", ""}, {"b", "two words", "x\ny"}});
    CHECK(link.query("SELECT 2").empty());
    CHECK(link.query("SELECT 3") == std::vector<TextRow>{{}, {}});
  }
  const std::vector<std::string> heard = server.heard();
  REQUIRE(heard.size() == 1 + 3 * 5 + 1);  // the start, Parse, Bind, Describe, Execute and Sync of each, the end
  CHECK_THAT(heard[1], Contains("SELECT $1, $2"));
  // Bind: no names, no formats, two values by their lengths, results as text.
  CHECK(heard[2] == "B" + std::string("\0\0\0\0\0\2\0\0\0\5first\0\0\0\6second\0\1\0\0", 29));
  CHECK(heard[7] == "B" + std::string("\0\0\0\0\0\0\0\1\0\0", 10));
  CHECK(heard.back() == "X");
}

TEST_CASE("fleet link: the server is told who asks, in UTF-8") {
  if (!built_with_libpq()) return;
  Server server({started()});
  { const Link link(server.conninfo()); }
  const std::string start = server.heard().front();
  const auto pair = [](const std::string& name, const std::string& value) { return name + '\0' + value + '\0'; };
  CHECK_THAT(start, Contains(pair("user", "bench_a")) && Contains(pair("database", "tactile")));
  CHECK_THAT(start, Contains(pair("application_name", "tactbench")) && Contains(pair("client_encoding", "UTF8")));
}

TEST_CASE("fleet link: a text with a zero byte is refused before it is sent") {
  if (!built_with_libpq()) return;
  Server server({started()});
  {
    Link link(server.conninfo());
    const Told said = told([&] { (void)link.query("SELECT $1, $2", {"a", std::string("b\0c", 3)}); });
    CHECK(said.id == "TB-FLEET-TEXT");
    CHECK(said.cause == FleetCause::kStore);
    CHECK_THAT(said.message, Contains(server.where()) && Contains("cannot be kept there: it has a zero byte"));
    CHECK_THAT(said.remedy, Contains("UTF8"));
  }
  CHECK(server.heard().size() == 2);  // its start and its end
}

TEST_CASE("fleet link: each refusal of a server has its name, and the link can be used on") {
  if (!built_with_libpq()) return;
  struct Refusal {
    const char* code;
    const char* id;
    const char* words;
  };
  const std::vector<Refusal> refusals = {{"53100", "TB-FLEET-FULL", "the server's disk is full: no, no"},
                                         {"42501", "TB-FLEET-DENIED", "user bench_a may not do this: no, no"},
                                         {"22021", "TB-FLEET-TEXT", "cannot be kept there: no, no"},
                                         {"22P05", "TB-FLEET-TEXT", "cannot be kept there: no, no"},
                                         {"22P02", "TB-FLEET-SQL", "refused (22P02): no, no"},
                                         {"53200", "TB-FLEET-SQL", "refused (53200): no, no"},
                                         {"42601", "TB-FLEET-SQL", "refused (42601): no, no"},
                                         {"57014", "TB-FLEET-SQL", "refused (57014): no, no"},
                                         {"10800", "TB-FLEET-SQL", "refused (10800): no, no"}};
  std::vector<Answer> answers = {started()};
  for (const Refusal& refusal : refusals) {
    answers.emplace_back(error(refusal.code, "no, no") + ready());
    answers.emplace_back(rows(1, {{"1"}}));
  }
  Server server(answers);
  Link link(server.conninfo());
  for (const Refusal& refusal : refusals) {
    CAPTURE(refusal.code);
    const Told said = told([&] { (void)link.query("SELECT 1"); });
    CHECK(said.id == refusal.id);
    CHECK(said.cause == FleetCause::kStore);
    CHECK_THAT(said.message, Contains("fleet " + server.where() + ": ") && Contains(refusal.words));
    CHECK_FALSE(said.remedy.empty());
    CHECK(link.query("SELECT 1") == std::vector<TextRow>{{"1"}});
  }
}

TEST_CASE("fleet link: a server that goes, or says that it goes, is lost, and one that says nothing is silent") {
  if (!built_with_libpq()) return;
  const std::vector<Answer> lost = {kHangsUp,
                                    {done("SELECT"), Answer::Then::kHangsUp},
                                    error("08006", "gone") + ready(),
                                    error("57P01", "gone") + ready(),
                                    {error("57P02", "gone"), Answer::Then::kHangsUp},
                                    error("", "gone") + ready(),
                                    ready()};
  for (std::size_t i = 0; i < lost.size(); ++i) {
    CAPTURE(i);
    const Told said = told_after(lost[i]);
    CHECK(said.id == "TB-FLEET-LOST");
    CHECK(said.cause == FleetCause::kLink);
    CHECK_THAT(said.message, Contains("the server was lost: "));
    CHECK_THAT(said.remedy, Contains("push again"));
    if (i >= 2 && i + 1 < lost.size()) CHECK_THAT(said.message, Contains("gone"));
  }
  const Told silent = told_after("");
  CHECK(silent.id == "TB-FLEET-SILENT");
  CHECK(silent.cause == FleetCause::kLink);
  CHECK_THAT(silent.message, Contains("the server has been silent for 1 s"));
  CHECK(told_after(done("SELECT")).id == "TB-FLEET-SILENT");  // it is not over
}

TEST_CASE("fleet link: a link that was lost stays lost, whatever is asked of it") {
  if (!built_with_libpq()) return;
  Server server({started(), kHangsUp});
  Link link(server.conninfo(), kSoon);
  const auto nothing = [](std::string&) { return false; };
  for (int round = 0; round < 2; ++round) {
    CHECK(told([&] { (void)link.query("SELECT $1", {"a"}); }).id == "TB-FLEET-LOST");
    CHECK(told([&] { link.execute("SELECT 1"); }).id == "TB-FLEET-LOST");
    CHECK(told([&] { link.copy_in("COPY t FROM STDIN", nothing); }).id == "TB-FLEET-LOST");
    CHECK(told([&] { link.copy_out("COPY t TO STDOUT", [](std::string_view) {}); }).id == "TB-FLEET-LOST");
    CHECK(told([&] { const Transaction transaction(link); }).id == "TB-FLEET-LOST");
  }
}

TEST_CASE("fleet link: signals neither end a wait nor lengthen it") {
  if (!built_with_libpq()) return;
  Server server({started(), ""});
  Link link(server.conninfo(), kSoon);
  struct sigaction noticed {
  }, before{};
  noticed.sa_handler = [](int) {};  // without SA_RESTART: what waits is interrupted
  REQUIRE(::sigaction(SIGALRM, &noticed, &before) == 0);
  const itimerval often{{0, 20'000}, {0, 20'000}}, never{};
  const auto begun = std::chrono::steady_clock::now();
  ::setitimer(ITIMER_REAL, &often, nullptr);
  const Told said = told([&] { link.execute("SELECT 1"); });
  ::setitimer(ITIMER_REAL, &never, nullptr);
  ::sigaction(SIGALRM, &before, nullptr);
  CHECK(said.id == "TB-FLEET-SILENT");
  CHECK(std::chrono::steady_clock::now() - begun > std::chrono::milliseconds(900));
}

TEST_CASE("fleet link: of several statements the one that failed is told, after all were read") {
  if (!built_with_libpq()) return;
  Server server({started(), done("BEGIN") + done("SELECT") + error("42601", "the third") + ready(),
                 done("A") + done("B") + ready(), error("42601", "the first") + error("42P01", "the second") + ready(),
                 done("C") + ready()});
  {
    Link link(server.conninfo());
    CHECK_THAT(told([&] { link.execute("one; two; three"); }).message, Contains("(42601): the third"));
    CHECK(told([&] { link.execute("four; five"); }).id.empty());
    CHECK_THAT(told([&] { link.execute("six; seven"); }).message, Contains("the first"));
    CHECK(told([&] { link.execute("eight"); }).id.empty());
  }
  CHECK(server.statements() == std::vector<std::string>{"one; two; three", "four; five", "six; seven", "eight"});
}

TEST_CASE("fleet link: a transaction is begun in its manner, and rolled back unless it was committed") {
  if (!built_with_libpq()) return;
  Server server({started(), done("BEGIN") + ready(), done("ROLLBACK") + ready(), done("BEGIN") + ready(),
                 done("COMMIT") + ready(), done("BEGIN") + ready(), error("40001", "not serializable") + ready(),
                 done("BEGIN") + ready(), kHangsUp});
  {
    Link link(server.conninfo());
    { const Transaction transaction(link, "READ ONLY"); }
    {
      Transaction transaction(link);
      transaction.commit();
    }
    CHECK(told([&] {
            Transaction transaction(link);
            transaction.commit();
          }).id == "TB-FLEET-SQL");
    { const Transaction transaction(link); }  // the link is lost at its end
  }
  CHECK(server.statements() == std::vector<std::string>{"BEGIN READ ONLY", "ROLLBACK", "BEGIN ", "COMMIT", "BEGIN ",
                                                        "COMMIT", "BEGIN ", "ROLLBACK"});
}

}  // namespace tactbench::tests::postgres
