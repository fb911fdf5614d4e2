// Under which conditions a verdict holds: on runs of the simulated rig whose mount, age, temperature and certificate
// are known.
#include <algorithm>
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "tests/support/process.h"
#include "tests/support/run_recipe.h"

using namespace tactbench::tests;
using nlohmann::json;

namespace {

using Words = std::vector<std::string>;

void measure(const TemporaryFolder& folder, const std::string& recipe, const std::string& seed, const Words& set = {}) {
  Words more = {"--seed", seed};
  for (const std::string& one : set) more.insert(more.end(), {"--set", one});
  run_recipe(folder, recipe, more);
}

void prepare_runs(const TemporaryFolder& folder) {
  REQUIRE(call(folder, {"init"}).code == 0);
  REQUIRE(call(folder, {"sensors", "add", "S-1", "--type", "sensor.toml"}).code == 0);
  write_file(folder.path("loop.toml"),
             "schema = 1\nname = \"loop\"\nunit = \"psi\"\nturning_points = [0, 60, 20, 60, 0]\nstep = 10\n"
             "repeats = 3\ndwell_s = 1.0\n");
  write_file(folder.path("limits.toml"),
             "schema = 1\nname = \"limits\"\nrule = \"default\"\nmean_compensation_error_psi = 6\n"
             "worst_taxel_error_psi = 60\ndistance_of_mean_percent_fs = 100\nunfit_taxels = 256\n"
             "[[mpe]]\nspan_psi = [10, 30]\nmpe_psi = 200\n");
}

json answer(const TemporaryFolder& folder, Words words, int code) {
  words.emplace_back("--json");
  const Finished done = call(folder, words);
  INFO(done.out << done.err);
  CHECK(done.code == code);
  return json::parse(done.out);
}

std::vector<std::string> sources_of(const json& judgement) {
  std::vector<std::string> sources;
  for (const json& missing : judgement["not_assessed"]) sources.push_back(missing["source"]);
  return sources;
}

}  // namespace

TEST_CASE("a verdict names the trajectories judged and what was not assessed, and a pass says under which conditions") {
  const TemporaryFolder folder;
  prepare_runs(folder);
  const Words dated = {"reference.calibrated=2026-01-31", "reference.due=2199-01-31"};
  measure(folder, "loop.toml", "1", dated);
  measure(folder, "loop.toml", "2", dated);
  measure(folder, "random-reversal", "3", dated);
  Words changed = dated;
  changed.insert(changed.end(), {"simulation.mount_seed=4", "simulation.temperature_c=27", "simulation.age_months=1"});
  measure(folder, "loop.toml", "4", changed);

  CHECK(call(folder, {"fit", "1", "--held-out", "2", "--limits", "limits.toml"}).code == 0);
  const json random = answer(folder, {"fit", "1", "--held-out", "2", "3", "--limits", "limits.toml"}, 0)["judgement"];
  CHECK(random["overall"] == "pass");
  REQUIRE(random["trajectories"].size() == 2);
  CHECK(random["trajectories"][1]["run"] == 3);
  CHECK(random["trajectories"][1]["trajectory"] == "random reversals");
  CHECK(random["trajectories"][1]["inner_share"] > 0.5);
  CHECK(random["trajectories"][1]["other_dwell"] == true);  // 2 s beside 1 s
  CHECK(sources_of(random) == std::vector<std::string>{"re-mounting", "temperature", "time", "creep"});

  // A run of the sensor mounted anew, warmer and older is evidence for just that.
  const json wide = answer(folder, {"fit", "1", "--held-out", "3", "4", "--limits", "limits.toml"}, 0)["judgement"];
  CHECK(sources_of(wide) == std::vector<std::string>{"creep"});
  REQUIRE(call(folder, {"report", "1"}).code == 0);
  for (const char* run : {"1", "2", "3", "4"}) CHECK(call(folder, {"verify", run}).code == 0);
}

TEST_CASE("U of an error in one mount is no U of the sensor mounted anew or a month later, and the pass says so") {
  // The audit: 0.067 psi in the same mount, and the same sensor 0.690 psi re-mounted, 1.076 psi after a month.
  const TemporaryFolder folder;
  prepare_runs(folder);
  write_file(folder.path("limits.toml"),
             "schema = 1\nname = \"limits\"\nrule = \"default\"\nmean_compensation_error_psi = 0.6\n"
             "worst_taxel_error_psi = 60\ndistance_of_mean_percent_fs = 100\nunfit_taxels = 256\n");
  measure(folder, "production", "1");
  measure(folder, "production", "2");
  measure(folder, "production", "3", {"simulation.effects.remount_variation=0.03", "simulation.mount_seed=4"});
  measure(folder, "production", "4",
          {"simulation.age_months=1", "simulation.temperature_c=28", "simulation.effects.gain_drift_per_month=0.01",
           "simulation.effects.zero_drift_v_per_month=0.01"});
  // ELAM: the dynamic model's observer of the gain makes up for much of the month.
  const json same =
      answer(folder, {"fit", "1", "--model", "elam", "--held-out", "2", "--limits", "limits.toml"}, 0)["judgement"];
  CHECK(same["overall"] == "pass");
  const std::vector<std::string> missing = sources_of(same);
  for (const char* source : {"re-mounting", "time"}) CHECK(std::ranges::find(missing, source) != missing.end());
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
  const double value = of_run(verdicts, "2", "value"), expanded = of_run(figures, "2", "expanded");
  CHECK(expanded > 0.05);
  CHECK(expanded < 0.12);
  CHECK(of_run(verdicts, "3", "value") > value + 3.0 * expanded);
  CHECK(of_run(verdicts, "4", "value") > value + 6.0 * expanded);
  // Judged, too, they decide, and are no longer missing.
  CHECK(data["results"]["judgement"]["overall"] == "fail");
  const std::vector<std::string> still = sources_of(data["results"]["judgement"]);
  for (const char* source : {"re-mounting", "temperature", "time"})
    CHECK(std::ranges::find(still, source) == still.end());
  CHECK_FALSE(still.empty());  // no run tells the age of the reference's calibration
}
