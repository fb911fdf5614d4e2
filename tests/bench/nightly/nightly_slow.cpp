// The verb itself, in its own process, with the processes that it starts.
#include <catch2/catch.hpp>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>

#include "db/run_store.h"
#include "tests/support/process.h"

using namespace tactbench;
using namespace tactbench::tests;

namespace {

const char* const kSuite = R"(schema = 1
name = "small"
[[scenario]]
name = "whole"
about = "nothing is wrong"
recipes = ["equilibration"]
fits = false
[scenario.figures]
frames = [60, 60.5]
[[scenario]]
name = "unseen-defect"
about = "a dead taxel that this scenario knows nothing of"
set = ["recipe.repeats=1", 'simulation.defect=[{kind="dead",row=3,column=4}]']
[[scenario]]
name = "misspelt"
about = "a recipe that does not exist"
recipes = ["no-such"]
)";

nlohmann::json night_json(const Finished& finished) { return nlohmann::json::parse(finished.out); }

}  // namespace

TEST_CASE("night: reports passed scenarios, gives the reason for a failed one, and continues after a broken one") {
  const TemporaryFolder folder;
  write_file(folder.path("small.toml"), kSuite);
  const Finished night = call(folder, {"nightly", "./small.toml", "--json", "--junit", "night.xml", "--metrics",
                                       "night.prom", "--html", "night.html", "--stores", "kept"});
  CHECK(night.code == 1);
  CHECK_THAT(read_file(folder.path("night.prom")), Catch::Contains("tactbench_nightly_green{scenario=\"whole\"} 1\n"));
  CHECK(run_program("/usr/bin/xmllint", {"--noout", "night.html"}, folder.path()).code == 0);
  const nlohmann::json result = night_json(night);
  CHECK(result.at("red") == 2);
  CHECK(result.at("scenarios").at(0).at("wrong").empty());
  CHECK_THAT(result.at("scenarios").at(1).at("wrong").at(0).get<std::string>(), Catch::Contains("52"));
  CHECK_THAT(result.at("scenarios").at(2).at("wrong").at(0).get<std::string>(), Catch::Contains("exit code 2"));
  CHECK(read_file(folder.path("night.xml")).find("failures=\"2\" errors=\"0\"") != std::string::npos);
  CHECK(std::filesystem::exists(folder.path("kept/whole.db")));
}

TEST_CASE("night: nights are kept in one store, compared with a baseline, and changes are named") {
  const TemporaryFolder folder;
  const std::string head =
      "schema = 1\nname = \"kept\"\n[[scenario]]\nname = \"short\"\nabout = \"one repeat\"\nset = "
      "[\"recipe.repeats=1\"";
  write_file(folder.path("suite.toml"), head + "]\n");
  write_file(folder.path("noisy.toml"), head + ", \"simulation.front_end.noise_v=0.02\"]\n");
  const auto call = [&](const std::vector<std::string>& words) { return tests::call(folder, words); };
  const Finished seeds = call({"nightly", "./suite.toml", "--db", "nights.db", "--seeds", "8", "--json"});
  INFO(seeds.err << seeds.out);
  REQUIRE(seeds.code == 0);
  CHECK(night_json(seeds).at("scenarios").at(3).at("name") == "short-seed-4");
  CHECK(night_json(seeds).at("scenarios").at(3).at("runs").at(0).at("run") == 4);
  CHECK(call({"trend", "accept", "1-8", "--db", "nights.db", "--by", "K. Lee"}).code == 2);
  REQUIRE(call({"trend", "accept", "1-8", "--db", "nights.db", "--by", "K. Lee", "--reason", "as made"}).code == 0);
  const Finished same = call({"nightly", "./suite.toml", "--db", "nights.db", "--json", "--html", "night.html"});
  INFO(same.err << same.out);
  CHECK(same.code == 0);
  CHECK_THAT(night_json(same).at("scenarios").at(0).at("compared").get<std::string>(), Catch::EndsWith("run 1"));
  CHECK(run_program("/usr/bin/xmllint", {"--noout", "night.html"}, folder.path()).code == 0);
  {  // another program's analysis of the same frames
    db::RunStore store = db::RunStore::open(folder.path("nights.db"));
    std::map<std::string, double> figures;
    for (const db::FigureRecord& figure : store.figures("nightly/short"))
      if (figure.run == 9) figures[figure.name] = figure.value;
    figures.at("mean_error_psi") += 1e-6;
    store.replace_figures(9, "nightly/short", figures);
  }
  const Finished moved = call({"nightly", "./suite.toml", "--db", "nights.db", "--json"});
  CHECK(moved.code == 6);
  CHECK_THAT(night_json(moved).at("scenarios").at(0).at("remarks").at(0).get<std::string>(),
             Catch::StartsWith("mean_error_psi ") && Catch::Contains("run 9"));
  const Finished noisy = call({"nightly", "./noisy.toml", "--db", "nights.db", "--junit", "night.xml", "--json"});
  CHECK(noisy.code == 1);
  const nlohmann::json result = night_json(noisy).at("scenarios").at(0);
  CHECK_THAT(result.at("compared").get<std::string>(), Catch::Contains("run 10 "));
  const std::string junit = read_file(folder.path("night.xml"));
  CHECK_THAT(junit, Catch::Contains("noisiest_taxel_mv "));
  const Finished trend = call({"trend", "--subject", "nightly/short", "--figure", "noisiest_taxel_mv", "--db",
                               "nights.db", "--check", "--json"});
  CHECK(trend.code == 1);
  CHECK(night_json(trend).at("subjects").at(0).at("figures").at(0).at("values").size() == 11);
  CHECK(call({"trend", "--subject", "nightly/none", "--db", "nights.db"}).code == 2);
  CHECK(call({"verify", "--db", "nights.db"}).code == 0);
}

