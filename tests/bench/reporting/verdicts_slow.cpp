// Which runs a verdict rests on, as a person meets it: held-out runs in any order, the models' own, void ones, what is
// stored, what is signed. On runs of the simulated rig, one store for each story.

#include <fmt/format.h>
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numbers>

#include "analysis/identify/stored/model_document.h"
#include "analysis/judgement/figure.h"
#include "analysis/statistics/figures/levels.h"
#include "analysis/statistics/uncertainty/uncertainty.h"
#include "bench/reporting/evaluation.h"
#include "bench/run/recipe_check.h"
#include "db/run_store.h"
#include "tests/bench/run/quick_store.h"
#include "tests/benchmarks/study/simulated_run.h"
#include "tests/support/process.h"
#include "tests/support/run_recipe.h"
#include "tests/support/small_run.h"
#include "tests/support/text.h"

using namespace tactbench;
using namespace tactbench::analysis;
using namespace tactbench::tests;
using bench::KnownRun;
using nlohmann::json;

namespace {

using Words = std::vector<std::string>;

json answer(const TemporaryFolder& folder, const Words& words, int code) {
  const Finished done = call(folder, joined(words, {"--json"}));
  INFO(done.out << done.err);
  CHECK(done.code == code);
  return json::parse(done.out);
}

class VerdictBench {
 public:
  VerdictBench() {
    REQUIRE(call({"init"}).code == 0);
    write_file(folder_.path("loop.toml"),
               "schema = 1\nname = \"loop\"\nunit = \"psi\"\nturning_points = [0, 60, 20, 60, 0]\nstep = 10\n"
               "repeats = 1\ndwell_s = 1.0\n");
    write_limits("limits-a.toml", 1.0);
    write_limits("limits-b.toml", 50.0);
    for (const char* sensor : {"S-1", "S-2"})
      REQUIRE(call({"sensors", "add", sensor, "--type", "sensor.toml"}).code == 0);
  }

  Finished call(const Words& words) const { return tactbench::tests::call(folder_, words); }
  Finished call(const Words& first, const Words& second) const {
    return tactbench::tests::call(folder_, first, second);
  }
  [[nodiscard]] std::string path(const std::string& name) const { return folder_.path(name); }
  [[nodiscard]] std::string text(const std::string& name) const { return read_file(folder_.path(name)); }

  void measure(const std::string& sensor, const std::string& seed, const Words& more = {}) const {
    const Finished run = call(joined({"run", "loop.toml", "--bench", "bench.toml", "--operator", "tester", "-q",
                                      "--sensor", sensor, "--seed", seed, "--sensor-seed", sensor == "S-1" ? "1" : "2"},
                                     more));
    INFO(run.err);
    REQUIRE(run.code == 0);
  }
  // Gains that moved by 15 % within a month: over any sensible limit.
  void measure_drifted(const std::string& sensor, const std::string& seed) const {
    measure(sensor, seed,
            {"--set", "simulation.age_months=1", "--set", "simulation.effects.gain_drift_per_month=0.15"});
  }

  json answer(const Words& words, int code) const { return ::answer(folder_, words, code); }
  void refused(const Words& words, const std::string& id) const {
    const Finished finished = call(words);
    INFO(words.at(0) << " " << words.at(1) << "\n" << finished.out << finished.err);
    CHECK(finished.code == 2);
    CHECK_THAT(finished.err,
               Catch::Contains("[" + id + "]") && Catch::Contains("\n  at: ") && Catch::Contains("\n  try: "));
  }
  // The row of the run in `runs list`.
  std::string listed(int run) const {
    const json document = answer({"runs", "list", "--all"}, 0);
    for (const json& row : document["runs"])
      if (row["run"] == run) return row["verdict"];
    return {};
  }

 private:
  void write_limits(const std::string& name, double mean_error_psi) const {
    write_file(folder_.path(name), "schema = 1\nname = \"" + name + "\"\nrule = \"simple\"\n" +
                                       "mean_compensation_error_psi = " + std::to_string(mean_error_psi) +
                                       "\nworst_taxel_error_psi = 60\ndistance_of_mean_percent_fs = 100\n"
                                       "unfit_taxels = 256\n");
  }
  TemporaryFolder folder_;
};

}  // namespace

