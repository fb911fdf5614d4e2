// The store's verbs as a person uses them: verify, verify, snapshot, migrate, runs tag, note, void, list.
#include <catch2/catch.hpp>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>

#include "analysis/judgement/figure.h"
#include "db/run_store.h"
#include "db/sqlite.h"
#include "tests/bench/cli/verb_here.h"
#include "tests/db/store_example.h"
#include "tests/support/run_recipe.h"
#include "tests/support/text.h"

using namespace tactbench::tests;
using nlohmann::json;
using tactbench::db::sqlite::Access;
using tactbench::db::sqlite::Connection;

namespace {

// Two runs of one sensor, the first fitted, the second judged.
void prepare_store(const TemporaryFolder& folder) {
  begin_bench(folder);
  for (const char* seed : {"1", "2"}) measure_small(folder, seed);
  well(call(folder, {"fit", "1", "--model", "elam"}, {"judge", "1", "2", "--limits", "wide.toml"}));
}

void change(const TemporaryFolder& folder, const std::string& sql) {
  Connection(folder.path("runs.db"), Access::kReadWrite).execute(sql);
}

}  // namespace

TEST_CASE("verify: recomputes content, models and verdicts, and names what was changed") {
  const TemporaryFolder folder;
  prepare_store(folder);
  well(call(folder, {"verify", "1"}));
  const json verified = json::parse(well(call(folder, {"verify", "2", "--json"})).out);
  CHECK(verified["holds"] == true);
  CHECK(verified["content"]["computed_sha256"] == verified["content"]["stored_sha256"]);
  REQUIRE(verified["analysis"].size() == 1);
  check_members(verified["analysis"][0], R"({"what": "verdicts", "recomputed": true, "fit_run": 1})");

  const auto first_difference = [&](const std::string& run) {
    return json::parse(call(folder, {"verify", run, "--json"}).out)["first_difference"].get<std::string>();
  };
  // The hashes stored with verdicts and fits show that one was changed; recomputing shows which.
  change(folder, "UPDATE verdicts SET verdict = 'fail' WHERE criterion = 'unfit_taxels'");
  CHECK(call(folder, {"verify", "2"}).code == 5);
  CHECK_THAT(first_difference("2"), Catch::Contains("unfit_taxels"));
  change(folder, "UPDATE verdicts SET value = value + 1e-9 WHERE criterion = 'worst_taxel_error'");
  CHECK(call(folder, {"verify", "2"}).code == 5);
  CHECK_THAT(first_difference("2"), Catch::Contains("worst_taxel_error"));

  change(folder,
         "UPDATE fits SET document = json_set(document, '$.taxels[5].model.parameters', "
         "json_extract(document, '$.taxels[6].model.parameters'))");
  CHECK(call(folder, {"verify", "1"}).code == 5);
  CHECK_THAT(first_difference("1"), Catch::Contains("taxel 5"));
  change(folder, "UPDATE fits SET document = json_remove(document, '$.taxels[3]')");
  CHECK_THAT(call(folder, {"verify", "1"}).out, Catch::Contains("TB-MODEL-STORED"));

  change(folder, "UPDATE frames SET reference_psi = reference_psi + 1e-9 WHERE frame = 1000000004");
  CHECK(call(folder, {"verify", "1"}).code == 5);
  CHECK_THAT(first_difference("1"), Catch::Contains("frame 4"));
  CHECK(json::parse(call(folder, {"verify", "1", "--json"}).out)["content"]["holds"] == false);
  CHECK(call(folder, {"verify", "2"}).code == 5);
  CHECK_THAT(first_difference("2"), Catch::Contains("frame 4"));
  CHECK(call(folder, {"verify"}).code == 5);
  check_refusal(call(folder, {"verify", "7"}), 2, "TB-STORE-NOT-FOUND");
  change(folder, "UPDATE runs SET outcome = 'incomplete', state = 'running', content_sha256 = '' WHERE run = 2");
  check_refusal(call(folder, {"verify", "2"}), 6, "TB-VERIFY-NOT-ENDED");
}

TEST_CASE("verify: reports deleted verdicts, fits and approvals with exit code 5") {
  const TemporaryFolder folder;
  prepare_store(folder);
  REQUIRE(call(folder, {"report", "sign", "1", "--by", "C. Chief"}).code == 0);
  CHECK(call(folder, {"verify"}).code == 0);
  change(folder, "DELETE FROM verdicts; DELETE FROM reports");
  CHECK(call(folder, {"verify", "2"}).code == 5);
  CHECK(call(folder, {"verify"}).code == 5);
  const json document = json::parse(call(folder, {"verify", "--json"}).out);
  CHECK(document["runs"][1]["holds"] == false);
  CHECK(document["runs"][1]["difference"] == "");
  CHECK(document["runs"][1]["beside"].size() == 1);
}