// A merged night in parts, compared with the same night in one; what merging accepts and refuses.

namespace {

// Two scenarios with models, one of two runs, and a red one.
const char* const kParts = R"(schema = 1
name = "parts"
[[scenario]]
name = "short"
about = "a fit judged on another run"
recipes = ["production"]
held_out = []
[[scenario]]
name = "rest"
about = "no fit"
recipes = ["equilibration"]
fits = false
[scenario.figures]
frames = [1, 2]
)";

nlohmann::json json_of(const Finished& finished) {
  INFO(finished.out << finished.err);
  return nlohmann::json::parse(finished.out);
}

// The facts of a store that must not depend on the number of machines, as text: a number that is none equals itself
// there.
std::string facts_of(const std::string& path) {
  const db::RunStore store = db::RunStore::open_read_only(path);
  nlohmann::json facts;
  for (const db::RunRecord& run : store.runs()) {
    nlohmann::json own = {{"content", run.content_sha256}, {"seed", run.seed}, {"tags", run.tags}};
    for (const db::FitRecord& fit : store.fits(run.run))
      own["fits"].push_back({fit.fit, fit.model, fit.stands, fit.fitted, fit.document});
    for (const db::VerdictRecord& v : store.verdicts(run.run))
      own["verdicts"].push_back({v.fit, v.criterion, v.scope_kind, v.low_psi, v.direction, v.value, v.verdict});
    facts["runs"].push_back(own);
  }
  for (const db::FigureRecord& figure : store.figures(""))
    facts["figures"].push_back({figure.run, figure.subject, figure.name, figure.value});
  for (const db::BaselineRecord& baseline : store.baselines())
    facts["baselines"].push_back({baseline.subject, baseline.runs, baseline.reason, baseline.accepted_utc});
  for (const db::NightRecord& night : store.nights()) {
    nlohmann::json own = {{"suite", night.suite}, {"shards", night.shards}, {"selection", night.selection_json}};
    for (const db::NightResultRecord& result : night.results)
      own["results"].push_back({result.position, result.label, result.first_run});
    facts["nights"].push_back(own);
  }
  return facts.dump();
}

}  // namespace

