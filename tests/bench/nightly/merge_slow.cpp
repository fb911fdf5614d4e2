// A night in parts, put together, beside the same night in one; what merging takes and refuses.
#include <catch2/catch.hpp>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "db/run_store.h"
#include "tests/support/process.h"

using namespace tactbench;
using namespace tactbench::tests;

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

TEST_CASE("a night in three parts, merged, is the night in one: runs, figures, models, baseline") {
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

TEST_CASE("stores of several benches are merged: runs once each, and fits that were made since") {
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