TEST_CASE("verdicts: every held-out run is judged, the worst decides, and it is stored with the fit") {
  const VerdictBench bench;
  bench.measure("S-1", "1");
  bench.measure("S-1", "2");
  bench.measure("S-1", "3");
  bench.measure_drifted("S-1", "4");

  // Without a verdict nobody signs unasked; the draft of that moment is no signed report.
  REQUIRE(bench.call({"fit", "1"}).code == 0);
  REQUIRE(bench.call({"report", "1"}).code == 0);
  bench.refused({"report", "sign", "1", "--by", "C. Chief"}, "TB-REPORT-NO-VERDICT");
  const json bare = bench.answer({"report", "sign", "1", "--by", "C. Chief", "--without-verdict"}, 0);
  const std::string bare_path = bare["path"];
  CHECK_THAT(bare_path, Catch::EndsWith("run-" + bare["number"].get<std::string>() + ".html"));
  const std::string bare_page = bench.text(bare_path);

  CHECK(bench.call({"verify", "1"}).code == 0);

  // In any order of arguments, judged again and stored.
  for (const Words& order : {Words{"2", "3", "4"}, Words{"4", "2", "3"}}) {
    INFO(order[0] << " " << order[1] << " " << order[2]);
    const json report = bench.answer(joined({"report", "1", "--limits", "limits-a.toml", "--held-out"}, order), 1);
    CHECK(report["judgement"]["overall"] == "fail");
    CHECK(report["judgement"]["decided_by"] == json::array({4}));
    CHECK(report["judgement"]["runs"].size() == 3);
    CHECK(report["verdicts"].size() == 12);
    const json fit = bench.answer(joined({"judge", "1", "--limits", "limits-a.toml"}, order), 1);
    CHECK(fit["judgement"]["decided_by"] == json::array({4}));
  }

  // A plain report takes the runs that the fit was judged on; so do the lists.
  CHECK(bench.call({"report", "1"}).code == 1);
  CHECK(bench.listed(1) == "simulated fail");
  CHECK(bench.listed(2) == "simulated pass");
  CHECK(bench.listed(4) == "simulated fail");
  for (const char* run : {"1", "2", "3", "4"}) CHECK(bench.call({"verify", run}).code == 0);

  // Other runs or other limits do not hide a stored fail; other limits are reported with it.
  const json picked = bench.answer({"report", "1", "--held-out", "2"}, 1);
  CHECK(picked["judgement"]["overall"] == "fail");
  CHECK(picked["judgement"]["stored_worse"][0]["run"] == 4);
  CHECK(bench.call({"report", "1", "--held-out", "2", "3", "4", "--limits", "limits-b.toml", "-o", "both.html"}).code ==
        1);
  CHECK(bench.call({"fit", "1"}, {"judge", "1", "2", "3", "4", "--limits", "limits-b.toml"}).code == 1);
  CHECK(bench.listed(1) == "simulated fail");
  CHECK(bench.listed(4) == "simulated fail");
  CHECK(bench.call({"verify", "4"}).code == 0);

  // A signature under a fail says so; no signed file is written over, whatever it is called.
  CHECK(bench.call({"report", "sign", "1", "--by", "C. Chief", "--reason", "judged by other limits"}).code == 1);
  CHECK(bench.text(bare_path) == bare_page);
  bench.refused({"report", "1", "-o", bare_path}, "TB-REPORT-SIGNED");
  std::filesystem::copy_file(bench.path(bare_path), bench.path("renamed.txt"));
  bench.refused({"report", "1", "-o", "renamed.txt"}, "TB-REPORT-SIGNED");
  CHECK(bench.text("renamed.txt") == bare_page);
  write_file(bench.path("issued.pdf"), "%PDF-1.4 /Title (Calibration report " + bare["number"].get<std::string>() +
                                           ", signed)");  // as chromium writes it
  bench.refused({"report", "1", "--format", "pdf", "-o", "issued.pdf"}, "TB-REPORT-SIGNED");
  const json again = bench.answer({"report", "1"}, 1);  // unchanged since it was signed
  CHECK(again["written"] == false);
  CHECK(again["path"].get<std::string>() != bare_path);
}

