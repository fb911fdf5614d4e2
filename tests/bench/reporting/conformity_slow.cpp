// Limits, decision rules and uncertainty as a person uses them: what the report prints is what the store gives.
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "analysis/identify/stored/model_document.h"
#include "analysis/judgement/measured_figures.h"
#include "analysis/statistics/uncertainty/uncertainty.h"
#include "tests/support/process.h"

using namespace tactbench;
using namespace tactbench::tests;
using nlohmann::json;

namespace {

void carry_out_run(const TemporaryFolder& folder) {
  REQUIRE(call(folder, {"init"}).code == 0);
  write_file(folder.path("three.toml"),
             "schema = 1\nname = \"three\"\nunit = \"psi\"\nturning_points = [0, 60, 20, 60, 0]\nstep = 10\n"
             "repeats = 3\ndwell_s = 1.0\n");
  REQUIRE(call(folder, {"sensors", "add", "S-1", "--type", "sensor.toml"}).code == 0);
  for (const char* seed : {"1", "2"})  // the second is judged
    REQUIRE(call(folder, {"run", "three.toml", "--bench", "bench.toml", "--sensor", "S-1", "--operator", "tester", "-q",
                          "--seed", seed})
                .code == 0);
  REQUIRE(call(folder, {"fit", "1", "-q"}).code == 0);
}

// Only the mean error is near its limit.
void write_limits(const TemporaryFolder& folder, const std::string& rule, double mean_error_psi) {
  write_file(folder.path("near.toml"),
             "schema = 1\nname = \"near\"\n" + (rule.empty() ? rule : "rule = \"" + rule + "\"\n") +
                 "mean_compensation_error_psi = " + std::to_string(mean_error_psi) +
                 "\nworst_taxel_error_psi = 60\ndistance_of_mean_percent_fs = 100\nunfit_taxels = 256\n");
}

// The runs, the models and the figures of the held-out one, read from the store.
struct FromStore {
  db::RunStore store;
  analysis::SensorModel fit;
  analysis::Dataset dataset, judged;
  analysis::Evaluation evaluation;
  explicit FromStore(const TemporaryFolder& folder)
      : store(db::RunStore::open_read_only(folder.path("runs.db"))),
        fit(analysis::load_fit(store, 1)),
        dataset(analysis::load_dataset(store, 1)),
        judged(analysis::load_dataset(store, 2)),
        evaluation(analysis::evaluate(judged, fit)) {}
};

}  // namespace

TEST_CASE("decision rules end with their exit codes, warn, are stored and verified") {
  const TemporaryFolder folder;
  carry_out_run(folder);
  const FromStore stored(folder);
  const analysis::Figure mean = analysis::measured_figures(stored.judged, stored.dataset, stored.fit, stored.evaluation,
                                                           analysis::reference_uncertainty(stored.store.run(2)))
                                    .front();
  REQUIRE(mean.u.expanded > 0.05);  // the certificate's U, and more
  const double value = stored.evaluation.mean_error_psi, half = 0.5 * mean.u.expanded;

  const auto judged_by = [&](const std::string& rule, double limit, int code, const std::string& word) {
    write_limits(folder, rule, limit);
    const Finished anew = call(folder, {"report", "1", "--held-out", "2", "--limits", "near.toml", "--json"});
    INFO(rule << " " << limit << "\n" << anew.out << anew.err);
    CHECK(anew.code == code);
    CHECK(json::parse(anew.out)["verdicts"][0]["verdict"] == word);
    return anew.err;
  };
  (void)judged_by("", value + half, 0, "conditional pass");
  (void)judged_by("default", value - half, 6, "conditional fail");
  judged_by("four-way", value - 3.0 * half, 1, "fail");
  judged_by("four-way", value + 3.0 * half, 0, "pass");
  judged_by("guarded", value + half, 1, "fail");
  CHECK(judged_by("simple", value + half, 0, "pass").find("warning") == std::string::npos);
  judged_by("report-only", value - 3.0 * half, 0, "report only");
  CHECK(stored.store.verdicts(2).empty());  // judged anew, not stored

  write_limits(folder, "four-way", value - half);
  const Finished fit = call(folder, {"fit", "1"}, {"judge", "1", "2", "--limits", "near.toml"});
  CHECK(fit.code == 6);
  CHECK(stored.store.verdicts(2).front().rule == "four-way");
  const Finished verify = call(folder, {"verify", "2"});
  INFO(verify.out << verify.err);
  CHECK(verify.code == 0);
  CHECK(call(folder, {"report", "1"}).code == 6);
  write_limits(folder, "report-only", value);
  CHECK(call(folder, {"fit", "1"}, {"judge", "1", "2", "--limits", "near.toml"}).code == 0);
  CHECK(stored.store.verdicts(2).size() == 4);  // what was found before stays
  write_limits(folder, "strict", value);
  const Finished wrong = call(folder, {"fit", "1"}, {"judge", "1", "2", "--limits", "near.toml"});
  CHECK(wrong.code == 2);
  CHECK_THAT(wrong.err, Catch::Contains("[TB-FILE-VALUE]") && Catch::Contains("near.toml:3"));
}

TEST_CASE("the report's uncertainty is the one recomputed from the store") {
  const TemporaryFolder folder;
  carry_out_run(folder);
  // 8 psi is no level of this run.
  REQUIRE(call(folder, {"fit", "1", "-q"}, {"judge", "1", "2", "--limits", "limits.toml", "-q"}).code == 6);
  REQUIRE(call(folder, {"report", "1", "-q", "--format", "json", "-o", "r.json"}).code == 6);
  const json data = json::parse(read_file(folder.path("r.json")))["sections"]["uncertainty"];
  const FromStore stored(folder);
  const analysis::Uncertainty uncertainty =
      analysis::assess_uncertainty(stored.dataset, stored.fit, stored.store.run(1));
  REQUIRE(data["reading"]["levels"].size() == uncertainty.levels.size());
  CHECK(uncertainty.levels.size() == 13);
  for (std::size_t i = 0; i < uncertainty.levels.size(); ++i) {
    const json& printed = data["reading"]["levels"][i];
    const analysis::LevelUncertainty& level = uncertainty.levels[i];
    CHECK(printed["not_linear"] == level.not_linear);
    for (const auto& [name, budget] : {std::pair("median", &level.median), std::pair("worst", &level.worst)}) {
      CHECK(printed[name]["taxel"] == budget->taxel);
      CHECK(printed[name]["combined_psi"] == budget->combined_psi);
      CHECK(printed[name]["factor"] == budget->factor);
      CHECK(printed[name]["expanded_psi"] == budget->expanded_psi);
      CHECK(printed[name]["error_psi"] == budget->error_psi);
    }
    for (std::size_t taxel = 0; taxel < 256; ++taxel)
      CHECK(printed["taxel_expanded_psi"][taxel].get<double>() == Approx(level.expanded_psi[taxel]).epsilon(6e-3));
  }
  CHECK(data["reading"]["reference"]["largest_u_psi"] == 0.025);
  const auto measured = analysis::measured_figures(stored.judged, stored.dataset, stored.fit, stored.evaluation,
                                                   analysis::reference_uncertainty(stored.store.run(2)));
  REQUIRE(data["judged_figures"].size() == stored.store.verdicts(2).size());
  REQUIRE(data["judged_figures"].size() > 4);
  for (std::size_t i = 0; i < 4; ++i) CHECK(data["judged_figures"][i]["expanded"] == measured[i].u.expanded);
}
