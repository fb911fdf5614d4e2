// `benchmark fleet` against a server by script, with a script in place of psql: what both are told, in which order, and
// what is timed. Its stores are empty, so that the server needs no answers of its own.
#include <sys/stat.h>

#include <catch2/catch.hpp>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include "bench/benchmarks/fleet.h"
#include "bench/common/error.h"
#include "db/fleet/postgres.h"
#include "db/run_store.h"
#include "tests/bench/benchmarks/counted_time.h"
#include "tests/db/fleet/scripted_postgres.h"
#include "tests/support/variable.h"

using namespace tactbench;
using namespace tactbench::bench;
using namespace tactbench::tests;

namespace {

using Statements = std::vector<std::string>;

// In PATH before the system's: writes down its words and ends as `then` says.
class PsqlInPlace {
 public:
  explicit PsqlInPlace(const std::string& then) : path_("PATH", folder_.path() + ":" + std::getenv("PATH")) {
    write_file(folder_.path("psql"),
               "#!/bin/sh\nprintf '%s\\n' \"$@\" >> '" + folder_.path("words") + "'\n" + then + "\n");
    ::chmod(folder_.path("psql").c_str(), 0700);
  }
  [[nodiscard]] std::string words() const { return read_file(folder_.path("words")); }

 private:
  TemporaryFolder folder_;
  Variable path_;
};

std::vector<postgres::Answer> answers_up_to_the_rounds(const std::string& runs) {
  return {postgres::started(), postgres::rows(1, {{"fleet.migrations"}}), postgres::rows(1, {{"2"}}),
          postgres::rows(1, {{runs}}), postgres::done("DROP") + postgres::done("CREATE") + postgres::ready()};
}

std::string fleet_refusal(const PsqlInPlace&, postgres::Server& server, const TemporaryFolder& folder) {
  try {
    (void)benchmark_fleet(1, server.conninfo(), folder.path(), {0, 1});
  } catch (const Error& error) {
    return error.id() + ": " + error.what() + "; " + error.remedy();
  }
  return {};
}

}  // namespace

TEST_CASE("benchmark fleet: rows to a table of the same shape and back by psql, and what is timed of each round") {
  if (!db::fleet::built_with_libpq()) return;
  const TemporaryFolder folder;
  const PsqlInPlace psql("exit 0");
  std::vector<postgres::Answer> answers = answers_up_to_the_rounds("0");
  const std::string ok = postgres::done("DONE") + postgres::ready();
  for (int round = 0; round < 2; ++round) {
    answers.emplace_back(postgres::rows(3, {}));  // nothing waits
    answers.emplace_back(ok);
    for (int i = 0; i < 5; ++i) answers.emplace_back(postgres::rows(3, {}));
  }
  answers.emplace_back(ok);
  postgres::Server server(answers);
  std::vector<Figure> figures;
  std::size_t readings = 0;
  {
    const CountedTime time;
    figures = benchmark_fleet(2, server.conninfo(), folder.path(), {0, 1});
    readings = time.readings().size();
  }
  CHECK(readings == 2 * 2 * (1 + 1 + 5));
  REQUIRE(figures.size() == 8);
  CHECK(figures[0].name == "fleet_push");
  CHECK(figures[0].value == 0.0);  // no frames
  CHECK(figures[3].name == "fleet_push_over_copy");
  CHECK(figures[3].value == 4.0 / 2.0);
  std::string expected;
  for (const std::string round : {"0", "1"}) {
    const std::string db = folder.path(round + ".db"), file = folder.path(round + ".copy");
    const std::string head = "-X\n-q\n-v\nON_ERROR_STOP=1\n-d\n" + server.conninfo() + "\n-c\n";
    expected +=
        head + "\\copy (SELECT f.* FROM fleet.frames f WHERE run IN (SELECT run FROM fleet.revisions WHERE source = '" +
        db + "') ORDER BY run, position) TO '" + file + "' (FORMAT binary)\n";
    expected += head + "\\copy public.tactbench_benchmark FROM '" + file + "' (FORMAT binary)\n";
    CHECK(db::RunStore::open_read_only(db).runs().empty());
  }
  CHECK(psql.words() == expected);
  // In each round it is asked what is there before the push, and five times when it is pushed again.
  int asked = 0;
  for (const std::string& one : server.heard())
    if (one.front() == 'P' && one.find("FROM fleet.runs r WHERE r.uuid = ANY") != std::string::npos) ++asked;
  CHECK(asked == 2 * (1 + 5));
  CHECK(server.statements() ==
        Statements{"DROP TABLE IF EXISTS public.tactbench_benchmark; CREATE TABLE public.tactbench_benchmark (LIKE "
                   "fleet.frames INCLUDING ALL)",
                   "TRUNCATE public.tactbench_benchmark", "TRUNCATE public.tactbench_benchmark",
                   "DROP TABLE public.tactbench_benchmark"});
}

TEST_CASE("benchmark fleet: a fleet that holds runs is refused before anything is changed") {
  if (!db::fleet::built_with_libpq()) return;
  const TemporaryFolder folder;
  const PsqlInPlace psql("exit 0");
  postgres::Server server(answers_up_to_the_rounds("3"));
  CHECK(fleet_refusal(psql, server, folder) ==
        "TB-USAGE: this fleet holds runs, and those of a benchmark could never be taken away; name a database of its "
        "own: createdb benchmark; tactbench fleet migrate --to ...");
  CHECK(server.statements().empty());
  CHECK(std::filesystem::is_empty(folder.path()));
}

TEST_CASE("benchmark fleet: a psql that fails, or that a signal ends, is an error") {
  if (!db::fleet::built_with_libpq()) return;
  for (const char* then : {"exit 1", "kill -9 $$"}) {
    INFO(then);
    const TemporaryFolder folder;
    const PsqlInPlace psql(then);
    std::vector<postgres::Answer> answers = answers_up_to_the_rounds("0");
    answers.emplace_back(postgres::rows(3, {}));
    postgres::Server server(answers);
    CHECK(fleet_refusal(psql, server, folder) ==
          "TB-USAGE: psql could not do its part of the benchmark; install postgresql-client, and log in as the owner "
          "of the database");
  }
}