TEST_CASE("verdicts: void runs, runs of the models and runs named twice are rejected by every verb") {
  const VerdictBench bench;
  bench.measure("S-1", "1");
  bench.measure("S-1", "2");
  bench.measure("S-1", "3");
  bench.measure("S-2", "5");
  bench.measure("S-2", "6");
  REQUIRE(bench.call({"fit", "1"}).code == 0);
  // Runs that do not match the model: nothing is stored.
  bench.refused({"judge", "1", "1"}, "TB-RUN-OWN");
  bench.refused({"judge", "1", "2", "2"}, "TB-RUN-TWICE");
  CHECK(bench.call({"judge", "1", "5", "--limits", "limits-a.toml"}).code == 6);  // another sensor
  CHECK(tactbench::db::RunStore::open_read_only(bench.path("runs.db")).verdicts_of_models(1).empty());
  REQUIRE(bench.call({"judge", "1", "2", "--limits", "limits-a.toml"}).code == 0);
  REQUIRE(bench.call({"fit", "3"}).code == 0);
  REQUIRE(bench.call({"fit", "4"}, {"judge", "4", "5", "--limits", "limits-a.toml"}).code == 0);

  bench.refused({"fit", "1", "--model", "monotone", "--score", "1"}, "TB-RUN-OWN");
  bench.refused({"fit", "1", "--model", "monotone", "--score", "2,02"}, "TB-RUN-TWICE");
  bench.refused({"report", "1", "--held-out", "1"}, "TB-RUN-OWN");
  bench.refused({"report", "1", "--held-out", "3", "2", "3"}, "TB-RUN-TWICE");
  bench.refused({"report", "2", "--model", "1", "--held-out", "1"}, "TB-RUN-OWN");
  bench.refused({"report", "2", "--model", "1", "--held-out", "2"}, "TB-RUN-TWICE");
  bench.refused({"report", "2", "--model", "1", "--studies", "1:mount"}, "TB-RUN-OWN");
  bench.refused({"report", "1", "--studies", "3:mount", "3:90"}, "TB-RUN-TWICE");
  CHECK(bench.call({"report", "1", "--held-out", "5"}).code == 6);

  // A run that is void after it was judged: the evidence is no longer valid, and a new report says why.
  REQUIRE(bench.call({"runs", "void", "2", "--reason", "gauge closed", "--by", "me"}).code == 0);
  CHECK(bench.call({"report", "1"}).code == 6);
  CHECK(bench.listed(1) == "-");
  CHECK(bench.listed(2) == "-");

  REQUIRE(bench.call({"runs", "void", "3", "--reason", "door open", "--by", "me"}).code == 0);
  for (const Words& words :
       {Words{"fit", "3"}, Words{"fit", "3", "--model", "monotone"}, Words{"judge", "1", "2"},
        Words{"fit", "1", "--model", "monotone", "--score", "2"}, Words{"model", "check", "1", "2"},
        Words{"report", "1", "--held-out", "2"}, Words{"report", "1", "--studies", "2:mount"},
        Words{"report", "1", "2"}, Words{"report", "1", "--previous", "3"}, Words{"report", "1", "--model", "3"},
        Words{"report", "--batch", "1", "3"}, Words{"report", "--compare", "1", "3"}, Words{"model", "show", "3"},
        Words{"model", "diff", "1", "3"}, Words{"model", "export", "3", "-o", "m.json"},
        Words{"live", "--bench", "bench.toml", "--model", "3"}, Words{"predict", "3", "none.csv"},
        Words{"trend", "accept", "3", "--by", "me", "--reason", "as made"}})
    bench.refused(words, "TB-RUN-VOID");

  // On request they count, and page, JSON and text say so with the verdict.
  const json counted =
      bench.answer({"report", "1", "--held-out", "2", "--limits", "limits-a.toml", "--void-too", "-o", "x.html"}, 0);
  CHECK(counted["judgement"]["void_runs"][0]["run"] == 2);
  CHECK(counted["judgement"]["void_runs"][0]["reason"] == "gauge closed");
  CHECK(bench.call({"model", "show", "3", "--void-too"}).code == 0);

  // A void run's own report shows it, large.
  CHECK(bench.call({"report", "3"}).code == 0);
  CHECK(bench.answer({"trend", "--sensor", "S-1"}, 0)["subjects"][0]["figures"][0]["runs"] == json::array({1}));

  // The verdict of a fit is in the row of its models; one row per sensor.
  bench.measure_drifted("S-2", "7");
  REQUIRE(bench.call({"fit", "4"}, {"judge", "4", "6", "--limits", "limits-a.toml"}).code == 1);
  REQUIRE(bench.call({"runs", "void", "1", "--reason", "again", "--by", "me"}).code == 0);
  bench.measure("S-1", "8");
  bench.measure("S-1", "9");
  REQUIRE(bench.call({"fit", "7"}, {"judge", "7", "8", "--limits", "limits-a.toml"}).code == 0);
  REQUIRE(bench.call({"report", "--batch", "4", "5", "7", "8", "-o", "batch.html"}).code == 1);
}

