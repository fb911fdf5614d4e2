// The seating check inside runs of the simulated rig.
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "tests/bench/run/quick_store.h"
#include "tests/support/small_run.h"

using namespace tactbench;
using namespace tactbench::tests;
using bench::ExitCode;

namespace {

bench::RunResult run_seated(db::RunStore& store, const std::vector<sequences::Override>& overrides = {},
                            bool check_seating = true) {
  bench::RunRequest request = small_request(overrides);
  request.check_seating = check_seating;
  return run_small(request, store);
}

std::vector<db::CheckRecord> seatings(const db::RunStore& store, std::int64_t run) {
  std::vector<db::CheckRecord> found;
  for (db::CheckRecord& check : store.checks(run)) {
    if (check.kind == "seating") found.push_back(std::move(check));
  }
  return found;
}

std::string first_kind(const db::CheckRecord& check) {
  return nlohmann::json::parse(check.detail_json).at("findings").at(0).at("kind");
}

// A whole row of the specimen, as the bench file has it.
bench::RunRequest with_dead_row(int row) {
  bench::RunRequest request = small_request();
  request.check_seating = true;
  for (int c = 0; c < 16; ++c) {
    request.bench.simulation->plant.specimen.defects.push_back({bench::TaxelDefect::Kind::kDead, row, c});
  }
  return request;
}

}  // namespace

TEST_CASE("seating: the check is stored before the first frame, and an equal run has equal content") {
  QuickStore store;
  const bench::RunResult first = run_seated(store);
  REQUIRE(!first.error);
  CHECK(first.frames == 2 * 15);
  const std::vector<db::CheckRecord> checks = seatings(store, first.run);
  REQUIRE(checks.size() == 1);
  CHECK(checks.front().verdict == "pass");
  CHECK(checks.front().data.size() == 2U * 256U);
  CHECK(checks.front().time_ns < 60'000'000'000);
  const auto detail = nlohmann::json::parse(checks.front().detail_json);
  CHECK(detail.at("pressure_psi").get<double>() == Approx(8.0).margin(0.3));
  CHECK(detail.at("mean_response_v").get<double>() > 0.5);
  CHECK(detail.at("findings").empty());
  const bench::RunResult again = run_seated(store);  // now with a last seating
  CHECK(again.content_sha256 == first.content_sha256);
}

TEST_CASE("seating: a sensor mounted again a month later on a warmer day passes") {
  QuickStore store;
  REQUIRE(!run_seated(store).error);
  const bench::RunResult result = run_seated(store, {{"simulation.mount_seed", "1"},
                                                     {"simulation.effects.remount_variation", "0.03"},
                                                     {"simulation.temperature_c", "28"},
                                                     {"simulation.age_months", "1"},
                                                     {"simulation.effects.gain_drift_per_month", "0.01"},
                                                     {"simulation.effects.zero_drift_v_per_month", "0.01"}});
  CHECK(!result.error);
  CHECK(seatings(store, result.run).front().verdict == "pass");
}

TEST_CASE("seating: a turned sensor ends the second run, vented, but not the first") {
  QuickStore store;
  REQUIRE(!run_seated(store).error);
  const bench::RunResult result = run_seated(store, {{"simulation.mount_turn", "\"turned-90\""}});
  REQUIRE(result.error);
  CHECK(result.error->id() == "TB-SEATING");
  CHECK(result.error->code() == ExitCode::kCriterionFailed);
  CHECK_THAT(result.error->what(), Catch::Contains("90"));
  CHECK_FALSE(result.error->remedy().empty());
  CHECK(result.frames == 0);
  CHECK(result.safe == db::SafeState::kVerified);
  CHECK(store.run(result.run).outcome == db::Outcome::kFailed);
  REQUIRE(seatings(store, result.run).size() == 1);
  CHECK(seatings(store, result.run).front().verdict == "fail");
  CHECK(first_kind(seatings(store, result.run).front()) == "turned");
  // A failed seating is nothing to compare with: turned back, it passes again.
  CHECK(!run_seated(store).error);
}

TEST_CASE("seating: a dead row ends the very first run") {
  QuickStore store;
  const bench::RunResult dead = run_small(with_dead_row(4), store);
  REQUIRE(dead.error);
  CHECK(dead.error->id() == "TB-SEATING");
  CHECK_THAT(dead.error->what(), Catch::Contains("row 4"));
}

TEST_CASE("seating: without the check a badly seated sensor is measured, and the run records the missing check") {
  QuickStore store;
  bench::RunRequest request = with_dead_row(4);
  request.check_seating = false;
  const bench::RunResult result = run_small(request, store);
  CHECK(!result.error);
  CHECK(seatings(store, result.run).empty());
  bool said = false;
  for (const db::EventRecord& event : store.events(result.run)) {
    said = said || (event.kind == "seating" && event.detail.find("--no-seating") != std::string::npos);
  }
  CHECK(said);
}

TEST_CASE("seating: a low recipe is not checked, the peak of a medium recipe is the load of the check") {
  QuickStore store;
  bench::RunRequest request = small_request();
  request.check_seating = true;
  const auto up_to = [](const std::string& psi) {
    return sequences::parse_recipe(sequences::TomlDocument::from_text(
        "schema = 1\nname = \"low\"\nunit = \"psi\"\nturning_points = [0, " + psi + ", 0]\nstep = 2\n", "low.toml"));
  };
  request.recipes = {up_to("4")};
  const bench::RunResult low = run_small(request, store);
  REQUIRE(!low.error);
  CHECK(seatings(store, low.run).empty());
  request.recipes = {up_to("6")};
  const bench::RunResult between = run_small(request, store);
  REQUIRE(!between.error);
  REQUIRE(seatings(store, between.run).size() == 1);
  const auto detail = nlohmann::json::parse(seatings(store, between.run).front().detail_json);
  CHECK(detail.at("pressure_psi").get<double>() == Approx(6.0).margin(0.3));
}

TEST_CASE("seating: many dead taxels give one warning, later runs accept them without a warning") {
  QuickStore store;
  bench::RunRequest request = small_request();
  request.check_seating = true;
  for (int i = 0; i < 8; ++i) {
    request.bench.simulation->plant.specimen.defects.push_back({bench::TaxelDefect::Kind::kDead, i, 15 - i});
  }
  const bench::RunResult first = run_small(request, store);
  CHECK(!first.error);
  REQUIRE(seatings(store, first.run).size() == 1);
  CHECK(seatings(store, first.run).front().verdict == "warning");
  CHECK(first_kind(seatings(store, first.run).front()) == "dead-taxels");
  const bench::RunResult second = run_small(request, store);
  CHECK(seatings(store, second.run).front().verdict == "pass");
}
