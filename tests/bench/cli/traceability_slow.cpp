// Certificates and due dates as a person meets them: devices check, plan, run, fit, report, runs show, verify.
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "analysis/identify/stored/model_document.h"
#include "db/run_store.h"
#include "tests/support/run_recipe.h"
#include "tests/support/text.h"

using namespace tactbench;
using namespace tactbench::tests;
using nlohmann::json;

namespace {

void prepare_traced_run(const TemporaryFolder& folder) {
  begin_bench(folder, small_loop_text(10, 3));
  write_file(folder.path("far.toml"), limits_text("four-way", 50));
}

json report_json(const TemporaryFolder& folder, const std::vector<std::string>& words, int code) {
  well(call(folder, joined({"report", "--format", "json", "-o", "r.json"}, words)), code);
  return json::parse(read_file(folder.path("r.json")));
}

double expanded_mean_error(const json& report) {
  return report["sections"]["uncertainty"]["judged_figures"][0]["expanded"].get<double>();
}

}  // namespace

TEST_CASE(
    "traceability: overdue instruments give warnings, and a verdict that is stored as inconclusive and verified") {
  const TemporaryFolder folder;
  prepare_traced_run(folder);
  const std::vector<std::string> overdue = {"--set", "reference.due=2020-01-31"};
  const auto with = [&](std::vector<std::string> words) {
    words.insert(words.end(), overdue.begin(), overdue.end());
    return words;
  };
  well(call(folder, with({"devices", "check", "--bench", "bench.toml"})));
  CHECK(call(folder, with({"plan", "small.toml", "--bench", "bench.toml"})).code == 0);
  const json planned = json::parse(call(folder, with({"plan", "ring", "--bench", "bench.toml", "--json"})).out);
  CHECK(planned["instruments"].size() == 5);
  CHECK(planned["instruments"][0]["overdue"] == true);
  CHECK(planned["instruments"][4]["role"] == "force sensor");
  run_recipe(folder, "small.toml", overdue);
  CHECK_THAT(call(folder, {"runs", "show", "1"}).out, Catch::Contains("TB-CALIBRATION"));

  run_recipe(folder, "small.toml", overdue);
  CHECK(call(folder, {"fit", "1"}, {"judge", "1", "2", "--limits", "far.toml"}).code == 6);
  CHECK(call(folder, {"verify", "1"}).code == 0);
  CHECK(call(folder, {"verify", "2"}).code == 0);
  const json report = report_json(folder, {"1"}, 6);
  CHECK(report["results"]["verdicts"][0]["verdict"] == "inconclusive");
  CHECK(report["document"] == "Calibration report");
  REQUIRE(call(folder, {"report", "1"}).code == 6);

  // The same run in date: U is smaller, and the verdict a pass.
  for (int i = 0; i < 2; ++i) run_recipe(folder, "small.toml", {"--set", "reference.due=2199-01-31"});
  REQUIRE(call(folder, {"fit", "3"}, {"judge", "3", "4", "--limits", "far.toml"}).code == 0);
  CHECK(expanded_mean_error(report_json(folder, {"3"}, 0)) < expanded_mean_error(report));
}

