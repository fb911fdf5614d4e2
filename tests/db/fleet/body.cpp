// A run packed for the fleet and unpacked again.
#include "db/fleet/runs.h"

#include <catch2/catch.hpp>

#include "db/fleet/postgres.h"
#include "db/sqlite.h"
#include "tests/db/store_example.h"
#include "tests/support/process.h"

using namespace tactbench;
using namespace tactbench::tests;
using db::RunStore;

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