TEST_CASE("merge: a night in three parts gives the same runs, values, models and baseline as the whole night") {
  const TemporaryFolder folder;
  write_file(folder.path("parts.toml"), kParts);
  const auto night = [&](std::vector<std::string> more) {
    std::vector<std::string> words = {"nightly", "./parts.toml", "--seeds", "8", "-q"};
    words.insert(words.end(), more.begin(), more.end());
    return call(folder, words);
  };
  REQUIRE(night({"--db", "one.db"}).code == 1);  // "rest" has more than 2 frames
  // In an order that is not theirs.
  for (const char* part : {"3", "1", "2"}) {
    const Finished done =
        night({"--db", std::string("part-") + part + ".db", "--shard", std::string(part) + "/3", "--json"});
    CHECK(done.code == 1);
    CHECK(json_of(done).at("scenarios").size() == (std::string(part) == "3" ? 5 : part[0] == '1' ? 6 : 5));
  }
  const Finished merged = call(folder, {"runs", "merge", "part-2.db", "part-3.db", "part-1.db", "--db", "three.db",
                                        "--html", "three.html", "--junit", "three.xml", "--json"});
  CHECK(merged.code == 1);
  const nlohmann::json result = json_of(merged);
  CHECK((result.at("runs") == 24 && result.at("there") == 0 && result.at("nights").size() == 1));
  CHECK((result.at("nights").at(0).at("red") == 8 && result.at("nights").at(0).at("not_run") == 0));
  CHECK(facts_of(folder.path("three.db")) == facts_of(folder.path("one.db")));
  CHECK(std::filesystem::exists(folder.path("three.html")));
  CHECK_THAT(read_file(folder.path("three.xml")), Catch::Contains("tests=\"16\" failures=\"8\" errors=\"0\""));
  // The next night is compared with the merged one as with the other, on the same baseline.
  for (const char* db : {"one.db", "three.db"}) {
    REQUIRE(call(folder, {"trend", "accept", "1-24", "--db", db, "--by", "K. Lee", "--reason", "as made"}).code == 0);
    CHECK(call(folder, {"verify", "--db", db}).code == 0);
  }
  CHECK(call(folder, {"trend", "--db", "one.db"}).out == call(folder, {"trend", "--db", "three.db"}).out);
  const auto next = [&](const std::string& db) {
    nlohmann::json own = json_of(call(folder, {"nightly", "./parts.toml", "--seed", "3", "--db", db, "--json"}));
    for (nlohmann::json& scenario : own.at("scenarios")) scenario.erase("seconds");
    return own;
  };
  const nlohmann::json after = next("one.db");
  CHECK(next("three.db") == after);
  CHECK(after.at("scenarios").at(0).at("compared").get<std::string>().ends_with("run 5"));
  // Merging again takes nothing.
  const Finished again =
      call(folder, {"runs", "merge", "part-1.db", "part-2.db", "part-3.db", "--db", "three.db", "--json"});
  CHECK((json_of(again).at("runs") == 0 && json_of(again).at("there") == 24));
  CHECK(db::RunStore::open_read_only(folder.path("three.db")).nights().size() == 2);
}

TEST_CASE("merge: a run in several stores arrives once, fits made after an earlier merge are added") {
  const TemporaryFolder folder;
  REQUIRE(call(folder, {"init"}).code == 0);
  for (const char* db : {"a.db", "b.db"}) {
    REQUIRE(call(folder, {"sensors", "add", "S-1", "--type", "sensor.toml", "--db", db}).code == 0);
    REQUIRE(call(folder, {"run", "production", "--bench", "bench.toml", "--sensor", "S-1", "--operator", "me", "--yes",
                          "-q", "--seed", db[0] == 'a' ? "5" : "6", "--db", db})
                .code == 0);
  }
  REQUIRE(call(folder, {"runs", "copy", "1", "--to", "b.db", "--db", "a.db"}).code == 0);  // run 2 of b
  REQUIRE(call(folder, {"fit", "1", "--db", "a.db"}).code == 0);
  REQUIRE(call(folder, {"runs", "void", "1", "--reason", "by hand", "--by", "K. Lee", "--db", "b.db"}).code == 0);
  const auto merged = [&] {
    return json_of(call(folder, {"runs", "merge", "a.db", "b.db", "--db", "all.db", "--json"}));
  };
  const nlohmann::json first = merged();
  CHECK((first.at("runs") == 2 && first.at("there") == 1));
  REQUIRE(call(folder, {"fit", "2", "--db", "b.db", "--exact-outer"}).code == 0);
  const nlohmann::json later = merged();
  CHECK((later.at("runs") == 0 && later.at("fits") == 1));
  const db::RunStore all = db::RunStore::open_read_only(folder.path("all.db"));
  CHECK((all.runs().size() == 2 && all.fits(1).size() == 2 && all.run(2).is_void()));
  CHECK(call(folder, {"verify", "1", "--db", "all.db"}).code == 0);
  CHECK(call(folder, {"verify", "--db", "all.db"}).code == 0);
  CHECK(call(folder, {"runs", "merge", "a.db", "--db", "new.db", "--html", "x.html"}).code == 2);  // no night
}