TEST_CASE("traceability: the stored certificate precedes a laboratory file's, the earlier of both due dates counts") {
  const TemporaryFolder folder;
  prepare_traced_run(folder);
  for (int i = 0; i < 2; ++i) run_recipe(folder, "small.toml");
  REQUIRE(call(folder, {"fit", "1"}, {"judge", "1", "2", "--limits", "far.toml"}).code == 0);
  const json before = report_json(folder, {"1"}, 0);
  write_file(
      folder.path("lab.toml"),
      "schema = 1\n[[instrument]]\nserial = \"SIM-REF-1\"\ncertificate = \"PTB-30123-26\"\ndue = \"2020-01-31\"\n");
  const json after = report_json(folder, {"1", "--lab", "lab.toml"}, 6);
  CHECK(expanded_mean_error(after) > expanded_mean_error(before));
  const json& device = after["identification"]["run"]["devices"][2];
  const json& reference = after["sections"]["uncertainty"]["reading"]["reference"];
  CHECK(device["certificate"] == "SIM-CERT-1 (invented for the simulation)");
  CHECK(device["certificate"] == reference["certificate"]);
  CHECK(device["due"] == "2020-01-31");
  CHECK(device["due"] == reference["due"]);
  CHECK(reference["overdue"] == true);
  CHECK(device["remarks"].size() == 1);
  REQUIRE(call(folder, {"report", "1", "--lab", "lab.toml"}).code == 6);
  CHECK_THAT(read_file(folder.path("reports/run-1.html")), Catch::Contains("PTB-30123-26"));
  // fit sees the same dates, and what it found is kept.
  CHECK(call(folder, {"fit", "1"}, {"judge", "1", "2", "--limits", "far.toml", "--lab", "lab.toml"}).code == 6);
  CHECK(report_json(folder, {"1"}, 6)["results"]["verdicts"][0]["verdict"] == "inconclusive");
  CHECK(call(folder, {"verify", "1"}).code == 0);
  CHECK(call(folder, {"verify", "2"}).code == 0);
  CHECK(call(folder, {"fit", "1", "--lab", "lab.toml"}).code == 2);  // nothing would be judged by it
  write_file(folder.path("lab.toml"), "schema = 1\n[[instrument]]\nserial = \"SIM-REF-1\"\ndue = \"soon\"\n");
  const Finished odd = call(folder, {"report", "1", "--lab", "lab.toml"});
  CHECK(odd.code == 2);
  CHECK_THAT(odd.err, Catch::Contains("lab.toml:4"));
}

TEST_CASE("traceability: the report of a ring press is a test report, and states the traceability of its forces") {
  const TemporaryFolder folder;
  prepare_traced_run(folder);
  run_recipe(folder, "small.toml");
  REQUIRE(call(folder, {"fit", "1"}).code == 0);
  run_recipe(folder, "ring", {"--set", "recipe.repeats=1"});
  run_recipe(folder, "ring", {"--set", "recipe.repeats=1", "--set", "force.certificate="});
  const json traced = report_json(folder, {"2", "--model", "1"}, 0);
  CHECK(traced["document"] == "Test report");
  const json& force = traced["identification"]["traceability"][0];
  CHECK(force["quantity"] == "force");
  CHECK(force["traceable"] == true);
  CHECK_THAT(force["statement"].get<std::string>(),
             Catch::Contains("serial SIM-FT-1") && Catch::Contains("SIM-CERT-2") && Catch::Contains("U 0.05 N"));
  const json untraced = report_json(folder, {"3", "--model", "1"}, 0);
  CHECK_THAT(untraced["identification"]["traceability"][0]["statement"].get<std::string>(),
             Catch::Contains("Force not traceable"));
  REQUIRE(call(folder, {"report", "3", "--model", "1"}).code == 0);
  // As a study of a chamber run, the statement stands with its forces.
  const json study = report_json(folder, {"1", "--studies", "3"}, 0);
  CHECK_THAT(study["sections"]["objects"][0]["force_traceability"].get<std::string>(),
             Catch::Contains("Force not traceable"));
  CHECK(study["document"] == "Test report");  // U of no kind of history was counted
  const json exported = [&] {
    REQUIRE(call(folder, {"runs", "export", "2", "--format", "json", "-o", "e.json"}).code == 0);
    return json::parse(read_file(folder.path("e.json")));
  }();
  const auto sensor = std::find_if(exported["devices"].begin(), exported["devices"].end(),
                                   [](const json& device) { return device["role"] == "force sensor"; });
  REQUIRE(sensor != exported["devices"].end());
  CHECK((*sensor)["serial"] == "SIM-FT-1");
  CHECK((*sensor)["certificate"] == "SIM-CERT-2 (invented for the simulation)");
  CHECK((*sensor)["calibration"]["range_n"][2] == 35.0);
}