// Under which conditions a verdict holds: on runs of the simulated rig whose mount, age and temperature are known.

namespace {

bool leaves_open(const json& judgement, const std::string& source) {
  return std::ranges::any_of(judgement["not_assessed"], [&](const json& own) { return own["source"] == source; });
}

}  // namespace

TEST_CASE("conditions: U of one mount does not cover a re-mount or a month later, and the pass states that") {
  // The audit: 0.067 psi in the same mount, and the same sensor 0.690 psi re-mounted, 1.076 psi after a month.
  const TemporaryFolder folder;
  init_bench(folder);
  write_file(folder.path("limits.toml"),
             "schema = 1\nname = \"limits\"\nrule = \"default\"\nmean_compensation_error_psi = 0.5\n"
             "worst_taxel_error_psi = 60\ndistance_of_mean_percent_fs = 100\nunfit_taxels = 256\n");
  const std::vector<Words> runs = {
      {},
      {},
      {"--set", "simulation.effects.remount_variation=0.03", "--set", "simulation.mount_seed=4"},
      {"--set", "simulation.age_months=1", "--set", "simulation.temperature_c=28", "--set",
       "simulation.effects.gain_drift_per_month=0.01", "--set", "simulation.effects.zero_drift_v_per_month=0.01"}};
  for (std::size_t i = 0; i < runs.size(); ++i)
    run_recipe(folder, "loops",
               joined(runs[i], {"--seed", std::to_string(i + 1), "--set", "recipe.dwell_s=1", "--set",
                                "recipe.turning_points=[0, 60, 0, 40, 0, 60, 20, 60, 0]"}));
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
  CHECK_FALSE(judgement["not_assessed"].empty());  // no run shows the age of the reference's calibration
  for (const char* run : {"1", "2", "3", "4"}) CHECK(call(folder, {"verify", run}).code == 0);
}

// Limits, decision rules and uncertainty as a person uses them: what the report prints is what the store gives.

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

