// What calibrate, page and plan refuse or print before anything is opened.
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "bench/cli/rig/page_beside.h"
#include "tests/bench/cli/verb_here.h"
#include "tests/db/store_example.h"

using namespace tactbench;
using namespace tactbench::tests;

namespace {

using WordsOfVerb = std::vector<std::string>;

void check_refused_by(AddVerb add, const WordsOfVerb& words, const std::string& said) {
  const Finished finished = verb_here(add, words);
  CAPTURE(words);
  CHECK(finished.code == 2);
  CHECK(finished.err == "error: " + said + "\n");
  CHECK(finished.out.empty());
}

}  // namespace

TEST_CASE("calibrate: runs of another sensor, runs that did not complete, and recipes that make no models") {
  const TemporaryFolder folder;
  const std::string path = folder.path("runs.db");
  {
    db::RunStore store = db::RunStore::open(path, db::Durability::kNormal);
    (void)store_example(store);  // run 1 of S-1
    const Begun failed = begin_example(store);
    store.end_run(failed.run, db::Outcome::kFailed, "x", db::SafeState::kVerified, kUtc);
    (void)begin_example(store);  // run 3 has not ended
  }
  const auto refused = [&](const std::string& serial, const WordsOfVerb& more, const std::string& said) {
    WordsOfVerb words = {"calibrate", serial, "--bench", "simulated.toml", "--operator", "me", "--db", path};
    words.insert(words.end(), more.begin(), more.end());
    check_refused_by(bench::add_calibrate, words, said);
  };
  refused(
      "S-1", {"--held-out", "1"},
      "--held-out names a run that judges, and no run is named for the models [TB-USAGE]\n  at: --held-out\n  try: add "
      "--run RUN");
  const std::string other = "run 1 is of sensor 'S-1', not of 'S-2' [TB-USAGE]\n  at: ",
                    name = "\n  try: name a run of this sensor: tactbench runs list --sensor S-2";
  refused("S-2", {"--run", "1"}, other + "--run" + name);
  refused(
      "S-1", {"--run", "2"},
      "run 2 did not complete: failed [TB-USAGE]\n  at: --run\n  try: tactbench resume 2 completes it; or name another "
      "run");
  refused("S-1", {"--run", "1", "--held-out", "3"},
          "run 3 did not complete: incomplete [TB-USAGE]\n  at: --held-out\n  try: tactbench resume 3 completes it; or "
          "name another run");
  const std::string press =
      " [TB-USAGE]\n  at: calibrate\n  try: name recipes with loops of pressure, such as production "
      "or random-reversal";
  refused("S-1", {"--recipe", "production", "--recipe", "ring"},
          "no models are made from recipes that press objects: production, ring" + press);
  refused("S-1", {"--held-out-recipe", "ring"}, "no models are made from recipes that press objects: ring" + press);
  const Finished lacks =
      verb_here(bench::add_calibrate, {"calibrate", "S-1", "--bench", "simulated.toml", "--operator", "me", "--db",
                                       path, "--limits", "nightly-limits.toml", "--held-out-recipe", "production"});
  CHECK(lacks.code == 2);
  CHECK_THAT(lacks.err,
             Catch::StartsWith("error: limits '") &&
                 Catch::Contains("' judge at 10 psi, which production does not measure: no sensor could pass "
                                 "[TB-CALIBRATE-LEVELS]\n  at: --held-out-recipe\n  try: name a recipe that "
                                 "measures it (tactbench plan RECIPE --limits FILE), or other limits\n"));
  const Finished nobody = verb_here(bench::add_calibrate,
                                    {"calibrate", "S-1", "--bench", "simulated.toml", "--operator", " ", "--db", path});
  CHECK_THAT(nobody.err, Catch::StartsWith("error: --operator is empty [TB-USAGE]\n"));
  CHECK(nobody.out.empty());  // before anything else
  CHECK_THAT(verb_here(bench::add_calibrate, {"calibrate", "S-1", "--bench", "simulated.toml", "--operator", "me",
                                              "--db", path, "--run", "9"})
                 .err,
             Catch::Contains("[TB-STORE-NOT-FOUND]"));
}

