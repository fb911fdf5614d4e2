// The link to the fleet's server, against a server by script: which id each failure has, and that nothing a server may
// answer is believed, lasts for ever, or ends the process.

#include "db/fleet/postgres.h"

#include <catch2/catch.hpp>
#include <chrono>

#include "db/fleet/runs.h"
#include "db/sqlite.h"
#include "tests/db/fleet/scripted_postgres.h"
#include "tests/db/store_example.h"
#include "tests/support/process.h"

using namespace tactbench;
using namespace tactbench::tests;
using db::RunStore;

namespace tactbench::tests::postgres {

using namespace db::fleet;

namespace {

std::string id_after(const Answer& answer, std::size_t columns = 1) {
  Server server({started(), answer});
  Link link(server.conninfo() + " passfile=/none", kSoon);
  return told([&] { (void)link.query_row("SELECT $1::text", columns, {"a"}, 1000); }).id;
}

std::string refused(const Answer& answer) {
  Server server({answer});
  return told([&] { const Link link(server.conninfo() + " passfile=/none", kSoon, kSoon); }).id;
}

}  // namespace

TEST_CASE("fleet link: values are passed as their bytes, and NULL is an empty text") {
  const std::string zero("x\0y", 3);
  Server server({started(), rows(3, {{"a", Field(), zero}}), rows(1, {})});
  {
    Link link(server.conninfo());
    CHECK(link.where() == server.where());
    CHECK(link.query("SELECT $1::bytea", 3, {zero}) == std::vector<Row>{{"a", "", zero}});
    CHECK(link.query("SELECT 2", 1).empty());
    CHECK(link.number("-12") == -12);
    for (const char* text : {"", "1a", " 1", "1e9", "99999999999999999999"})
      CHECK(told([&] { (void)link.number(text); }).id == "TB-FLEET-ANSWER");
  }
  CHECK(server.heard().at(2).find(zero) != std::string::npos);
}

TEST_CASE("fleet link: each server error has an id, and the link remains usable") {
  const std::vector<std::pair<std::string, std::string>> refusals = {
      {"53100", "TB-FLEET-FULL"}, {"42501", "TB-FLEET-DENIED"}, {"TB001", "TB-FLEET-OWNER"},
      {"22021", "TB-FLEET-SQL"},  {"57014", "TB-FLEET-SQL"},    {"42601", "TB-FLEET-SQL"}};
  std::vector<Answer> answers = {started()};
  for (const auto& [code, id] : refusals) {
    answers.emplace_back(error(code, "no") + ready());
    answers.emplace_back(rows(1, {{"1"}}));
  }
  Server server(answers);
  Link link(server.conninfo());
  for (const auto& [code, id] : refusals) {
    CAPTURE(code);
    const Told said = told([&] { (void)link.query("SELECT 1", 1); });
    CHECK((said.id == id && said.cause == FleetCause::kStore && !said.remedy.empty()));
    CHECK(link.query("SELECT 1", 1) == std::vector<Row>{{"1"}});
  }
}

TEST_CASE("fleet link: answers that PostgreSQL does not give are errors with an id") {
  const std::string copy = message('G', std::string(1, '\1') + number(0, 2));
  std::string notices;
  while (notices.size() < (3U << 20U))
    notices += message('N', "SNOTICE" + std::string(1, '\0') + "M" + std::string(5000, 'x') + '\0' + '\0');
  const std::vector<std::pair<Answer, std::string>> answers = {
      {rows(1, {}), "TB-FLEET-ANSWER"},
      {rows(1, {{"1"}, {"2"}}), "TB-FLEET-ANSWER"},
      {rows(2, {{"1", "2"}}), "TB-FLEET-ANSWER"},
      {rows(0, {{}}), "TB-FLEET-ANSWER"},
      {done("SELECT 0") + ready(), "TB-FLEET-ANSWER"},
      {rows(1, {{std::string(2000, 'a')}}), "TB-FLEET-ANSWER"},  // more than was expected
      {copy, "TB-FLEET-ANSWER"},
      {ready(), "TB-FLEET-LOST"},
      {message('?', "what"), "TB-FLEET-SILENT"},
      {message('D', "\x7f\xff"), "TB-FLEET-SILENT"},
      {"HTTP/1.1 400 Bad Request\r\n\r\n", "TB-FLEET-LOST"},
      {kHangsUp, "TB-FLEET-LOST"},
      {error("57P01", "gone") + ready(), "TB-FLEET-LOST"},
      {"", "TB-FLEET-SILENT"},
      {done("SELECT"), "TB-FLEET-SILENT"}};  // it is not over
  for (std::size_t i = 0; i < answers.size(); ++i) {
    CAPTURE(i);
    CHECK(id_after(answers[i].first) == answers[i].second);
  }
  CHECK(id_after(notices) == "TB-FLEET-ANSWER");
}

TEST_CASE("fleet link: a refused login has an id, also if the server is not PostgreSQL") {
  const std::vector<std::pair<Answer, std::string>> answers = {
      {error("28P01", "password authentication failed"), "TB-FLEET-LOGIN"},
      {error("28000", "no entry in pg_hba.conf, no SSL"), "TB-FLEET-LOGIN"},
      {message('R', number(3, 4)), "TB-FLEET-LOGIN"},  // it asks for a password, and there is none
      {error("08P01", "SSL is needed here"), "TB-FLEET-TLS"},
      {error("3D000", "no such database"), "TB-FLEET-CONNECT"},
      {"HTTP/1.1 400 Bad Request\r\n\r\n", "TB-FLEET-CONNECT"},
      {message('R', number(99, 4)), "TB-FLEET-CONNECT"},
      {"", "TB-FLEET-CONNECT"},
      {kHangsUp, "TB-FLEET-CONNECT"}};
  for (std::size_t i = 0; i < answers.size(); ++i) {
    CAPTURE(i);
    CHECK(refused(answers[i].first) == answers[i].second);
  }
  const TemporaryFolder folder;
  CHECK(told([&] { const Link link("host=" + folder.path() + "/SSL-certificate dbname=SSL user=u"); }).id ==
        "TB-FLEET-CONNECT");
}

TEST_CASE("fleet link: an invalid connection string is a usage error, and no message shows a password") {
  for (const char* words :
       {"nonsense", "colour=red", "postgresql://u:SECRET@db.lab:6000x/t?y", "host=a password=SECRET x"}) {
    CAPTURE(words);
    const Told said = told([&] { const Link link(words); });
    CHECK((said.id == "TB-FLEET-CONNINFO" && said.cause == FleetCause::kUsage));
    CHECK(said.message.find("SECRET") == std::string::npos);
  }
  for (const char* words :
       {"host=a password=SECRET dbname=b", "password = 'SECRET with \\' blanks' host=a", "password=SECRET",
        "password=a\\ SECRET", "password=a&SECRET host=b", "postgresql://u:a@SECRET@h/d", "postgresql://u:SECRET@h/d",
        "postgres://u:SEC%40RET@h/d?password=SECRET&x=1"}) {
    CAPTURE(words);
    CHECK(without_passwords(words).find("SEC") == std::string::npos);
    CHECK(without_passwords(words).find("***") != std::string::npos);
  }
  CHECK(without_passwords("host=a user=u") == "host=a user=u");
}

}  // namespace tactbench::tests::postgres

