// Copies to and from the fleet's server, against a server by script: every byte, and every way in which they end early.
#include <catch2/catch.hpp>
#include <stdexcept>

#include "db/fleet/postgres.h"
#include "tests/db/fleet/scripted_postgres.h"

namespace tactbench::tests::postgres {

using namespace db::fleet;
using Catch::Contains;
using Words = std::vector<std::string>;

namespace {

// Gives out one piece after the other.
std::function<bool(std::string&)> pieces(const Words& all) {
  return [all, next = std::size_t{0}](std::string& buffer) mutable {
    if (next < all.size()) buffer = all[next++];
    return next < all.size();
  };
}

Told told_of_copy_in(const std::vector<Answer>& answers) {
  std::vector<Answer> all = {started()};
  all.insert(all.end(), answers.begin(), answers.end());
  Server server(all);
  Link link(server.conninfo(), kSoon);
  return told([&] { link.copy_in("COPY t FROM STDIN", pieces({"a", "b"})); });
}

Told told_of_copy_out(const Answer& answer, std::string* taken = nullptr) {
  Server server({started(), answer});
  Link link(server.conninfo(), kSoon);
  const auto take = [&](std::string_view piece) {
    if (taken != nullptr) *taken += piece;
  };
  return told([&] { link.copy_out("COPY t TO STDOUT", take); });
}

}  // namespace

TEST_CASE("fleet copy: pieces go in their order, empty ones are left out, and the end is said once") {
  if (!built_with_libpq()) return;
  Server server({started(), copy('G'), done("COPY") + ready(), copy('G'), done("COPY") + ready(), rows(1, {{"x"}})});
  {
    Link link(server.conninfo());
    link.copy_in("COPY t FROM STDIN", pieces({"first", "", std::string("sec\0nd", 6), "last"}));
    link.copy_in("COPY u FROM STDIN", pieces({""}));
    CHECK(link.query("SELECT 1") == std::vector<TextRow>{{"x"}});
  }
  Words heard = server.heard();
  REQUIRE(heard.size() == 14);
  heard.resize(8);
  heard.erase(heard.begin());
  CHECK(heard == Words{"QCOPY t FROM STDIN" + std::string(1, '\0'), "dfirst", std::string("dsec\0nd", 7), "dlast", "c",
                       "QCOPY u FROM STDIN" + std::string(1, '\0'), "c"});
}

TEST_CASE("fleet copy: more than a socket holds is sent whole, and a server that takes no more is silent") {
  if (!built_with_libpq()) return;
  const std::string large(4'000'000, 'x');
  Server server({started(), copy('G'), done("COPY") + ready()});
  {
    Link link(server.conninfo());
    link.copy_in("COPY t FROM STDIN", pieces({large, large, "end"}));
  }
  const Words heard = server.heard();
  REQUIRE(heard.size() == 7);
  CHECK((heard[2] == "d" + large && heard[3] == "d" + large && heard[4] == "dend" && heard[5] == "c"));
  Server deaf({started(), {copy('G'), Answer::Then::kIsDeaf}});
  Link link(deaf.conninfo(), kSoon);
  CHECK(told([&] { link.copy_in("COPY t FROM STDIN", pieces({large, large})); }).id == "TB-FLEET-SILENT");
}

TEST_CASE("fleet copy: a server that refuses a copy, breaks it off, or answers with something else is told") {
  if (!built_with_libpq()) return;
  const Told refused = told_of_copy_in({error("42P01", "no such table") + ready()});
  CHECK(refused.id == "TB-FLEET-SQL");
  CHECK_THAT(refused.message, Contains("no such table"));
  const Told full = told_of_copy_in({copy('G'), error("53100", "no room") + ready()});
  CHECK(full.id == "TB-FLEET-FULL");
  CHECK_THAT(full.message, Contains("no room"));
  CHECK(told_of_copy_in({copy('G'), kHangsUp}).id == "TB-FLEET-LOST");
  const Told silent = told_of_copy_in({copy('G'), ""});
  INFO(silent.message);
  CHECK(silent.id == "TB-FLEET-SILENT");
  CHECK(told_of_copy_in({copy('H')}).id == "TB-FLEET-LOST");
  CHECK(told_of_copy_in({done("COPY") + ready()}).id == "TB-FLEET-LOST");
  CHECK(told_of_copy_in({kHangsUp}).id == "TB-FLEET-LOST");
  CHECK(told_of_copy_in({copy('G'), done("COPY") + ready()}).id.empty());
}

TEST_CASE(
    "fleet copy: when the store cannot be read the server is told to drop what came, and the error is passed on") {
  if (!built_with_libpq()) return;
  Server server({started(), copy('G'), error("57014", "COPY failed") + ready(), rows(1, {{"still there"}})});
  {
    Link link(server.conninfo());
    int asked = 0;
    const auto breaks = [&](std::string& buffer) -> bool {
      if (++asked == 2) throw std::runtime_error("the disk failed");
      buffer = "half";
      return true;
    };
    CHECK_THROWS_WITH(link.copy_in("COPY t FROM STDIN", breaks), "the disk failed");
    CHECK(link.query("SELECT 1") == std::vector<TextRow>{{"still there"}});
  }
  const Words heard = server.heard();
  REQUIRE(heard.size() > 3);
  CHECK(heard[2] == "dhalf");
  CHECK(heard[3] == "fthe store could not be read" + std::string(1, '\0'));
}

TEST_CASE("fleet copy: what comes is handed out piece by piece, and an error after it is told") {
  if (!built_with_libpq()) return;
  Server server({started(), copy('H') + piece("one") + piece("two\n") + message('c', "") + done("COPY") + ready(),
                 rows(1, {{"x"}})});
  Link link(server.conninfo());
  Words taken;
  link.copy_out("COPY t TO STDOUT", [&](std::string_view bytes) { taken.emplace_back(bytes); });
  CHECK(taken == Words{"one", "two\n"});
  CHECK(link.query("SELECT 1") == std::vector<TextRow>{{"x"}});

  std::string bytes;
  const Told broken = told_of_copy_out(copy('H') + piece("one") + error("XX001", "a bad page") + ready(), &bytes);
  CHECK((broken.id == "TB-FLEET-SQL" && bytes == "one"));
  CHECK_THAT(broken.message, Contains("(XX001): a bad page"));
  CHECK(told_of_copy_out(error("42P01", "no such table") + ready()).id == "TB-FLEET-SQL");
  CHECK(told_of_copy_out(copy('G')).id == "TB-FLEET-LOST");
  CHECK(told_of_copy_out(done("COPY") + ready()).id == "TB-FLEET-LOST");
  CHECK(told_of_copy_out({copy('H') + piece("one"), Answer::Then::kHangsUp}).id == "TB-FLEET-LOST");
  CHECK(told_of_copy_out(copy('H') + piece("one")).id == "TB-FLEET-SILENT");
}

}  // namespace tactbench::tests::postgres
