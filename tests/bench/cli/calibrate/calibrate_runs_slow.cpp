// `calibrate` on the simulated rig with a recipe of seconds: each stage's line, what its runs are told, and the words
// that carry on after each stage that can fail.
#include <catch2/catch.hpp>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/support/process.h"

using namespace tactbench::tests;

namespace {

using CalibrateWords = std::vector<std::string>;

struct CalibrationFolder {
  CalibrationFolder() {
    REQUIRE(call(folder, {"init", "--operator", "tester"}).code == 0);
    std::filesystem::remove(folder.path("sensor.toml"));  // the shipped one serves
    const std::string recipe =
        "schema = 1\nname = \"small\"\nunit = \"psi\"\nturning_points = [0, 60, 20, 60, 0]\nstep = 10\nrepeats = 1\n";
    write_file(folder.path("a.toml"), recipe + "dwell_s = 1.0\n");
    write_file(folder.path("b.toml"), recipe + "dwell_s = 1.5\n");
    const std::string limits =
        "mean_compensation_error_psi = 60\nworst_taxel_error_psi = 60\ndistance_of_mean_percent_fs = 100\nunfit_taxels "
        "= 256\n";
    write_file(folder.path("wide.toml"), "schema = 1\nname = \"wide\"\nrule = \"simple\"\n" + limits);
    write_file(folder.path("only.toml"), "schema = 1\nname = \"only\"\nrule = \"report-only\"\n" + limits);
  }
  Finished calibrate(const CalibrateWords& more, const std::string& limits = "./wide.toml") const {
    CalibrateWords words = {"calibrate", "MY-1",     "--recipe", "./a.toml", "--held-out-recipe",
                            "./b.toml",  "--limits", limits,     "--model",  "elam"};
    words.insert(words.end(), more.begin(), more.end());
    return call(folder, words);
  }
  nlohmann::json told(const CalibrateWords& words) const { return nlohmann::json::parse(call(folder, words).out); }
  TemporaryFolder folder;
};

// The lines of a text that begin with `head`, without it.
std::string line_of(const std::string& text, const std::string& head) {
  const std::size_t at = ("\n" + text).find("\n" + head);
  if (at == std::string::npos) return "no such line";
  return text.substr(at + head.size(), text.find('\n', at) - at - head.size());
}

const std::string kAgain =
    "tactbench calibrate MY-1 --recipe ./a.toml --held-out-recipe ./b.toml --limits ./wide.toml --model elam";

}  // namespace

TEST_CASE("calibrate: each stage has its line, and both runs are told the operator's words, the second another seed") {
  const CalibrationFolder of;
  const Finished done = of.calibrate({"--no-seating", "--lot", "A7", "--order", "55", "--meta", "film=B12", "--seed",
                                      "40", "--sensor-seed", "8", "--set", "recipe.step=20", "--set",
                                      "simulation.temperature_c=24", "--on-event", "echo $TACTBENCH_EVENT >> events"});
  INFO(done.err << done.out);
  REQUIRE(done.code == 0);
  CHECK(
      done.out.starts_with("SIMULATED DATA: bench 'simulated-rig' measures no real sensor\n1/5 sensor    MY-1 (PCB "
                           "piezoresistive 16x16) is new, registered in runs.db\n2/5 measure   ./a.toml: run 1: "
                           "completed, "));
  const nlohmann::json first = of.told({"runs", "show", "1", "--json"}),
                       second = of.told({"runs", "show", "2", "--json"});
  const nlohmann::json fits = of.told({"model", "list", "--json"}).at("models");
  REQUIRE(fits.size() == 1);
  CHECK(fits.at(0).at("run") == 1);
  CHECK(fits.at(0).at("kind") == "elam");
  CHECK_THAT(
      line_of(done.out, "2/5 measure   "),
      Catch::StartsWith("./a.toml: run 1: completed, " + std::to_string(first.at("frames").get<int>()) + " frames"));
  CHECK_THAT(
      line_of(done.out, "3/5 held out  "),
      Catch::StartsWith("./b.toml: run 2: completed, " + std::to_string(second.at("frames").get<int>()) + " frames"));
  CHECK_THAT(line_of(done.out, "4/5 fit       "),
             Catch::StartsWith("elam on run 1: 256 of 256 taxels fitted; on run 2 "));
  const nlohmann::json report = of.told({"report", "1", "--json"});
  CHECK(line_of(done.out, "5/5 report    ") == report.at("number").get<std::string>() + ": reports/run-1.html");
  CHECK_THAT(done.out, Catch::Contains("\nSIMULATED  ####   ###   ####  ####\n") &&
                           Catch::Contains("\nsensor MY-1: simulated pass, under repeatability conditions only: all 4 "
                                           "requirements of 'wide' pass on held-out run 2\n") &&
                           Catch::EndsWith("\nbad taxels: none\n"));
  CHECK_THAT(done.err, Catch::Contains("measure: ") && Catch::Contains("held out: "));
  for (const nlohmann::json* run : {&first, &second}) {
    INFO(*run);
    CHECK(run->at("operator") == "tester");
    CHECK(run->at("sensor") == "MY-1");
    CHECK(run->at("bench") == "simulated-rig");
    CHECK(run->at("sensor_seed") == 8);
    CHECK(run->at("metadata") == nlohmann::json{{"film", "B12"}, {"lot", "A7"}, {"order", "55"}});
    CHECK_THAT(run->dump(), Catch::Contains("left out as asked (--no-seating)"));
  }
  CHECK(first.at("purpose") == "calibrate: measured for the models");
  CHECK(second.at("purpose") == "calibrate: held out, to judge the models of run 1");
  CHECK((first.at("seed") == 40 && second.at("seed") == 41));
  CHECK(first.at("overrides") == nlohmann::json::parse(R"([{"key": "recipe.step", "value": "20"},
                                                 {"key": "simulation.temperature_c", "value": "24"}])"));
  CHECK(second.at("overrides") == nlohmann::json::parse(R"([{"key": "simulation.temperature_c", "value": "24"}])"));
  CHECK(read_file(of.folder.path("events")) == "done\ndone\n");
}

