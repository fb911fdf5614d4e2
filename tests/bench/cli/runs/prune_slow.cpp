// db prune on a night: what goes, what stays, and what verbs say of it afterwards.
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "db/run_store.h"
#include "tests/bench/cli/check_refusal.h"

using namespace tactbench;
using namespace tactbench::tests;

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

TEST_CASE("the frames of old nights are removed by a rule, and verify, report and the next night know it") {
  const TemporaryFolder folder;
  write_file(folder.path("small.toml"), kNight);
  const auto night = [&](const std::vector<std::string>& more) {
    return call(folder, joined_words({"nightly", "./small.toml", "--db", "night.db", "--json"}, more));
  };
  REQUIRE(night({"--seeds", "3"}).code == 0);
  REQUIRE(call(folder, {"runs", "tag", "3", "pinned", "--db", "night.db"}).code == 0);
  const std::string trend = call(folder, {"trend", "--db", "night.db"}).out;
  const auto prune = [&](const std::vector<std::string>& more) {
    return call(folder, joined_words({"db", "prune", "--db", "night.db"}, more));
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
    check_refusal(call(folder, joined_words(words, {"--db", "night.db"})), 2, "TB-STORE-PRUNED");
  }
  CHECK(call(folder, {"verify", "--db", "night.db"}).code == 0);
  // The next night is still compared, frame by frame, with one whose frames are gone.
  const nlohmann::json next = json_printed_by(night({"--seed", "1"}));
  CHECK_THAT(next.at("scenarios").at(0).at("compared").get<std::string>(), Catch::EndsWith(" 1"));  // run 1
  CHECK(next.at("scenarios").at(0).at("remarks").empty());
  CHECK(call(folder, {"runs", "copy", "1", "2", "--db", "night.db", "--to", "copy.db"}).code == 0);
  CHECK(call(folder, {"verify", "1", "--db", "copy.db"}).code == 6);
}