TEST_CASE("traceability: verify rejects a stored pass that rests on an overdue reference") {
  const TemporaryFolder folder;
  prepare_traced_run(folder);
  for (const char* seed : {"1", "2"})
    run_recipe(folder, "small.toml", {"--set", "reference.due=2020-01-31", "--seed", seed});
  REQUIRE(call(folder, {"fit", "1", "--model", "elam"}, {"judge", "1", "2", "--limits", "far.toml"}).code == 6);
  REQUIRE(call(folder, {"verify", "2"}).code == 0);
  {
    db::RunStore store = db::RunStore::open(folder.path("runs.db"));
    std::vector<db::VerdictRecord> verdicts = store.verdicts(2);
    for (db::VerdictRecord& verdict : verdicts) verdict.verdict = "pass";
    store.replace_verdicts(2, store.default_fit(1)->fit, verdicts);
  }
  CHECK(call(folder, {"verify", "2"}).code == 1);
  (void)report_json(folder, {"1"}, 6);  // no pass is printed
}

TEST_CASE("traceability: pressures beyond the certificate give warnings, no pass, and no U in the report") {
  const TemporaryFolder folder;
  prepare_traced_run(folder);
  const std::vector<std::vector<std::string>> ranges = {
      {"--set", "reference.certificate_range_psi=[0, 40]"},
      {"--set", "reference.correction.reading_psi=[0, 20, 40]", "--set",
       "reference.correction.correction_psi=[0, 0, 0]", "--set",
       "reference.correction.expanded_uncertainty_psi=[0.05, 0.05, 0.05]"}};
  std::int64_t run = 1;
  for (const std::vector<std::string>& range : ranges) {
    CAPTURE(run);
    const Finished plan =
        call(folder, joined({"plan", "small.toml", "--bench", "bench.toml", "--units", "psi"}, range));
    CHECK(plan.code == 0);
    CHECK_THAT(plan.err, Catch::Contains("0 to 40 psi") && Catch::Contains("60 psi"));
    for (int i = 0; i < 2; ++i) run_recipe(folder, "small.toml", range);
    const std::string models = std::to_string(run), judged = std::to_string(run + 1);
    CHECK_THAT(call(folder, {"runs", "show", models}).out, Catch::Contains("TB-CALIBRATION"));
    CHECK(call(folder, {"fit", models}, {"judge", models, judged, "--limits", "far.toml"}).code == 6);
    const json report = report_json(folder, {models}, 6);
    for (const json& verdict : report["results"]["verdicts"])
      CHECK((verdict["verdict"] == "inconclusive") == (verdict["unit"] == "psi"));
    CHECK(report["identification"]["traceability"][0]["traceable"] == false);
    for (const json& level : report["sections"]["uncertainty"]["reading"]["levels"])
      CHECK(level["pressure_psi"] <= 40.0);
    CHECK(call(folder, {"verify", models}).code == 0);
    CHECK(call(folder, {"verify", judged}).code == 0);
    run += 2;
  }
  const std::vector<std::string> whole = {"--set", "reference.certificate_range_psi=[0, 60]"};
  CHECK_THAT(call(folder, joined({"plan", "small.toml", "--bench", "bench.toml"}, whole)).err,
             !Catch::Contains("warning"));
}

TEST_CASE("traceability: FILL-IN in the bench file of a hardware bench keeps every device closed") {
  const TemporaryFolder folder;
  REQUIRE(call(folder, {"init", "--rig"}).code == 0);
  REQUIRE(call(folder, {"sensors", "add", "S-1", "--type", "sensor.toml"}).code == 0);
  const auto refused = [&](const std::vector<std::string>& words) {
    const Finished finished = call(folder, words);
    check_refusal(finished, 2, "TB-BENCH-FILL-IN");
    CHECK_THAT(finished.err, Catch::Contains("reference.certificate"));
  };
  refused({"run", "production", "--bench", "bench.toml", "--sensor", "S-1", "--operator", "me"});
  refused({"devices", "check", "--bench", "bench.toml"});
  CHECK(json::parse(call(folder, {"runs", "list", "--json"}).out)["runs"].empty());
  const Finished plan = call(folder, {"plan", "production", "--bench", "bench.toml"});
  CHECK(plan.code == 0);  // touches nothing
  CHECK(call(folder, {"config", "--bench", "bench.toml"}).code == 0);
}
