// Which parts of a report stand without models, and without a full loop to evaluate them on: each by its heading.
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>
#include <set>

#include "tests/analysis/report/report_example_full.h"

using namespace tactbench::analysis;

namespace {

// The ids of the parts whose first words are that they are not available for this reason.
std::set<std::string> not_available(const ReportInput& input, const std::string& why) {
  const std::string page = render_report(input).html;
  std::set<std::string> ids;
  const std::string words = "<p>not available: " + why + ".</p>";
  for (std::size_t at = page.find(words); at != std::string::npos; at = page.find(words, at + 1)) {
    const std::size_t heading = page.rfind("<h2 id=\"", at) + 8;
    ids.insert(page.substr(heading, page.find('"', heading) - heading));
  }
  return ids;
}

const std::set<std::string> kNeedAnEvaluation{"model", "models", "as-found", "compensation", "held-out", "uncertainty"};

}  // namespace

TEST_CASE("a report without models: the parts that need them say so, and the others stand") {
  ReportInput input = example::full_input();
  input.evaluation = {};
  CHECK(not_available(input, "the run sweeps no full loop to evaluate models on") == kNeedAnEvaluation);
  input.fit = {};
  CHECK(not_available(input, "no models were made from this run") == kNeedAnEvaluation);
  CHECK(not_available(example::full_input(), "no models were made from this run").empty());
}

TEST_CASE("a report's data: one member for each section that has data of its own, in the order of the page") {
  const auto json = nlohmann::ordered_json::parse(render_report(example::full_input()).json);
  std::vector<std::string> members;
  for (const auto& section : json["sections"].items()) members.push_back(section.key());
  CHECK(members ==
        std::vector<std::string>{"health", "raw", "models", "compensation", "studies", "objects", "uncertainty"});
  CHECK(json["schema"] == "tactbench.report");
  CHECK(json["version"] == 2);
}

TEST_CASE("a report's list of contents: each section by its id and title, in the order of the page") {
  const std::string page = render_report(example::full_input()).html;
  const std::pair<const char*, const char*> contents[] = {{"verdicts", "Statement of conformity"},
                                                          {"identification", "Identification"},
                                                          {"health", "Sensor health"},
                                                          {"raw", "Indication before correction"},
                                                          {"loops", "Loops"},
                                                          {"frames", "Frames"},
                                                          {"levels", "Levels"},
                                                          {"model", "ELAM"},
                                                          {"models", "Models compared"},
                                                          {"as-found", "As found, as left"},
                                                          {"compensation", "Single taxels"},
                                                          {"studies", "Further studies"},
                                                          {"objects", "Under objects"},
                                                          {"held-out", "Other runs"},
                                                          {"uncertainty", "Uncertainty"},
                                                          {"meaning", "Terms and limits"}};
  std::size_t in_contents = 0, in_page = page.find("<h2 ");
  for (const auto& [id, title] : contents) {
    INFO(id);
    const std::size_t entry = page.find(std::string("href=\"#") + id + "\">" + title, in_contents);
    REQUIRE(entry != std::string::npos);
    in_contents = entry;
    const std::size_t heading = page.find(std::string("<h2 id=\"") + id + "\"", in_page);
    REQUIRE(heading != std::string::npos);
    in_page = heading;
  }
}
