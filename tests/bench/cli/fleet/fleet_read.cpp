// fleet runs and fleet show of a run that a server by script hands out.
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "db/fleet/postgres.h"
#include "db/fleet/remarks.h"
#include "tests/bench/cli/fleet/fleet_verb.h"
#include "tests/db/fleet/fleet_example.h"

namespace tactbench::tests::postgres {

namespace {

// `fleet` VERB at a server that finds these runs and hands them out.
struct ReadFrom {
  ReadFrom(const std::vector<Answer>& answers, std::vector<std::string> words) {
    const Server server(answers);
    words.insert(words.begin(), "fleet");
    words.insert(words.end(), {"--from", server.conninfo()});
    finished = verb_here(bench::add_fleet, words);
    for (std::string* text : {&finished.out, &finished.err})
      for (std::size_t at = text->find(server.where()); at != std::string::npos; at = text->find(server.where()))
        text->replace(at, server.where().size(), "WHERE");
  }
  Finished finished;
};

std::vector<Answer> joined(std::initializer_list<std::vector<Answer>> parts) {
  std::vector<Answer> all;
  for (const std::vector<Answer>& part : parts) all.insert(all.end(), part.begin(), part.end());
  return all;
}

std::vector<Answer> finds(const std::vector<std::vector<Field>>& runs) {
  return {ended("BEGIN"), rows(1, runs), ended("ROLLBACK")};
}

// The run with what is said of it, in one transaction.
std::vector<Answer> hands_out(const Fleet& fleet, bool with_frames) {
  std::vector<Answer> all = fleet.all(fleet.fit.sha256, db::fleet::sha256_of(fleet.remarks), {fleet.sensor});
  if (!with_frames) {
    all.erase(all.begin() + 11, all.begin() + 13);  // the months, and the frames of the one
    all.erase(all.begin() + 2);                     // the sensors, which are asked for once
  }
  all.erase(all.begin());  // the start of the connection
  return all;
}

const std::vector<Answer> kOrigins = {rows(2, {{"hardware", "3"}, {"imported", "4"}, {"simulated", "1"}})};

}  // namespace

TEST_CASE("fleet runs: the runs of one origin, with the frames that the server counts, and how many are left out") {
  if (!db::fleet::built_with_libpq()) return;
  const Fleet fleet;
  const auto list = [&](const std::vector<std::string>& more) {
    std::vector<std::string> words = {"runs", "--origin", "simulated", "--all"};
    words.insert(words.end(), more.begin(), more.end());
    return ReadFrom(
               joined(
                   {of_this_schema(), finds({{"41"}}), {rows(2, {{"41", "1234"}})}, hands_out(fleet, false), kOrigins}),
               words)
        .finished;
  };
  const Finished told = list({});
  INFO(told.err << told.out);
  CHECK(told.code == 0);
  CHECK(told.err == "3 hardware left out (--origin hardware)\n4 imported left out (--origin imported)\n");
  CHECK_THAT(told.out, Catch::Contains("1234") && Catch::Contains("S-1"));
  const Finished as_json = list({"--json"});
  CHECK(as_json.err.empty());
  const nlohmann::json document = nlohmann::json::parse(as_json.out);
  REQUIRE(document.at("runs").size() == 1);
  CHECK((document.at("runs").at(0).at("run") == 41 && document.at("runs").at(0).at("frames") == 1234));
}

TEST_CASE("fleet show: all of a run, who pushed it, and its fits in the fleet") {
  if (!db::fleet::built_with_libpq()) return;
  const Fleet fleet;
  const std::string sha(64, 'a'), parent(64, 'b');
  const std::vector<Answer> asked = {
      rows(4, {{"bench_a", "2026-02-03T04:05:06Z", "2", "host:/runs.db"}}),
      rows(5, {{"elam", "0.1.0", "2026-01-01", sha, ""}, {"gpi", "0.2.0", "2026-01-02", sha, parent}})};
  const auto show = [&](const std::vector<std::string>& more) {
    std::vector<std::string> words = {"show", "41"};
    words.insert(words.end(), more.begin(), more.end());
    return ReadFrom(joined({of_this_schema(), {rows(1, {{"41"}})}, hands_out(fleet, true), asked}), words).finished;
  };
  const Finished told = show({});
  INFO(told.err << told.out);
  CHECK(told.code == 0);
  CHECK_THAT(told.out,
             Catch::EndsWith("\n  fleet         WHERE: pushed by bench_a on 2026-02-03T04:05:06Z, from host:/runs.db; "
                             "revisions of what is said of it: 2\n  fit           elam by 0.1.0 on 2026-01-01, sha256 "
                             "aaaaaaaaaaaa\n  fit           gpi by 0.2.0 on 2026-01-02, sha256 aaaaaaaaaaaa, child of "
                             "bbbbbbbbbbbb\n"));
  const Finished as_json = show({"--json"});
  CHECK(nlohmann::json::parse(as_json.out).at("run") == 41);
  CHECK(nlohmann::json::parse(as_json.out).at("frames") == 3);
}

TEST_CASE("fleet trend: where there are no figures it names the fleet and the origin, and what is left out") {
  if (!db::fleet::built_with_libpq()) return;
  const Fleet fleet;  // its one run is void
  const auto trend = [&](const std::vector<std::string>& more) {
    std::vector<std::string> words = {"trend", "--origin", "simulated"};
    words.insert(words.end(), more.begin(), more.end());
    return ReadFrom(joined({of_this_schema(), finds({{"41"}}), hands_out(fleet, false), kOrigins}), words).finished;
  };
  const std::string others = "3 hardware left out (--origin hardware)\n4 imported left out (--origin imported)\n",
                    at = " [TB-TREND-NONE]\n  at: WHERE, simulated runs\n  try: ";
  const Finished voided = trend({});
  CHECK(voided.code == 2);
  CHECK(voided.out.empty());
  CHECK(voided.err ==
        others + "error: all runs with such figures are void" + at + "tactbench runs list --all shows why\n");
  CHECK(trend({"--where", "bench_id = 'b'"}).err == voided.err);
  CHECK(trend({"--subject", "none"}).err == others + "error: there are no such figures" + at + "there are: a, rig\n");
  CHECK(trend({"--json"}).err == voided.err.substr(others.size()));
}

}  // namespace tactbench::tests::postgres
