// What ends a run that cannot go on, or was asked for what its bench does not have.
#include <catch2/catch.hpp>
#include <fstream>

#include "tests/support/process.h"
#include "tests/support/refusal.h"
#include "tests/support/small_run.h"

using namespace tactbench;
using namespace tactbench::tests;

namespace {

struct Refused {
  TemporaryFolder folder;
  db::RunStore store = db::RunStore::open(folder.path("runs.db"), db::Durability::kNormal);
  bench::RunRequest request = small_request();
  void check(const std::string& id, bench::ExitCode code) {
    const bench::RunResult result = run_small(request, store);
    REQUIRE(result.error);
    CHECK(result.error->id() == id);
    CHECK(result.error->code() == code);
    CHECK(result.safe == db::SafeState::kVerified);
    CHECK(result.outcome == db::Outcome::kFailed);
  }
};

}  // namespace

TEST_CASE("run: a file that holds no state of the film is not taken for one, and one that it wrote is") {
  Refused run;
  run.request.specimen_state_file = run.folder.path("film");
  std::ofstream(run.request.specimen_state_file) << "name = \"film\"\n";
  run.check("TB-SPECIMEN-STATE", bench::ExitCode::kUsage);
  std::filesystem::remove(run.request.specimen_state_file);
  CHECK(run_small(run.request, run.store).outcome == db::Outcome::kCompleted);
  CHECK(run_small(run.request, run.store).outcome == db::Outcome::kCompleted);
}

TEST_CASE("run: what its bench lacks or does not allow is refused before a row exists") {
  const auto [what, id] = GENERATE(table<std::string, std::string>(
      {{"stage", "TB-RECIPE-DEVICES"}, {"force", "TB-RECIPE-DEVICES"}, {"command", "TB-RECIPE-LIMIT"}}));
  Refused run;
  run.request.assume_yes = true;
  if (what != "command") run.request.recipes = {recipe_of(press_text(1))};
  if (what == "stage") run.request.bench.stage.reset();
  if (what == "force") run.request.bench.force.reset();
  if (what == "command") run.request.bench.limits.command_psi = 6.0;
  const auto refused = refusal_by([&] { (void)run_small(run.request, run.store); });
  REQUIRE(refused);
  CHECK(refused->id() == id);
  CHECK(run.store.runs().empty());
}

TEST_CASE("run: forces beyond what the force sensor's calibration goes to are refused before the stage moves") {
  Refused run;
  run.request = small_request({{"force.overload_share", "0.5"}});
  run.request.recipes = {recipe_of(press_text(1))};
  run.request.assume_yes = true;
  const bench::RunResult result = run_small(run.request, run.store);
  REQUIRE(result.error);
  CHECK(result.error->id() == "TB-PRESS-LIMIT");
  CHECK(result.error->code() == bench::ExitCode::kStopped);
  CHECK_THAT(result.error->what(), Catch::Contains("30 N") && Catch::Contains("17.5 N"));
  CHECK(run.store.frames(result.run).empty());
}