TEST_CASE("calibrate: a new sensor of a real bench needs the file of its type, and every named file is read first") {
  const TemporaryFolder folder;
  const std::string type = folder.path("type.toml"), lab = folder.path("none.toml");
  check_refused_by(bench::add_calibrate,
                   {"calibrate", "NEW-1", "--bench", "paper-rig.example.toml", "--operator", "me", "--db",
                    folder.path("runs.db"), "--type", type},
                   "sensor 'NEW-1' is new, and there is no file '" + type +
                       "' that describes its type [TB-SENSOR-UNKNOWN]\n  at: --type " + type +
                       "\n  try: name its sensor type file: --type FILE; or correct the serial number");
  const auto said = [&](const WordsOfVerb& more) {
    WordsOfVerb words = {"calibrate",  "S-1", "--bench", "simulated.toml",
                         "--operator", "me",  "--db",    folder.path("runs.db")};
    words.insert(words.end(), more.begin(), more.end());
    const Finished finished = verb_here(bench::add_calibrate, words);
    CHECK(finished.code == (more.front() == "--run" && more.back() == "1" ? 5 : 2));
    CHECK(finished.out.empty());
    return finished.err;
  };
  CHECK_THAT(said({"--lab", lab}), Catch::Contains("[TB-FILE-MISSING]") && Catch::Contains(lab));
  CHECK_THAT(said({"--meta", "nothing"}), Catch::Contains("'nothing'"));
  CHECK_THAT(said({"--limits", "none.toml"}), Catch::Contains("none.toml"));
  CHECK_THAT(said({"--recipe", "nonesuch"}), Catch::Contains("nonesuch"));
  CHECK_THAT(said({"--held-out-recipe", "nonesuch"}), Catch::Contains("nonesuch"));
  CHECK_THAT(said({"--set", "recipe.nonesuch=1"}), Catch::Contains("nonesuch"));
  CHECK_THAT(said({"--set", "bench.nonesuch=1"}), Catch::Contains("nonesuch"));
  CHECK_THAT(said({"--run", "1"}), Catch::Contains("[TB-STORE-OPEN]"));
  CHECK_THAT(said({"--model", "nonesuch"}), Catch::StartsWith("parse: "));
  for (const char* option : {"--run", "--held-out"}) CHECK_THAT(said({option, "0"}), Catch::StartsWith("parse: "));
}

TEST_CASE("page: a night that is not there, and an address that others could listen on") {
  const TemporaryFolder folder;
  check_refused_by(bench::add_page, {"page", "--night", folder.path("none.html")},
                   "there is no such file [TB-FILE-MISSING]\n  at: " + folder.path("none.html") +
                       "\n  try: name the page that `tactbench nightly --html` wrote");
  for (const char* address : {"0.0.0.0", "::", "192.168.1.7", "128.0.0.1"})
    check_refused_by(bench::add_page, {"page", "--listen", address},
                     "on " + std::string(address) +
                         " everybody on the network could read the link's keys on their way [TB-PAGE-OPEN]\n  at: "
                         "--listen " +
                         address +
                         "\n  try: add --tls CERTIFICATE KEY; or leave --listen out and come through a tunnel: ssh -L "
                         "8765:127.0.0.1:8765 THIS-MACHINE");
  check_refused_by(bench::add_page, {"page", "--operator", " "},
                   "--operator is empty [TB-USAGE]\n  at: --operator\n  try: give a name: it is recorded");
  const Finished tls = verb_here(
      bench::add_page, {"page", "--listen", "0.0.0.0", "--tls", folder.path("none.pem"), folder.path("none.key")});
  CHECK(tls.code == 2);
  CHECK_THAT(tls.err, Catch::Contains("[TB-PAGE-CERTIFICATE]"));
}

TEST_CASE("plan: parameters as a table and as JSON, and levels that one recipe or several lack") {
  const TemporaryFolder folder;
  const auto plan = [](WordsOfVerb words) {
    words.insert(words.begin(), "plan");
    return verb_here(bench::add_plan, std::move(words));
  };
  const std::string head = "recipe            parameter          value   default  range               unit  help\n";
  const Finished table = plan({"production", "ring", "--parameters", "--set", "recipe.repeats=5"});
  CHECK(table.code == 0);
  CHECK_THAT(table.out, Catch::StartsWith(head + "production        ") &&
                            Catch::Contains("\nproduction        repeats                5         3  1 to 20 ") &&
                            Catch::Contains("\nring              "));
  const auto told = nlohmann::json::parse(plan({"production", "--parameters", "--json"}).out);
  CHECK(told.at("schema") == "tactbench.plan.parameters");
  bool found = false;
  for (const auto& one : told.at("parameters"))
    if (one.at("name") == "repeats") {
      found = true;
      CHECK(one.at("recipe") == "production");
      CHECK((one.at("value") == 3.0 && one.at("default") == 3.0 && one.at("low") == 1.0 && one.at("high") == 20.0));
    }
  CHECK(found);
  const std::string store = folder.path("none.db"), rest = "non-uniformity there will be inconclusive\n";
  const Finished one = plan({"production", "--limits", "nightly-limits.toml", "--db", store});
  CHECK(one.code == 6);
  CHECK_THAT(one.out,
             Catch::Contains(": 10 psi is not a level of this recipe, whose nearest are 8 psi and 12 psi; " + rest) &&
                 !Catch::Contains("every level to be judged"));
  const Finished two = plan({"production", "production", "--limits", "nightly-limits.toml", "--db", store});
  CHECK_THAT(two.out,
             Catch::Contains(": 10 psi is not a level of these recipes, whose nearest are 8 psi and 12 psi; "));
  const Finished force = plan({"ring", "--db", store});
  CHECK_THAT(force.out, Catch::Contains("\nforce up to   30.00 N; the sensor's calibrated range is checked once it is "
                                        "open\n"));
  CHECK_THAT(plan({"production", "--db", store}).out,
             !Catch::Contains("force up to") && !Catch::Contains("conditioning sequence"));
}
