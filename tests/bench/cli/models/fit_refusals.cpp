// What fit refuses of its words, and how runs and sources are named.

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "bench/cli/models/fit_many.h"
#include "bench/cli/runs/source.h"
#include "tests/bench/cli/verb_here.h"
#include "tests/db/store_example.h"

using namespace tactbench;
using namespace tactbench::tests;

namespace {

using FitWords = std::vector<std::string>;

void check_fit_refused(const FitWords& words, const std::string& id, const std::string& place) {
  const Finished finished = verb_here(bench::add_fit, joined_words({"fit"}, words));
  CAPTURE(words);
  CHECK(finished.code == 2);
  CHECK_THAT(finished.err, Catch::Contains("[" + id + "]\n  at: " + place + "\n"));
  CHECK(finished.out.empty());
}

std::string loop_rows(const std::string& head) {
  return head + "\n0,0\n1,1.5\n2,2.5\n3,4\n2,3.5\n1,2\n0,0.1\n1,1.4\n2,2.6\n1,2.1\n0,0\n";
}

}  // namespace

TEST_CASE("fit: models are named by their words, and the dynamic one alone with its own options") {
  const std::vector<std::pair<FitWords, std::string>> refused = {
      {{"1", "--model", "elamm"}, "--model"},
      {{"1", "--model", ","}, "--model"},
      {{"1", "--model", "elam,mpi"}, "--model"},
      {{"1", "--model", "elam", "--rate", "2"}, "fit"},
      {{"1", "--model", "elam", "--creep", "2"}, "fit"},
      {{"1", "--rate", "2"}, "fit"},
      {{"1", "--creep", "2"}, "fit"},
      {{"1", "--model", "dynamic", "--mode", "paper"}, "fit"},
      {{"1", "--model", "dynamic", "--identify", "exact"}, "fit"},
      {{"1", "--model", "dynamic", "--linearise"}, "fit"},
      {{"1", "--model", "dynamic", "--memory"}, "fit"},
      {{"1", "--model", "dynamic", "--exact-outer"}, "fit"},
      {{"1", "--model", "dynamic", "--splits", "1"}, "fit"},
      {{"1", "--model", "dynamic", "--starts", "1"}, "fit"},
      {{"1", "--model", "dynamic", "--fit", "up"}, "fit"},
      {{"1", "--model", "dynamic", "--mean-taxel"}, "fit"},
      {{"t.csv", "--rate", "2", "--creep", "3"}, "fit"},
      {{"1-2", "-o", "m.json"}, "fit"},
      {{"1-2", "--score", "3"}, "fit"}};
  for (const auto& [words, place] : refused) check_fit_refused(words, "TB-USAGE", place);
  for (const FitWords& words : {FitWords{"compare", "1", "--models", "elam,elamm"},
                                {"compare", "1", "--models", "dynamic,elam"},
                                {"compare", "1-2"}})
    CHECK_THAT(verb_here(bench::add_compare, words).err, Catch::Contains("[TB-USAGE]"));
}

TEST_CASE("fit: several runs are numbers and ranges with commas between, and not judged") {
  for (const char* runs : {"1-2", "1,2", "3-3", "1,", "10-12,3", "1-1,1-1"}) {
    INFO(runs);
    CHECK(bench::names_runs(runs));
  }
  for (const char* other : {"", "1", "-", ",", "a-b", "2-1", "0-1", "1-2x", "1x-2", "1-2-3", "-1,2", "t-1.csv", "1-",
                            "1,x", "1 ,2", "99999999999999999999-1"}) {
    INFO(other);
    CHECK_FALSE(bench::names_runs(other));
  }
  const TemporaryFolder folder;
  const std::string path = folder.path("runs.db");
  {
    db::RunStore store = db::RunStore::open(path, db::Durability::kNormal);
    (void)store_example(store);  // run 1, void
    (void)begin_example(store);  // run 2 has not ended
    db::RunRecord bare = example_run();
    store.end_run(store.begin_run(bare), db::Outcome::kFailed, "", db::SafeState::kVerified, kUtc);  // without frames
    (void)store_example(store);                                                                      // run 4
    store.void_run(1, "x", "y", kUtc);
  }
  check_fit_refused({"1-3", "--db", path}, "TB-FIT-NONE", path);
  for (const bool void_too : {false, true}) {
    FitWords words = {"fit", "1-4", "--db", path, "--model", "elam", "--json"};
    if (void_too) words.emplace_back("--void-too");
    const Finished some = verb_here(bench::add_fit, words);
    CHECK(some.code == 6);  // the example holds no loop
    CHECK(nlohmann::json::parse(some.out).at("runs").size() == (void_too ? 2 : 1));
  }
}

TEST_CASE("fit: a table is not judged, not scored on itself, and each target is named once") {
  const TemporaryFolder folder;
  const std::string table = folder.path("t.csv"), other = folder.path("u.csv"), store = folder.path("runs.db");
  write_file(table, loop_rows("input,output"));
  write_file(other, loop_rows("input,output"));
  const auto said = [&](const FitWords& more) {
    const Finished finished = verb_here(bench::add_fit, joined_words({"fit", table, "--db", store, "-q"}, more));
    CHECK(finished.code == 2);
    return finished.err;
  };
  CHECK_THAT(said({"--score", other + "," + other}),
             Catch::Contains("[TB-RUN-TWICE]") && Catch::Contains("\n  at: --score\n"));
  CHECK_THAT(said({"--score", "01,1"}), Catch::Contains("[TB-RUN-TWICE]"));
  CHECK_THAT(said({"--score", table}), Catch::Contains("[TB-RUN-OWN]") && Catch::Contains("\n  at: --score\n"));
  CHECK_THAT(said({"--model", "elam", "--score", folder.path("none.csv")}), Catch::Contains("[TB-TABLE-OPEN]"));
}

TEST_CASE("sources: a run is named by up to eighteen digits, and a list by its commas") {
  for (const char* run : {"0", "12", "007", "999999999999999999"}) CHECK(bench::names_run(run));
  for (const char* other : {"", "1a", "-1", "1:2", "1.csv", "1000000000000000000"})
    CHECK_FALSE(bench::names_run(other));
  CHECK(bench::split_list("a,b") == FitWords{"a", "b"});
  CHECK(bench::split_list(",a,,b c,") == FitWords{"a", "b c"});
  CHECK(bench::split_list("").empty());
}
