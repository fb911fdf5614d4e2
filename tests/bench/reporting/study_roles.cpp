// Every way in which a run's own record contradicts the role that was typed for it, in all its words; and what agrees.
#include "bench/reporting/study_roles.h"

#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "bench/common/error.h"
#include "bench/config/config.h"
#include "tests/support/process.h"

using namespace tactbench;
using namespace tactbench::bench;

namespace {

using RunTags = std::vector<std::string>;

// Of hardware: nothing but its tags says how the sensor lay.
db::RunRecord placed_run(std::int64_t number, const RunTags& tags = {}) {
  db::RunRecord run;
  run.run = number;
  run.origin = "hardware";
  run.overrides_json = "[]";
  run.tags = tags;
  return run;
}

db::RunRecord simulated_run(std::int64_t number, const std::string& degrees, const std::string& mount_seed,
                            const RunTags& tags = {}) {
  db::RunRecord run = placed_run(number, tags);
  run.origin = "simulated";
  run.bench_toml = tests::read_file(find_config("simulated.toml"));
  run.overrides_json = fmt::format(R"([{{"key":"simulation.turned_in_chamber_deg","value":"{}"}},)"
                                   R"({{"key":"simulation.mount_seed","value":"{}"}}])",
                                   degrees, mount_seed);
  return run;
}

// "" where the role is believed; else the place of the refusal, and what its remedy ends with: what was done.
std::string role_refusal(const std::string& role, const db::RunRecord& own, const db::RunRecord& other,
                         StudyPurpose purpose = StudyPurpose::kPlainLoops) {
  try {
    check_role({other.run, role}, own, other, purpose);
  } catch (const Error& error) {
    CHECK(error.code() == ExitCode::kUsage);
    CHECK(error.id() == "TB-REPORT-STUDY");
    return error.where() + ", " + error.remedy().substr(error.remedy().rfind(' ') + 1);
  }
  return {};
}

}  // namespace

TEST_CASE("study roles: a run without a role, or without a record of its own, is believed") {
  const db::RunRecord own = placed_run(1);
  CHECK(role_refusal("", own, simulated_run(2, "90", "0"), StudyPurpose::kPresses).empty());
  for (const char* role : {"mount", "0", "90", "180", "270"}) CHECK(role_refusal(role, own, placed_run(2)).empty());
  // What is no number, and other tags, say nothing of a turn.
  for (const char* tag : {"turned=a quarter", "turned=90 degrees", "turned", "turned90", "returned=90", "turned="})
    CHECK(role_refusal("180", own, placed_run(2, {tag})).empty());
  // A bench that cannot be read, or is not simulated.
  db::RunRecord unread = simulated_run(2, "90", "0");
  unread.bench_toml = "no bench";
  CHECK(role_refusal("180", own, unread).empty());
  db::RunRecord hardware = simulated_run(2, "90", "0");
  hardware.origin = "hardware";
  CHECK(role_refusal("180", own, hardware).empty());
}

TEST_CASE("study roles: a run that presses or paces by its recipe is no run of mounts or turns") {
  const db::RunRecord own = placed_run(1);
  CHECK(role_refusal("mount", own, placed_run(6), StudyPurpose::kPresses) == "--studies 6:mount, 6");
  CHECK(role_refusal("90", own, placed_run(7), StudyPurpose::kPaces) == "--studies 7:90, 7");
}

TEST_CASE("study roles: turns are those against the report's own run, by tags and by the simulated sensor") {
  const db::RunRecord own = placed_run(1), turned = placed_run(1, {"turned=90"});
  CHECK(role_refusal("90", own, placed_run(2, {"turned=90"})).empty());
  CHECK(role_refusal("180", own, placed_run(2, {"turned=90"})) == "--studies 2:180, 2:90");
  CHECK(role_refusal("90", turned, placed_run(2, {"turned=180"})).empty());
  CHECK(role_refusal("270", turned, placed_run(2, {"turned=0"})).empty());  // backwards by 90
  CHECK(role_refusal("0", turned, placed_run(2, {"turned=450"})).empty());  // once around
  CHECK(role_refusal("180", turned, placed_run(2, {"turned=180"})) == "--studies 2:180, 2:90");
  CHECK(role_refusal("180", turned, placed_run(2, {"turned=-720"})) == "--studies 2:180, 2:270");
  // A run whose own turn cannot be read counts as not turned.
  CHECK(role_refusal("90", placed_run(1, {"turned=x"}), placed_run(2, {"turned=90"})).empty());
  // To a millionth of a degree.
  CHECK(role_refusal("90", own, placed_run(2, {"turned=90.0000009"})).empty());
  CHECK_FALSE(role_refusal("90", own, placed_run(2, {"turned=90.0000011"})).empty());
  CHECK_FALSE(role_refusal("90", own, placed_run(2, {"turned=89.9999989"})).empty());
  // The simulated sensor's own place, unless a tag says another.
  const db::RunRecord simulated = simulated_run(1, "0", "0");
  CHECK(role_refusal("90", simulated, simulated_run(3, "90", "0")).empty());
  CHECK(role_refusal("180", simulated, simulated_run(3, "90", "0")) == "--studies 3:180, 3:90");
  CHECK(role_refusal("180", simulated, simulated_run(3, "90", "0", {"turned=180"})).empty());
  CHECK(role_refusal("0", simulated_run(1, "90", "0"), simulated_run(3, "90", "0")).empty());
}

TEST_CASE("study roles: a mount is not turned, and is another one, by tags and by the simulated sensor") {
  const db::RunRecord own = placed_run(1, {"mount=a"});
  CHECK(role_refusal("mount", own, placed_run(2, {"mount=b"})).empty());
  CHECK(role_refusal("mount", placed_run(1), placed_run(2, {"mount=a"})).empty());
  CHECK(role_refusal("mount", own, placed_run(2)).empty());
  CHECK(role_refusal("mount", own, placed_run(2, {"mount=a"})) == "--studies 2:mount, 2");
  CHECK(role_refusal("mount", own, placed_run(2, {"mount=b", "turned=90"})) == "--studies 2:mount, 2:90");
  CHECK(role_refusal("mount", own, placed_run(2, {"mount=b", "turned=0"})).empty());
  // One that is turned may lie in the same mount: only the turn is asked for.
  CHECK(role_refusal("90", own, placed_run(2, {"mount=a", "turned=90"})).empty());
  const db::RunRecord simulated = simulated_run(1, "0", "4");
  CHECK(role_refusal("mount", simulated, simulated_run(3, "0", "5")).empty());
  CHECK(role_refusal("mount", simulated, simulated_run(3, "0", "4")) == "--studies 3:mount, 3");
  CHECK(role_refusal("mount", simulated, simulated_run(3, "0", "4", {"mount=other"})).empty());
}
