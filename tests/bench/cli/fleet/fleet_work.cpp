// Which sensors fleet fit would fit, what fleet slurm makes of a night, and what the fleet's verbs refuse.
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "bench/cli/runs/from_fleet.h"
#include "bench/common/build_info.h"
#include "db/fleet/postgres.h"
#include "tests/bench/cli/fleet/fleet_verb.h"
#include "tests/support/variable.h"

namespace tactbench::tests::postgres {

TEST_CASE("fleet fit: which run of each sensor would be fitted, and why") {
  if (!db::fleet::built_with_libpq()) return;
  const std::string now = bench::build_info().version, sha(64, 'a'), other(64, 'b');
  const auto fit = [&](const std::vector<std::string>& more) {
    std::vector<Answer> answers = of_this_schema();
    answers.emplace_back(ended("BEGIN"));
    answers.emplace_back(rows(1, {{"1"}, {"2"}}));
    answers.emplace_back(ended("ROLLBACK"));
    answers.emplace_back(rows(3, {{"S-a", "9", "p x"},
                                  {"S-b", "1", "p x"},
                                  {"S-b", "5", "p x"},
                                  {"S-b", "6", "q y"},
                                  {"S-c", "2", "p x"},
                                  {"S-d", "3", "p x"},
                                  {"S-e", "4", "p x"},
                                  {"S-f", "7", "p x"},
                                  {"S-g", "10", "p x"},
                                  {"S-g", "11", "r z"},
                                  {"S-g", "12", "p x"}}));
    answers.emplace_back(rows(6, {{"S-b", "1", "elam", sha, now, "p x"},
                                  {"S-c", "2", "elam", sha, "0.0.1", "p x"},
                                  {"S-d", "3", "elam", sha, now, "p x"},
                                  {"S-e", "4", "gpi", sha, now, "p x"},
                                  {"S-f", "8", "elam", sha, now, "q y"},
                                  {"S-g", "10", "elam", sha, now, "p x"},
                                  {"S-g", "11", "elam", other, now, "r z"},
                                  {"S-g", "12", "gpi", sha, now, "p x"}}));
    std::vector<std::string> words = {"fit", "--dry-run"};
    words.insert(words.end(), more.begin(), more.end());
    const Finished finished = fleet_verb(answers, words);
    CHECK(finished.code == 0);
    return finished.out;
  };
  CHECK(fit({}) ==
        "S-a                 left out: it has no model yet, so that no run of it is known to be one for models\n"
        "S-b                 run 5: elam; run 5 is newer than run 1, which was fitted, child of aaaaaaaaaaaa\n"
        "S-c                 run 2: elam; its model is by version 0.0.1, child of aaaaaaaaaaaa\n"
        "S-e                 run 4: elam; it has no model elam yet\n"
        "S-f                 left out: none of its runs that were chosen has the recipes of its models\n"
        "hardware runs: 3 sensors to be fitted, 2 up to date, 2 left out, 0 failed\n");
  const std::string only = "hardware runs: 3 sensors to be fitted, 2 up to date, 2 left out, 0 failed\n";
  CHECK(fit({"-q"}) == only);
  CHECK_THAT(fit({"--model", "gpi", "--origin", "simulated"}),
             Catch::Contains("S-b                 run 5: gpi; it has no model gpi yet\n") && !Catch::Contains("S-e ") &&
                 Catch::Contains("simulated runs: "));
  const nlohmann::json told = nlohmann::json::parse(fit({"--json"}));
  CHECK(told.at("model") == "elam");
  CHECK(told.at("dry_run") == true);
  CHECK((told.at("fitted") == 3 && told.at("up_to_date") == 2 && told.at("left_out") == 2 && told.at("failed") == 0));
  REQUIRE(told.at("sensors").size() == 7);
  CHECK(told.at("sensors").at(1) == nlohmann::json{{"sensor", "S-b"},
                                                   {"run", 5},
                                                   {"why", "run 5 is newer than run 1, which was fitted"},
                                                   {"parent_sha256", sha}});
  CHECK(told.at("sensors").at(6).at("why") == "up to date");
  CHECK(told.at("sensors").at(6).at("run") == 0);
  const nlohmann::json one = nlohmann::json::parse(fit({"--json", "--shard", "1/2"})),
                       two = nlohmann::json::parse(fit({"--json", "--shard", "2/2"}));
  CHECK(one.at("shard") == "1/2");
  CHECK(one.at("sensors").size() + two.at("sensors").size() == 7);
  CHECK(one.at("sensors").size() < 7);
}

TEST_CASE("fleet verbs: what is refused before a server is asked") {
  const auto refused = [](std::vector<std::string> words, const std::string& said) {
    words.insert(words.begin(), "fleet");
    const Finished finished = verb_here(bench::add_fleet, words);
    CHECK(finished.code == 2);
    CHECK(finished.err == said);
    CHECK(finished.out.empty());
  };
  refused(
      {"fit", "--to", "x", "--model", "dynamic"},
      "error: the fleet fits no model 'dynamic' [TB-USAGE]\n  at: --model\n  try: which runs its lag and creep come "
      "from is a person's choice: tactbench fit on the bench, then push\n");
  refused({"fit", "--to", "x", "--model", "elamm"},
          "error: the fleet fits no model 'elamm' [TB-USAGE]\n  at: --model\n  try: elam, gpi, mpi, poly, preisach or "
          "monotone\n");
  refused(
      {"push", "--to", "x", "--follow", "--json"},
      "error: --json prints one document, and --follow does not end [TB-USAGE]\n  at: fleet push\n  try: leave one of "
      "them out; tactbench fleet status --json shows how far a push has come\n");
  const std::string needs = "  at: fleet slurm\n  try: ";
  refused({"slurm", "--shards", "2", "--", "run", "x"},
          "error: 'run' is not carried out in parts under Slurm [TB-USAGE]\n" + needs +
              "tactbench fleet slurm --shards N -- nightly SUITE --db FILE ...\n");
  refused(
      {"slurm", "--shards", "2", "--", "nightly", "nightly"},
      "error: the night is kept in a store, and none is named [TB-USAGE]\n" + needs + "add --db FILE after nightly\n");
  refused({"slurm", "--shards", "2", "--", "nightly", "nightly", "--db", "x.db", "--shard", "1/2"},
          "error: --shard is given by fleet slurm itself [TB-USAGE]\n" + needs + "leave it out\n");
  for (const std::vector<std::string>& own :
       std::vector<std::vector<std::string>>{{"--list"}, {"--stores", "x"}, {"--stop-on-red"}, {"--result", "x"}}) {
    std::vector<std::string> words = {"slurm", "--shards", "2", "--", "nightly", "nightly", "--db", "x.db"};
    words.insert(words.end(), own.begin(), own.end());
    refused(words, "error: --list, --stores and --stop-on-red are of a night on one machine [TB-USAGE]\n" + needs +
                       "leave them out\n");
  }
  const Finished unknown = verb_here(bench::add_fleet, {"fleet", "slurm", "--shards", "2", "--", "nightly", "nightly",
                                                        "--db", "x.db", "--seedz", "3"});
  CHECK(unknown.code == 2);
  CHECK_THAT(unknown.err, Catch::StartsWith("error: after --: ") && Catch::Contains("see tactbench nightly --help"));
}

TEST_CASE("fleet slurm: a night has at most as many parts as scenarios, and without Slurm its script is written") {
  const TemporaryFolder folder;
  const std::string suite = folder.path("suite.toml"), store = folder.path("night.db");
  write_file(suite,
             "schema = 1\nname = \"s\"\n[[scenario]]\nname = \"a\"\nabout = \"b\"\n[[scenario]]\nname = \"c\"\nabout = "
             "\"d\"\n");
  const auto slurm = [&](const std::string& shards, const std::vector<std::string>& before,
                         const std::vector<std::string>& after) {
    std::vector<std::string> words = {"fleet", "slurm", "--shards", shards, "--no-submit"};
    words.insert(words.end(), before.begin(), before.end());
    words.insert(words.end(), {"--", "nightly", suite, "--db", store});
    words.insert(words.end(), after.begin(), after.end());
    return verb_here(bench::add_fleet, words);
  };
  const Finished many = slurm("3", {}, {});
  CHECK(many.code == 2);
  CHECK(many.err == "error: 2 scenarios cannot be done in 3 parts [TB-USAGE]\n  at: --shards\n  try: at most 2\n");
  const Finished two = slurm("2", {}, {});
  CHECK(two.code == 0);
  const std::string parts = store + ".parts", script = two.out.substr(0, two.out.find(": one of"));
  CHECK(script.starts_with(parts + "/"));
  CHECK(two.out == script + ": one of 2 parts of 2 scenarios; for instance\n  parallel sh " + script +
                       " ::: $(seq 2)\n  tactbench runs merge " + parts + "/shard-*.db --db " + store + "\n");
  CHECK_THAT(read_file(script), Catch::Contains(" '--seeds' '1' --shard "));
  const std::string own = folder.path("own");
  const Finished seeds = slurm("4", {"--folder", own, "--json"}, {"--seeds", "2", "--only", "a", "--seed", "9"});
  CHECK(seeds.code == 2);  // one scenario, twice
  const Finished four = slurm("4", {"--folder", own, "--json"}, {"--seeds", "2", "--seed", "9"});
  REQUIRE(four.code == 0);
  const nlohmann::json told = nlohmann::json::parse(four.out);
  CHECK(told.at("shards") == 4);
  REQUIRE(told.at("stores").size() == 4);
  CHECK(told.at("stores").at(0).get<std::string>().starts_with(own + "/shard-"));
  const std::string text = read_file(told.at("script"));
  CHECK_THAT(text, Catch::Contains(" '--jobs' '2' '--limit' '300' '--seeds' '2' '--seed' '9' --shard "));
  CHECK_THAT(text, !Catch::Contains("--only"));
}

TEST_CASE("the fleet's name comes from the command line, else from the environment, and a run's is a number") {
  bench::Session session;
  CHECK(bench::fleet_named("host=a", session) == "host=a");
  for (const char* unnamed : {"", "fleet"}) {
    try {
      (void)bench::fleet_named(unnamed, session);
      FAIL("nothing names it");
    } catch (const bench::Error& error) {
      CHECK(error.id() == "TB-USAGE");
      CHECK(std::string(error.what()) == "no fleet is named");
    }
  }
  const Variable named("TACTBENCH_FLEET", "service=lab");
  bench::Session other;
  CHECK(bench::fleet_named("fleet", other) == "service=lab");
  CHECK(bench::fleet_named("", other) == "service=lab");
  CHECK(bench::fleet_named("host=a", other) == "host=a");
  CHECK(bench::run_number("12") == 12);
  for (const char* none : {"", "x", "1x", "-1", "ab12"}) CHECK_THROWS_AS(bench::run_number(none), bench::Error);
  CHECK(bench::run_number(std::string(18, '9')) == 999999999999999999);
  CHECK_THROWS_AS(bench::run_number(std::string(19, '9')), bench::Error);
}

}  // namespace tactbench::tests::postgres
