// One vocabulary: what a verb says of a run, its figures and verdicts, an export and a report say in the same words.
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "tests/bench/cli/small_bench.h"

using namespace tactbench::tests;
using nlohmann::json;

namespace {

// Two runs of one sensor.
void measure_twice(const TemporaryFolder& folder) {
  begin_bench(folder);
  for (const char* seed : {"1", "2"}) measure_small(folder, seed);
}

json answer_of(const TemporaryFolder& folder, std::vector<std::string> words) {
  words.emplace_back("--json");
  return json::parse(well(call(folder, words)).out);
}

json document_of(const TemporaryFolder& folder, std::vector<std::string> words) {
  words.insert(words.end(), {"--format", "json", "-o", "document.json", "--replace"});
  well(call(folder, words));
  return json::parse(read_file(folder.path("document.json")));
}

// Each member of `part` is one of `whole`, with the same value; figures may differ in their last digit.
void check_within(const json& part, const json& whole, const std::string& at = {}) {
  for (const auto& [key, value] : part.items()) {
    const std::string place = at + "/" + key;
    INFO(place);
    const json::json_pointer own("/" + key);
    REQUIRE(whole.contains(own));
    if (value.is_structured()) {
      CHECK(value.size() <= whole.at(own).size());
      check_within(value, whole.at(own), place);
    } else if (value.is_number_float()) {
      CHECK(whole.at(own).get<double>() == Approx(value.get<double>()).epsilon(1e-12));
    } else {
      CHECK(whole.at(own) == value);
    }
  }
}

json without(json document, const std::vector<std::string>& keys) {
  for (const std::string& key : keys) document.erase(key);
  return document;
}

}  // namespace

TEST_CASE("JSON vocabulary: show, list, export, run, tag and report use the same keys and values for a run") {
  const TemporaryFolder folder;
  measure_twice(folder);
  json tagged = answer_of(folder, {"runs", "tag", "1", "night"});
  for (const char* own : {"schema", "version"}) tagged.erase(own);
  CHECK(tagged.size() == 36);
  CHECK(tagged["sensor"] == "S-1");
  CHECK(tagged["tags"] == json::array({"night"}));
  CHECK(tagged["recipes"][0]["sha256"].get<std::string>().size() == 64);
  CHECK(tagged["sensor_type_sha256"].get<std::string>().size() == 64);
  check_within(tagged, answer_of(folder, {"runs", "show", "1"}));
  check_within(tagged, answer_of(folder, {"runs", "list"})["runs"][0]);
  const json exported = document_of(folder, {"runs", "export", "1"});
  CHECK(exported["schema"] == "tactbench.run");
  CHECK(exported["version"] == 2);
  check_within(tagged, exported);

  REQUIRE(call(folder, {"fit", "1"}).code == 0);
  const json report = document_of(folder, {"report", "1"});
  CHECK(report["version"] == 3);
  const json& reported = report["identification"]["run"];
  check_within(without(tagged, {"tags", "notes"}), reported);
  CHECK_FALSE(reported.contains("tags"));
  CHECK(reported["devices"][0]["calibration"] == exported["devices"][0]["calibration"]);
  check_within(report["identification"]["sensor"], answer_of(folder, {"sensors", "show", "S-1"}));

  // An earlier report is still valid, and so is its signature.
  write_file(folder.path("old.json"),
             R"({"schema":"tactbench.report","version":1,"document":"Test report","number":"1-0123abcd",)"
             R"("identification":{"run":{"sensor_serial":"S-1"},"approvals":[{"number":"1-0123abcd"}]}})");
  const Finished refused = call(folder, {"report", "1", "--format", "json", "-o", "old.json"});
  CHECK(refused.code == 2);
  CHECK_THAT(refused.err, Catch::Contains("[TB-REPORT-SIGNED]") && Catch::Contains("1-0123abcd"));
}

TEST_CASE("JSON vocabulary: fit and report use the same keys and values for evaluations and verdicts") {
  const TemporaryFolder folder;
  measure_twice(folder);
  well(call(folder, {"fit", "1"}));
  const json fitted = answer_of(folder, {"judge", "1", "2", "--limits", "wide.toml"});
  const json results = document_of(folder, {"report", "1"})["results"];
  const std::vector<std::string> numbers = {"title", "run", "model_run", "shown"};
  REQUIRE(fitted["evaluations"].size() == 2);
  CHECK(fitted["evaluations"][1]["run"] == 2);
  CHECK(fitted["evaluations"][1]["model_run"] == 1);
  check_within(without(fitted["evaluations"][0], numbers), results["evaluation"]);
  check_within(without(fitted["evaluations"][1], numbers), results["held_out"][0]["evaluation"]);
  REQUIRE(fitted["verdicts"].size() == 4);
  REQUIRE(results["verdicts"].size() == 4);
  for (std::size_t i = 0; i < 4; ++i) {
    check_within(without(fitted["verdicts"][i], numbers), results["verdicts"][i]);
    CHECK(fitted["verdicts"][i]["shown"] == "simulated pass");
  }
  CHECK(results["judgement"]["overall"] == fitted["judgement"]["overall"]);
  const json shown = answer_of(folder, {"runs", "show", "2"});
  check_within(fitted["verdicts"], shown["verdicts"]);
}