TEST_CASE("store: with foreign objects it is checked and read, but not written") {
  const TemporaryFolder folder;
  prepare_store(folder);
  check_refusal(call(folder, {"runs", "note", "1", std::string(10'001, 'x')}), 2, "TB-STORE-TOO-LONG");
  check_refusal(call(folder, {"runs", "note", "1", " "}), 2, "TB-STORE-BLANK");
  change(folder, "CREATE TRIGGER evil AFTER INSERT ON runs BEGIN DELETE FROM verdicts; END");
  CHECK(call(folder, {"verify"}).code == 5);
  CHECK(call(folder, {"runs", "list"}).code == 0);
  check_refusal(call(folder, {"runs", "note", "1", "x"}), 5, "TB-STORE-FOREIGN");
  check_refusal(
      call(folder, {"run", "small.toml", "--bench", "bench.toml", "--sensor", "S-1", "--operator", "t", "-q"}), 5,
      "TB-STORE-FOREIGN");
}

TEST_CASE("store: a damaged stored model is reported as a store error, not as an internal error") {
  const TemporaryFolder folder;
  prepare_store(folder);
  write_file(folder.path("t.csv"), "taxel,output\n5,1.0\n5,1.5\n");
  REQUIRE(call(folder, {"compensate", "1", "t.csv"}).code == 0);
  const auto read_with = [&](const std::string& damage, const std::string& repair) {
    change(folder, damage);
    for (const std::vector<std::string>& words : {std::vector<std::string>{"compensate", "1", "t.csv"},
                                                  {"model", "show", "1"},
                                                  {"report", "1", "-o", "r.html"}}) {
      INFO(damage << " " << words.front());
      check_refusal(call(folder, words), 5, "TB-MODEL-STORED");
    }
    if (!repair.empty()) change(folder, repair);
  };
  const std::string negative =
      "UPDATE fits SET document = json_set(document, '$.taxels[5].noise', -json_extract(document, "
      "'$.taxels[5].noise'))";
  read_with(negative, negative);
  CHECK(call(folder, {"compensate", "1", "t.csv"}).code == 0);
  read_with("UPDATE fits SET document = replace(document, '\"rows\":16', '\"rows\":99999')",
            "UPDATE fits SET document = replace(document, '\"rows\":99999', '\"rows\":16')");
  const std::string deep = "replace(hex(zeroblob(500000)), '0', '[')";
  read_with("UPDATE fits SET document = " + deep + " || document",
            "UPDATE fits SET document = substr(document, 1000001)");
  change(folder, "UPDATE checks SET detail_json = " + deep);
  CHECK(call(folder, {"runs", "show", "1", "--json"}).code == 0);
  CHECK(call(folder, {"compensate", "1", "t.csv"}).code == 0);
  read_with(
      "UPDATE fits SET document = json_set(document, '$.taxels[5].model.descending', "
      "json_extract(document, '$.taxels[7].model.descending'))",
      "");
}

TEST_CASE("runs: are tagged, noted, voided and found by these") {
  const TemporaryFolder folder;
  prepare_store(folder);
  const auto listed = [&](std::vector<std::string> words) {
    words.insert(words.begin(), {"runs", "list", "--json"});
    std::vector<int> runs;
    const json document = json::parse(well(call(folder, words)).out);
    for (const json& run : document["runs"]) runs.push_back(run["run"].get<int>());
    return runs;
  };
  using Runs = std::vector<int>;
  CHECK(call(folder, {"runs", "tag", "2", "night", "bench:a"}).code == 0);
  CHECK(call(folder, {"runs", "note", "2", "the door was open"}).code == 0);
  CHECK(listed({"--tag", "night"}) == Runs{2});
  CHECK(listed({"--tag", "nigh"}).empty());
  CHECK(listed({"--sensor", "S-1"}) == Runs{1, 2});
  CHECK(listed({"--sensor", "S-2"}).empty());
  CHECK(listed({"--verdict", "pass"}) == Runs{1, 2});  // the models' run, and the one that they were judged on
  CHECK(listed({"--verdict", "none"}).empty());
  CHECK(listed({"--verdict", "fail"}).empty());
  check_refusal(call(folder, {"runs", "tag", "2", "two words"}), 2, "TB-STORE-TAG");
  check_refusal(call(folder, {"runs", "void", "2", "--by", "me"}), 2, "TB-USAGE");
  CHECK(call(folder, {"runs", "void", "2", "--reason", "door open", "--by", "me"}).code == 0);
  check_refusal(call(folder, {"runs", "void", "2", "--reason", "again", "--by", "me"}), 5, "TB-STORE-CONFLICT");
  CHECK(listed({}) == Runs{1});
  CHECK(listed({"--all"}) == Runs{1, 2});
  CHECK(json::parse(call(folder, {"runs", "show", "2", "--json"}).out)["void_by"] == "me");
  CHECK(call(folder, {"verify", "2"}).code == 0);  // none of this is content
  check_refusal(call(folder, {"runs", "note", "2", "x", "--db", "none.db"}), 5, "TB-STORE-OPEN");
  CHECK_FALSE(std::filesystem::exists(folder.path("none.db")));
}

TEST_CASE("runs: are compared, and copied into another store") {
  const TemporaryFolder folder;
  prepare_store(folder);
  CHECK(call(folder, {"runs", "diff", "1", "1"}).code == 0);
  CHECK(call(folder, {"runs", "diff", "1", "2"}).code == 1);
  check_refusal(call(folder, {"runs", "export", "1", "--format", "xml", "-o", "x"}), 2, "TB-USAGE");
  check_refusal(call(folder, {"runs", "export", "9", "-o", "x"}), 2, "TB-STORE-NOT-FOUND");
  well(call(folder, {"runs", "copy", "2", "1", "--to", "archive.db"}));
  for (const char* run : {"1", "2"}) CHECK(call(folder, {"verify", run, "--db", "archive.db"}).code == 0);
  CHECK(call(folder, {"verify", "--db", "archive.db"}).code == 0);
  CHECK(call(folder, {"runs", "copy", "1", "--to", "models.db"}).code == 0);
  check_refusal(call(folder, {"runs", "copy", "1", "--to", "archive.db"}), 2, "TB-STORE-EXISTS");
  check_refusal(call(folder, {"runs", "copy", "9", "--to", "new.db"}), 2, "TB-STORE-NOT-FOUND");
  CHECK_FALSE(std::filesystem::exists(folder.path("new.db")));
}

TEST_CASE("metadata: lot, order and key=value are stored, shown, found, exported and printed in the report") {
  const TemporaryFolder folder;
  begin_bench(folder);
  run_recipe(folder, "small.toml", {"--lot", "A7", "--order", "55/26", "--meta", "film=B12", "--meta", "station=left"});
  run_recipe(folder, "small.toml");
  const auto found = [&](const std::vector<std::string>& more) {
    return json::parse(call(folder, joined({"runs", "list", "--json"}, more)).out).at("runs").size();
  };
  CHECK(found({}) == 2);
  CHECK(found({"--lot", "A7"}) == 1);
  CHECK(found({"--order", "55/26", "--meta", "station=left"}) == 1);
  CHECK(found({"--meta", "film"}) == 1);
  CHECK(found({"--lot", "A8"}) == 0);
  CHECK(found({"--meta", "film=B13"}) == 0);
  // The same seeds give the same run, whatever lot it is of.
  CHECK_THAT(well(call(folder, {"runs", "diff", "1", "2"})).out, Catch::Contains("metadata.lot"));
  REQUIRE(call(folder, {"runs", "export", "1", "-o", "1.csv"}).code == 0);
  CHECK_THAT(read_file(folder.path("1.csv")), Catch::Contains("\n# metadata lot: A7\n"));
  REQUIRE(call(folder, {"runs", "export", "1", "--format", "json", "-o", "1.json"}).code == 0);
  CHECK(json::parse(read_file(folder.path("1.json"))).at("metadata").at("film") == "B12");
  REQUIRE(call(folder, {"report", "1"}).code == 0);
  CHECK(call(folder, {"verify", "1"}).code == 0);
  // Corrected later: a key has one value.
  REQUIRE(call(folder, {"runs", "tag", "1", "lot=A8"}).code == 0);
  CHECK(found({"--lot", "A7"}) == 0);
  CHECK(found({"--lot", "A8"}) == 1);
  CHECK(call(folder, {"verify", "1"}).code == 0);
}

// db prune on a night: what goes, what stays, and what verbs say of it afterwards.

using namespace tactbench;

namespace {

const char* const kNight = R"(schema = 1
name = "small"
[[scenario]]
name = "short"
about = "a fit"
recipes = ["production"]
held_out = []
)";

nlohmann::json json_printed_by(const Finished& finished) {
  INFO(finished.out << finished.err);
  return nlohmann::json::parse(finished.out);
}

}  // namespace

TEST_CASE(
    "db prune: removes frames of old nights, verify reports it, report and fit are rejected, trend is unchanged") {
  const TemporaryFolder folder;
  write_file(folder.path("small.toml"), kNight);
  const auto night = [&](const std::vector<std::string>& more) {
    return call(folder, joined({"nightly", "./small.toml", "--db", "night.db", "--json"}, more));
  };
  REQUIRE(night({"--seeds", "3"}).code == 0);
  REQUIRE(call(folder, {"runs", "tag", "3", "pinned", "--db", "night.db"}).code == 0);
  const std::string trend = call(folder, {"trend", "--db", "night.db"}).out;
  const auto prune = [&](const std::vector<std::string>& more) {
    return call(folder, joined({"db", "prune", "--db", "night.db"}, more));
  };
  // Nothing is old yet, and nothing is done without --yes.
  CHECK(json_printed_by(prune({"--keep", "1d", "--yes", "--json"})).at("runs").empty());
  CHECK(prune({"--keep", "2999-01-01"}).code == 0);
  CHECK(call(folder, {"verify", "1", "--db", "night.db"}).code == 0);
  const nlohmann::json done = json_printed_by(prune({"--keep", "2999-01-01", "--yes", "--shrink", "--json"}));
  CHECK(done.at("runs") == std::vector<int>{1, 2, 5, 6});
  CHECK(done.at("file_bytes").get<double>() < 0.7 * done.at("file_bytes_before").get<double>());

  CHECK(call(folder, {"trend", "--db", "night.db"}).out == trend);
  CHECK(call(folder, {"verify", "1", "--db", "night.db"}).code == 6);
  CHECK(json_printed_by(call(folder, {"verify", "2", "--db", "night.db", "--json"})).at("pruned").at("frames") > 0);
  CHECK(call(folder, {"verify", "3", "--db", "night.db"}).code == 0);
  for (const std::vector<std::string>& words :
       std::vector<std::vector<std::string>>{{"report", "1", "-o", "r.html"},
                                             {"fit", "1"},
                                             {"runs", "export", "1", "-o", "r.csv"},
                                             {"runs", "export", "1", "--format", "json", "-o", "r.json"}}) {
    INFO(words.front());
    check_refusal(call(folder, joined(words, {"--db", "night.db"})), 2, "TB-STORE-PRUNED");
  }
  CHECK(call(folder, {"verify", "--db", "night.db"}).code == 0);
  // The next night is still compared, frame by frame, with one whose frames are gone.
  const nlohmann::json next = json_printed_by(night({"--seed", "1"}));
  CHECK_THAT(next.at("scenarios").at(0).at("compared").get<std::string>(), Catch::EndsWith(" 1"));  // run 1
  CHECK(next.at("scenarios").at(0).at("remarks").empty());
  CHECK(call(folder, {"runs", "copy", "1", "2", "--db", "night.db", "--to", "copy.db"}).code == 0);
  CHECK(call(folder, {"verify", "1", "--db", "copy.db"}).code == 6);
}

// runs list: --verdict takes each word that a run is shown with.

namespace {

using RunNumbers = std::vector<std::int64_t>;

void add_judged_run(db::RunStore& store, const std::string& origin, const std::string& verdict) {
  db::RunRecord record = example_run();
  record.origin = origin;
  const std::int64_t run = store_example(store, record);
  db::VerdictRecord row{run, 0, "unfit_taxels", "array", 1.0, 1.5, "taxels", "simple", verdict, "limits", "sha"};
  if (!verdict.empty()) store.replace_verdicts(run, 0, {row});
}

}  // namespace

TEST_CASE("runs list: --verdict accepts each verdict and finds the runs with it") {
  const TemporaryFolder folder;
  {
    db::RunStore store = db::RunStore::open(folder.path("runs.db"), db::Durability::kNormal);
    for (const char* origin : {"simulated", "hardware"}) {
      for (const std::string& word : analysis::verdict_names()) add_judged_run(store, origin, word);
      add_judged_run(store, origin, "");
    }
  }
  const auto listed = [&](const std::string& word) {
    const auto document = nlohmann::json::parse(well(call(folder, {"runs", "list", "--json", "--verdict", word})).out);
    RunNumbers runs;
    for (const auto& run : document["runs"]) runs.push_back(run["run"].get<std::int64_t>());
    return runs;
  };
  std::map<std::int64_t, std::string> shown;
  const auto all = nlohmann::json::parse(call(folder, {"runs", "list", "--json"}).out);
  for (const auto& run : all.at("runs")) shown[run.at("run")] = run.at("verdict");
  REQUIRE(shown.size() == 12);
  CHECK(shown.at(2) == "simulated conditional pass");
  CHECK(shown.at(6) == "-");
  CHECK(shown.at(8) == "conditional pass");
  for (const auto& [number, word] : shown) {
    RunNumbers same;  // without "simulated" those of every origin
    for (const auto& [other, its_word] : shown)
      if (its_word == word || its_word == "simulated " + word) same.push_back(other);
    CHECK(listed(word) == same);
  }
  CHECK(listed("none") == RunNumbers{6, 12});
  CHECK(listed("conditional-fail") == RunNumbers{3, 9});
  CHECK(listed("simulated-inconclusive") == RunNumbers{4});
  for (const char* wrong : {"good", "report only", "conditional", "condtional pass"}) {
    INFO(wrong);
    check_refusal(call(folder, {"runs", "list", "--verdict", wrong}), 2, "TB-USAGE", "--verdict");
  }
}
