// A run on instruments whose calibration is overdue is warned of, from the day after their due date on.
#include <catch2/catch.hpp>
#include <ctime>

#include "bench/common/utc.h"
#include "tests/support/process.h"
#include "tests/support/small_run.h"

using namespace tactbench;
using namespace tactbench::tests;

namespace {

std::string day_from_now(int days) {
  const std::time_t then = std::time(nullptr) + days * 86400;
  std::tm utc{};
  gmtime_r(&then, &utc);
  char text[16] = {};
  std::strftime(text, sizeof text, "%Y-%m-%d", &utc);
  return text;
}

std::vector<std::string> calibration_warnings_with(const std::string& due) {
  const TemporaryFolder folder;
  db::RunStore store = db::RunStore::open(folder.path("runs.db"), db::Durability::kNormal);
  bench::RunRequest request = small_request({{"reference.due", "\"" + due + "\""}});
  request.recipes = {recipe_of("unit = \"psi\"\nturning_points = [0, 2]\nstep = 2\n")};
  REQUIRE(run_small(request, store).outcome == db::Outcome::kCompleted);
  std::vector<std::string> found;
  for (const db::EventRecord& event : store.events(1)) {
    if (event.id == "TB-CALIBRATION") found.push_back(event.kind + ": " + event.detail);
  }
  return found;
}

}  // namespace

TEST_CASE("calibration warnings: on the due date there is none, a day later there is") {
  for (int tries = 0; tries < 2; ++tries) {
    const std::string today = day_from_now(0), yesterday = day_from_now(-1);
    const std::vector<std::string> due = calibration_warnings_with(today),
                                   overdue = calibration_warnings_with(yesterday);
    if (day_from_now(0) != today) continue;  // midnight has passed
    CHECK(due.empty());
    REQUIRE(overdue.size() == 1);
    CHECK(overdue[0] ==
          "warning: pressure reference (simulated transducer, 100 psi, serial SIM-REF-1) is OVERDUE for calibration "
          "since " +
              yesterday);
    return;
  }
}
