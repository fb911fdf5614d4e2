// reports verify: a signed report that comes back is the one that was written, or it is told that it is not.
#include <catch2/catch.hpp>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "db/sqlite.h"
#include "tests/bench/cli/check_refusal.h"
#include "tests/support/process.h"

using namespace tactbench;
using namespace tactbench::tests;
using nlohmann::json;

TEST_CASE("reports verify: unchanged, changed, unknown, not signed, replaced, void") {
  const TemporaryFolder folder;
  REQUIRE(call(folder, {"init"}).code == 0);
  write_file(folder.path("small.toml"),
             "schema = 1\nname = \"small\"\nunit = \"psi\"\nturning_points = [0, 60, 20, 60, 0]\nstep = 20\n"
             "repeats = 1\ndwell_s = 1.0\n");
  REQUIRE(call(folder, {"sensors", "add", "S-1"}).code == 0);
  REQUIRE(call(folder, {"run", "small.toml", "--bench", "bench.toml", "--sensor", "S-1", "--operator", "t", "-q",
                        "--no-seating"})
              .code == 0);
  REQUIRE(call(folder, {"report", "1"}).code == 0);
  CHECK(call(folder, {"reports", "verify", "reports/run-1.html"}).code == 6);
  REQUIRE(call(folder, {"report", "1", "--approve-by", "A. Chief", "--without-verdict"}).code == 0);
  const json listed = json::parse(call(folder, {"reports", "list", "--json"}).out).at("reports");
  REQUIRE(listed.size() == 1);
  const std::string number = listed.at(0).at("number"), file = listed.at(0).at("file");
  for (const std::string& named : {number, file}) {
    well(call(folder, {"reports", "verify", named}));
  }
  // One figure of the page.
  std::string page = read_file(folder.path(file));
  const std::size_t at = page.rfind("psi");
  page[at - 2] = page[at - 2] == '1' ? '2' : '1';
  write_file(folder.path("forged.html"), page);
  const Finished forged = call(folder, {"reports", "verify", "forged.html", "--json"});
  CHECK(forged.code == 1);
  CHECK(json::parse(forged.out).at("files").at(0).at("state") == "changed");
  // A copy in another format is another file of the same report.
  REQUIRE(call(folder, {"report", "1", "--format", "json", "-o", "copy.json"}).code == 0);
  CHECK(call(folder, {"reports", "verify", "copy.json"}).code == 0);
  // Another store signed nothing of it.
  REQUIRE(call(folder, {"sensors", "add", "S-2", "--db", "other.db"}).code == 0);
  CHECK(call(folder, {"reports", "verify", file, "--db", "other.db"}).code == 1);
  CHECK(call(folder, {"reports", "verify", "1-00000000"}).code == 1);
  CHECK(call(folder, {"reports", "verify", "what"}).code == 2);
  // A report that was signed later replaces it.
  REQUIRE(call(folder, {"runs", "tag", "1", "lot=A7"}).code == 0);
  const std::vector<std::string> sign = {"report", "1", "--approve-by", "A. Chief", "--without-verdict"};
  CHECK(call(folder, sign).code == 2);  // without a reason
  REQUIRE(call(folder, {sign[0], sign[1], sign[2], sign[3], sign[4], "--reason", "lot added"}).code == 0);
  CHECK(call(folder, {"reports", "verify", number}).code == 0);
  // A store that forgot who signed.
  std::filesystem::copy_file(folder.path("runs.db"), folder.path("touched.db"));
  db::sqlite::Connection(folder.path("touched.db"), db::sqlite::Access::kReadWrite)
      .execute("UPDATE reports SET approved_by = 'B. Chief'");
  CHECK(call(folder, {"reports", "verify", file, "--db", "touched.db"}).code == 1);
  REQUIRE(call(folder, {"runs", "void", "1", "--reason", "gauge closed", "--by", "me"}).code == 0);
  CHECK(call(folder, {"reports", "verify", number}).code == 1);
}