TEST_CASE("decision rules: give their exit codes and warnings, and are stored and verified") {
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
  CHECK(stored.store.verdicts(2).empty());  // judged again, not stored

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

TEST_CASE("report: its uncertainty equals the one recomputed from the store") {
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

// An error of the input that reads the reference, seen in corrected readings: U of a calibration holds the plant's
// pressure with the input's row, and not without it. On benches and a sensor that nothing was chosen on.

namespace {

// Share of the readings of full sweeps within U of the chamber's pressure.
double share_held(const KnownRun& run, const SensorModel& fit, const ConditionUncertainty& stated) {
  std::vector<std::vector<StepKind>> kinds;
  std::vector<std::vector<std::size_t>> first;
  std::size_t frames = 0;
  for (const SequenceData& sequence : run.data.sequences) {
    kinds.push_back(step_kinds(sequence, fit.pressure_psi.front(), fit.pressure_psi.back()));
    first.emplace_back();
    for (const Repeat& repeat : sequence.repeats) {
      first.back().push_back(frames);
      frames += repeat.steps.size();
    }
  }
  double within = 0.0, all = 0.0;
  compensate_in_order(run.data, fit, 1, [&](std::size_t taxel) {
    return [&, taxel](std::size_t s, std::size_t r, std::size_t i, const Compensated& now) {
      if (!kinds[s][i].full) return;
      const auto [known, expanded] = reading_uncertainty(stated, taxel, now.pressure_psi, kinds[s][i].up);
      within += std::abs(now.pressure_psi - known - run.chamber_psi[first[s][r] + i]) <= expanded ? 1.0 : 0.0;
      all += 1.0;
    };
  });
  return within / all;
}

}  // namespace

TEST_CASE("reference chain: a voltage input error is within U only if its limit is stated") {
  QuickStore store;
  double with = 0.0, without = 0.0;
  constexpr int kRigs = 4;
  for (int rig = 1; rig <= kRigs; ++rig) {
    const bench::SimulatedRun made = {
        {"descending"},
        {"recipe.repeats=2", "reference.certificate_covers=transducer", "reference.input_limit_v=0.06",
         fmt::format("simulation.instrument_seed={}", 2400 + rig)}};
    const bench::SimulatedSensor sensor{.seed = 2401};
    const auto run = [&](int seed) {
      return simulate_run(made, sensor, static_cast<unsigned>(10 * rig + seed), store);
    };
    const KnownRun calibration = run(1), held_out = run(2), again = run(3);
    const SensorModel fit = fit_array(calibration.data);
    UncertaintyInputs inputs;
    inputs.history.same = {&held_out.data};
    db::RunRecord record = store.run(calibration.data.run);
    const Uncertainty whole = assess_uncertainty(calibration.data, fit, record, inputs);
    const Budget& budget = whole.levels[whole.chosen].median;
    const auto row = std::ranges::find(budget.contributions, UncertaintySource::kReferenceInput, &Contribution::source);
    REQUIRE(row != budget.contributions.end());
    CHECK(row->width == Approx(0.6));
    for (db::DeviceRecord& device : record.devices) {
      auto document = nlohmann::json::parse(device.calibration_json);
      if (document.erase("input_limit_v") == 1) device.calibration_json = document.dump();
    }
    const Uncertainty lacking = assess_uncertainty(calibration.data, fit, record, inputs);
    with += share_held(again, fit, whole.condition(UseCondition::kFullSweeps)) / kRigs;
    without += share_held(again, fit, lacking.condition(UseCondition::kFullSweeps)) / kRigs;
  }
  CAPTURE(with, without);
  CHECK(with >= 0.93);
  CHECK(without < 0.85);
}

// A chamber that presses one edge more than the other: four runs of one sensor turned in it tell its map from the
// sensor's, as the report takes them apart.

namespace {

constexpr double kTilt = 0.04, kTiltDeg = 30.0;

// Right and up from the array's centre, of its side.
double right_of(int taxel) { return (taxel % 16 - 7.5) / 15.0; }
double up_of(int taxel) { return (7.5 - taxel / 16) / 15.0; }  // NOLINT(bugprone-integer-division): rows are whole

double planted_share(double tilt, int cell) {
  const double angle = kTiltDeg * std::numbers::pi / 180.0;
  return tilt * (right_of(cell) * std::cos(angle) + up_of(cell) * std::sin(angle));
}

// Four characterizations at the report's angles and the report's study of them.
analysis::ReportInput turned_runs(double tilt) {
  QuickStore store;
  for (int turn = 0; turn < 4; ++turn) {
    bench::RunRequest request = small_request({{"simulation.effects.chamber_tilt", std::to_string(tilt)},
                                               {"simulation.effects.chamber_tilt_deg", std::to_string(kTiltDeg)},
                                               {"simulation.turned_in_chamber_deg", std::to_string(90 * turn)}},
                                              {static_cast<std::uint64_t>(turn) + 1, 5});
    request.recipes = bench::read_recipes({"descending"}, {{"repeats", "1"}});
    request.check_seating = true;
    const bench::RunResult result = run_small(request, store);
    INFO((result.error ? result.error->what() : ""));
    REQUIRE(!result.error);
  }
  analysis::Runs runs(store);
  const analysis::SensorModel fit = bench::fit_run(store, runs.dataset(1));
  bench::ReportExtras extras;
  extras.studies = {"2:90", "3:180", "4:270"};
  return bench::report_input(runs, 1, fit, bench::evaluate_runs(runs, fit, {}), {}, {}, &extras);
}

// The plane through a map: relative pressure difference over the array's side along both axes.
struct Plane {
  double right = 0.0, up = 0.0;
};
Plane plane_through(const std::vector<double>& shares) {
  Plane plane;
  double squares = 0.0;
  for (int cell = 0; cell < 256; ++cell) {
    plane.right += shares[static_cast<std::size_t>(cell)] * right_of(cell);
    plane.up += shares[static_cast<std::size_t>(cell)] * up_of(cell);
    squares += right_of(cell) * right_of(cell);
  }
  return {plane.right / squares, plane.up / squares};
}

// Standard uncertainty of one cell's share: the residual that the report states, through the slope over its levels.
// A cell's value is the mean of four equations less that of its set of four: 3/4 of one equation's variance over 4.
double u_of_cell(const analysis::Uniformity& u) {
  double mean = 0.0, spread = 0.0;
  for (const double p : u.pressure_psi) mean += p / static_cast<double>(u.pressure_psi.size());
  for (const double p : u.pressure_psi) spread += (p - mean) * (p - mean);
  return u.residual_rms_psi * std::sqrt(0.75 / 4.0 / spread);
}

double rms_of(const std::vector<double>& values) {
  double squares = 0.0;
  for (const double value : values) squares += value * value;
  return std::sqrt(squares / static_cast<double>(values.size()));
}

}  // namespace

TEST_CASE("chamber uniformity: turning the sensor reveals the tilt of a chamber, and shows none if there is none") {
  const analysis::ReportInput tilted_input = turned_runs(kTilt), level_input = turned_runs(0.0);
  const analysis::Uniformity &tilted = tilted_input.more.studies.uniformity,
                             &level = level_input.more.studies.uniformity;
  REQUIRE(tilted.assessed());
  REQUIRE(level.assessed());
  const double u_cell = u_of_cell(tilted), u_level = u_of_cell(level);
  const Plane found = plane_through(tilted.chamber_share), none = plane_through(level.chamber_share);
  std::vector<double> off_chamber, planted, off_sensor;
  for (int cell = 0; cell < 256; ++cell) {
    const auto at = static_cast<std::size_t>(cell);
    planted.push_back(planted_share(kTilt, cell));
    off_chamber.push_back(tilted.chamber_share[at] - planted.back());
    // The models were made at 0 degrees under the tilt: what they took for the taxel's own is their error.
    off_sensor.push_back(tilted.sensor_share[at] + planted.back() - level.sensor_share[at]);
  }
  const double right = kTilt * std::cos(kTiltDeg * std::numbers::pi / 180.0);
  const double up = kTilt * std::sin(kTiltDeg * std::numbers::pi / 180.0);
  CAPTURE(u_cell, u_level, tilted.u_share, level.u_share, tilted.residual_rms_psi, level.residual_rms_psi);
  // Errors of models are not independent from taxel to taxel: of many cells the plane is no better known than one.
  CHECK(found.right == Approx(right).margin(2.0 * u_cell));
  CHECK(found.up == Approx(up).margin(2.0 * u_cell));
  CHECK(none.right == Approx(0.0).margin(2.0 * u_level));
  CHECK(none.up == Approx(0.0).margin(2.0 * u_level));
  CHECK(2.0 * u_cell < 0.05 * kTilt);
  CHECK(rms_of(off_chamber) < 3.0 * u_cell);
  CHECK(rms_of(off_sensor) < 3.0 * u_cell);
  // Contributions to the uncertainty of a reading.
  CHECK(tilted.u_share == Approx(rms_of(planted)).epsilon(0.05));
  CHECK(level.u_share < 0.1 * tilted.u_share);
  CHECK(tilted.residual_rms_psi < 1.5 * level.residual_rms_psi);
  CHECK(tilted.residual_other_sense_psi > 5.0 * tilted.residual_rms_psi);
  CHECK(tilted.pressure_psi.back() < 60.0);
  CHECK_FALSE(analysis::render_report(tilted_input).html.empty());
}
