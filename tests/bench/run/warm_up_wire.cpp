// The warm-up of a run on the simulated rig: unloaded frames a quarter of a minute apart, until they are calm or the
// time is up.
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/bench/run/quick_store.h"
#include "tests/support/small_run.h"

using namespace tactbench;
using namespace tactbench::tests;

namespace {

struct WarmedUp {
  std::vector<db::CheckRecord> checks;
  std::int64_t first_frame_ns = 0;
};

WarmedUp warmed_up(const std::string& rule) {
  QuickStore store;
  bench::RunRequest request = small_request();
  request.recipes = {small_recipe(rule)};
  const bench::RunResult result = run_small(request, store);
  REQUIRE(!result.error);
  WarmedUp found;
  found.first_frame_ns = store.frames(result.run).at(0).time_ns;
  for (db::CheckRecord& check : store.checks(result.run))
    if (check.kind == "warm-up") found.checks.push_back(std::move(check));
  return found;
}

nlohmann::json detail_of(const WarmedUp& found) {
  REQUIRE(found.checks.size() == 1);
  return nlohmann::json::parse(found.checks.front().detail_json);
}

// The time that the unloaded frames themselves take is far below a second.
bool about(double seconds, double expected) { return seconds >= expected && seconds < expected + 1.0; }

}  // namespace

TEST_CASE("warm-up: it ends with the first quarter of a minute in which the array drifts little enough") {
  const WarmedUp found = warmed_up("[warm_up]\ndrift_percent_per_min = 100.0\nat_most_s = 600\n");
  const nlohmann::json detail = detail_of(found);
  CHECK(found.checks.front().verdict == "pass");
  REQUIRE(found.checks.front().data.size() == 1);
  CHECK(found.checks.front().data[0] == detail.at("last_drift_percent_per_min").get<double>());
  CHECK(about(detail.at("took_s").get<double>(), 15.0));
  CHECK(detail.at("limit_percent_per_min") == 100.0);
  CHECK(detail.at("at_most_s") == 600.0);
  CHECK(found.first_frame_ns > 15'000'000'000);
  CHECK(found.first_frame_ns < 45'000'000'000);
}

TEST_CASE("warm-up: an array that never calms down is waited for until the time is up, and the run goes on warned") {
  // A mean of 256 counts stays the same to a millionth of a percent a minute in no two frames.
  const WarmedUp found = warmed_up("[warm_up]\ndrift_percent_per_min = 1e-6\nat_most_s = 50\n");
  const nlohmann::json detail = detail_of(found);
  CHECK(found.checks.front().verdict == "warning");
  CHECK(found.checks.front().data.size() == 4);  // after 15, 30, 45 and 60 s
  CHECK(about(detail.at("took_s").get<double>(), 60.0));
  for (const double drift : found.checks.front().data) {
    CHECK(drift > 0.0);
    CHECK(drift < 1.0);  // % of the converter's range a minute
  }
  CHECK(detail.at("last_drift_percent_per_min").get<double>() == found.checks.front().data.back());
  CHECK(found.first_frame_ns > 60'000'000'000);
}
