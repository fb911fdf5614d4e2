// Under which conditions a verdict holds: on runs of the simulated rig whose mount, age and temperature are known.
#include <algorithm>
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "tests/support/process.h"
#include "tests/support/run_recipe.h"

using namespace tactbench::tests;
using nlohmann::json;

namespace {

json answer(const TemporaryFolder& folder, std::vector<std::string> words, int code) {
  words.emplace_back("--json");
  const Finished done = call(folder, words);
  INFO(done.out << done.err);
  CHECK(done.code == code);
  return json::parse(done.out);
}

bool leaves_open(const json& judgement, const std::string& source) {
  return std::ranges::any_of(judgement["not_assessed"], [&](const json& own) { return own["source"] == source; });
}

}  // namespace

TEST_CASE("U of an error in one mount is no U of the sensor mounted anew or a month later, and the pass says so") {
  // The audit: 0.067 psi in the same mount, and the same sensor 0.690 psi re-mounted, 1.076 psi after a month.
  const TemporaryFolder folder;
  REQUIRE(call(folder, {"init"}).code == 0);
  REQUIRE(call(folder, {"sensors", "add", "S-1", "--type", "sensor.toml"}).code == 0);
  write_file(folder.path("limits.toml"),
             "schema = 1\nname = \"limits\"\nrule = \"default\"\nmean_compensation_error_psi = 0.5\n"
             "worst_taxel_error_psi = 60\ndistance_of_mean_percent_fs = 100\nunfit_taxels = 256\n");
  run_recipe(
      folder, "loops",
      {"--seed", "1", "--set", "recipe.dwell_s=1", "--set", "recipe.turning_points=[0, 60, 0, 40, 0, 60, 20, 60, 0]"});
  run_recipe(
      folder, "loops",
      {"--seed", "2", "--set", "recipe.dwell_s=1", "--set", "recipe.turning_points=[0, 60, 0, 40, 0, 60, 20, 60, 0]"});
  run_recipe(
      folder, "loops",
      {"--seed", "3", "--set", "recipe.dwell_s=1", "--set", "recipe.turning_points=[0, 60, 0, 40, 0, 60, 20, 60, 0]",
       "--set", "simulation.effects.remount_variation=0.03", "--set", "simulation.mount_seed=4"});
  run_recipe(
      folder, "loops",
      {"--seed", "4", "--set", "recipe.dwell_s=1", "--set", "recipe.turning_points=[0, 60, 0, 40, 0, 60, 20, 60, 0]",
       "--set", "simulation.age_months=1", "--set", "simulation.temperature_c=28", "--set",
       "simulation.effects.gain_drift_per_month=0.01", "--set", "simulation.effects.zero_drift_v_per_month=0.01"});
  // ELAM: the dynamic model's observer of the gain makes up for much of the month.
  REQUIRE(call(folder, {"fit", "1", "--model", "elam"}).code == 0);
  const json same = answer(folder, {"judge", "1", "2", "--limits", "limits.toml"}, 0)["judgement"];
  CHECK(same["overall"] == "pass");
  REQUIRE(same["runs"].size() == 1);
  CHECK(same["runs"][0]["run"] == 2);
  CHECK(same["runs"][0]["trajectory"]["other_dwell"] == false);
  for (const char* source : {"re-mounting", "time"}) CHECK(leaves_open(same, source));
  (void)answer(
      folder,
      {"report", "1", "--held-out", "2", "3", "4", "--limits", "limits.toml", "--format", "json", "-o", "r.json"}, 1);
  const json data = json::parse(read_file(folder.path("r.json")));
  const auto of_run = [](const json& rows, const std::string& run, const char* key) {
    for (const json& row : rows)
      if (row["on"] == "held-out run " + run && row["criterion"] == "mean_compensation_error")
        return row[key].get<double>();
    return -1.0;
  };
  const json &verdicts = data["results"]["verdicts"], &figures = data["sections"]["uncertainty"]["judged_figures"];
  const double value = of_run(verdicts, "A", "value"), expanded = of_run(figures, "A", "expanded");
  CHECK(expanded > 0.05);
  CHECK(expanded < 0.12);
  CHECK(of_run(verdicts, "B", "value") > value + 3.0 * expanded);
  CHECK(of_run(verdicts, "C", "value") > value + 6.0 * expanded);
  // When they are judged, too, they decide, and are no longer missing.
  const json& judgement = data["results"]["judgement"];
  CHECK(judgement["overall"] == "fail");
  for (const char* source : {"re-mounting", "temperature", "time"}) CHECK_FALSE(leaves_open(judgement, source));
  CHECK_FALSE(judgement["not_assessed"].empty());  // no run tells the age of the reference's calibration
  for (const char* run : {"1", "2", "3", "4"}) CHECK(call(folder, {"verify", run}).code == 0);
}