// A run packed for the fleet and unpacked again.

namespace {

std::string refusal(const std::string& body, const std::string& path) {
  try {
    db::fleet::unpack_run(body, path);
  } catch (const db::fleet::FleetError& error) {
    return error.id();
  }
  return {};
}

}  // namespace

TEST_CASE("fleet body: a packed run unpacks with its content, tags, fits and verdicts, and without other runs") {
  const TemporaryFolder folder;
  RunStore store = RunStore::open(folder.path("a.db"));
  store_example(store);
  const std::int64_t run = store_example(store);
  db::FitRecord fit;
  fit.run = run;
  fit.model = "elam";
  const std::int64_t number = store.add_fit(fit);
  db::VerdictRecord verdict;
  verdict.verdict = "pass";
  store.replace_verdicts(run, number, {verdict});
  store.set_tags(run, {"night"}, {});
  const std::string body = db::fleet::pack_run(store, run, folder.path("."));
  db::fleet::unpack_run(body, folder.path("b.db"));
  const RunStore back = RunStore::open_read_only(folder.path("b.db"));
  REQUIRE(back.runs().size() == 1);
  const db::RunRecord own = back.run(back.runs().front().run);
  CHECK((own.uuid == store.run(run).uuid && own.content_sha256 == store.run(run).content_sha256));
  CHECK(own.tags == std::vector<std::string>{"night"});
  CHECK((back.check_content(own.run).holds() && back.check_seals(own.run).empty()));
  CHECK((back.fits(own.run).size() == 1 && back.verdicts(own.run).size() == 1));
}

TEST_CASE("fleet body: a changed run is not packed, and a damaged body is not unpacked") {
  const TemporaryFolder folder;
  RunStore store = RunStore::open(folder.path("a.db"));
  const std::int64_t run = store_example(store);
  const std::string body = db::fleet::pack_run(store, run, folder.path("."));
  for (const std::string& changed : {std::string(), std::string("no zlib"), body.substr(0, body.size() / 2), body + "x",
                                     std::string(1, '\1') + body.substr(1)})
    CHECK(refusal(changed, folder.path("c.db")) == "TB-FLEET-CHANGED");
  CHECK(refusal(body, folder.path("c.db")).empty());
  db::sqlite::Connection(folder.path("a.db"), db::sqlite::Access::kReadWrite)
      .execute("UPDATE runs SET operator = 'MALLORY'");
  CHECK(store_error([&] { (void)db::fleet::pack_run(store, run, folder.path(".")); }) == "TB-STORE-CONFLICT");
}