TEST_CASE("calibrate: the document alone, of a sensor that is known, with limits that only list figures") {
  const CalibrationFolder of;
  REQUIRE(call(of.folder, {"sensors", "add", "MY-1"}).code == 0);
  const Finished done = of.calibrate({"--json"}, "./only.toml");
  INFO(done.err);
  REQUIRE(done.code == 0);
  const nlohmann::json document = nlohmann::json::parse(done.out);
  CHECK(document.at("registered") == false);
  CHECK((document.at("run") == 1 && document.at("held_out") == 2));
  CHECK(document.at("limits") == "only");
  CHECK(document.at("origin") == "simulated");
  CHECK(document.at("model") == "elam");
  CHECK(document.at("reason") == "limits 'only' only list figures: they state no verdict");
  CHECK(document.at("verdicts").size() == 4);
  CHECK(document.at("judgement").is_object());
  CHECK(document.at("report").at("path") == "reports/run-1.html");
  CHECK(document.at("report").at("number").get<std::string>().starts_with("1-"));
  CHECK_THAT(of.told({"runs", "show", "1", "--json"}).dump(), !Catch::Contains("left out as asked"));
  const Finished page = of.calibrate({"--run", "1", "--held-out", "2", "--units", "kPa"}, "./only.toml");
  CHECK(page.code == 0);
  CHECK_THAT(page.out, Catch::Contains("\n1/5 sensor    MY-1 (PCB piezoresistive 16x16) is registered in runs.db\n2/5 "
                                       "measure   run 1 is taken as it is\n3/5 held out  run 2 is taken as it is\n4/5 "
                                       "fit       elam on run 1: 256 of 256 taxels fitted; on run 2 mean |error| ") &&
                           Catch::Contains(" kPa, worst taxel ") && !Catch::Contains("####"));
}

TEST_CASE("calibrate: after a run that failed the words resume it and carry on, for the first run and for the second") {
  const CalibrationFolder of;
  const std::string fault = R"(simulation.faults=[{kind="scanner_unplugged",at_s=20}])", set = " --set '" + fault + "'";
  const Finished first = of.calibrate({"--no-seating", "--set", fault});
  CHECK(first.code == 3);
  CHECK_THAT(line_of(first.err, "  try: "), Catch::EndsWith("and start again; to continue: tactbench resume 1 --db "
                                                            "runs.db, then " +
                                                            kAgain + set + " --run 1"));
  CHECK_THAT(line_of(first.err, "  state: "),
             Catch::StartsWith("vented, verified ") && Catch::EndsWith("run 1 kept with 8 frames"));
  CHECK_THAT(first.out, Catch::EndsWith("is new, registered in runs.db\n"));
  REQUIRE(call(of.folder, {"run", "./a.toml", "--bench", "bench.toml", "--sensor", "MY-1", "-q"}).code == 0);
  const Finished second = of.calibrate({"--no-seating", "--set", fault, "--run", "2"});
  CHECK(second.code == 3);
  CHECK_THAT(line_of(second.err, "  try: "), Catch::EndsWith("and start again; to continue: tactbench resume 3 --db "
                                                             "runs.db, then " +
                                                             kAgain + set + " --run 2 --held-out 3"));
  CHECK_THAT(second.out, Catch::EndsWith("\n2/5 measure   run 2 is taken as it is\n"));
  // A sensor that is seated badly is measured anew: that run is not worth completing.
  const std::string turn = "simulation.mount_turn=\"turned-90\"", turned = " --set '" + turn + "'";
  const Finished third = of.calibrate({"--set", turn});
  CHECK(third.code == 1);
  CHECK_THAT(third.err, Catch::Contains("[TB-SEATING]"));
  CHECK_THAT(line_of(third.err, "  try: "), Catch::EndsWith("; to continue: " + kAgain + turned));
  const Finished fourth = of.calibrate({"--set", turn, "--run", "2"});
  CHECK(fourth.code == 1);
  CHECK_THAT(line_of(fourth.err, "  try: "), Catch::EndsWith("; to continue: " + kAgain + turned + " --run 2"));
}

TEST_CASE("calibrate: after the runs the words carry on from them, and the rig is at rest") {
  const CalibrationFolder of;
  write_file(of.folder.path("reports"), "no folder");
  const Finished written = of.calibrate({});
  CHECK(written.code == 2);
  CHECK(line_of(written.err, "  try: ") ==
        "check folder, space and permissions; to continue: " + kAgain + " --run 1 --held-out 2");
  const std::string at_rest = "each completed run ended in its proved safe state";
  CHECK(line_of(written.err, "  state: ") == at_rest);
  CHECK_THAT(written.out, !Catch::Contains("5/5"));
  const Finished taken = of.calibrate({"--run", "1", "--held-out", "2"});
  CHECK(taken.code == 2);
  CHECK(line_of(taken.err, "  state: ") != at_rest);  // nothing was measured
  const Finished half = of.calibrate({"--run", "1"});
  CHECK(line_of(half.err, "  try: ") ==
        "check folder, space and permissions; to continue: " + kAgain + " --run 1 --held-out 3");
  CHECK(line_of(half.err, "  state: ") == at_rest);
}
