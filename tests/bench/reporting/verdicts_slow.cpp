// Which runs a verdict rests on, as a person meets it: held-out runs in any order, the models' own, void ones, what is
// stored, what is signed. On runs of the simulated rig, one store for each story.
#include <catch2/catch.hpp>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "db/run_store.h"
#include "tests/support/process.h"

using namespace tactbench::tests;
using nlohmann::json;

namespace {

using Words = std::vector<std::string>;

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
    Words words = {"run", "loop.toml", "--bench", "bench.toml", "--operator", "tester", "-q"};
    words.insert(words.end(), {"--sensor", sensor, "--seed", seed, "--sensor-seed", sensor == "S-1" ? "1" : "2"});
    words.insert(words.end(), more.begin(), more.end());
    const Finished run = call(words);
    INFO(run.err);
    REQUIRE(run.code == 0);
  }
  // Gains that moved by 15 % within a month: over any sensible limit.
  void measure_drifted(const std::string& sensor, const std::string& seed) const {
    measure(sensor, seed,
            {"--set", "simulation.age_months=1", "--set", "simulation.effects.gain_drift_per_month=0.15"});
  }

  json answer(Words words, int code) const {
    words.emplace_back("--json");
    const Finished finished = call(words);
    INFO(finished.out << finished.err);
    CHECK(finished.code == code);
    return json::parse(finished.out);
  }
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

Words joined(Words a, const Words& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

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
