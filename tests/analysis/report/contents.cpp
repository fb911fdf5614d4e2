// The list of contents by the letter, and what a page without models or full loops says in the place of its sections.
#include <array>
#include <catch2/catch.hpp>
#include <memory>
#include <nlohmann/json.hpp>
#include <regex>
#include <string>
#include <utility>
#include <vector>

#include "tests/analysis/report/report_example.h"
#include "tests/analysis/report/report_example_full.h"
#include "tests/analysis/report/report_page.h"
#include "tests/analysis/support/models.h"

using namespace tactbench;
using namespace tactbench::analysis;

namespace {

using Entries = std::vector<std::pair<std::string, std::string>>;

// Where each entry of the list of contents leads, and what it is called.
Entries contents_of(const std::string& page) {
  const std::size_t from = page.find("<nav");
  REQUIRE(from != std::string::npos);
  const std::string list = page.substr(from, page.find("</nav>", from) - from);
  static const std::regex entry("<li><a href=\"#([^\"]*)\">([^<]*)</a></li>");
  Entries entries;
  for (std::sregex_iterator at(list.begin(), list.end(), entry), end; at != end; ++at)
    entries.emplace_back((*at)[1].str(), (*at)[2].str());
  return entries;
}

Entries entries_with(const char* model) {
  return {{"verdicts", "Statement of conformity"},
          {"identification", "Identification"},
          {"health", "Sensor health"},
          {"raw", "Indication before correction"},
          {"loops", "Loops"},
          {"frames", "Frames"},
          {"levels", "Levels"},
          {"model", model},
          {"models", "Models compared"},
          {"as-found", "As found, as left"},
          {"compensation", "Single taxels"},
          {"studies", "Further studies"},
          {"objects", "Under objects"},
          {"held-out", "Other runs"},
          {"uncertainty", "Uncertainty"},
          {"meaning", "Terms and limits"}};
}

// Sections that say that they are not available, in the words given.
std::vector<std::string> not_available(const std::string& page, const std::string& why) {
  std::vector<std::string> ids;
  for (const auto& [id, title] : contents_of(page)) {
    const std::size_t at = page.find("<h2 id=\"" + id + "\"");
    REQUIRE(at != std::string::npos);
    const std::string section = page.substr(at, page.find("<h2 ", at + 1) - at);
    if (contains(section, "<p>not available: " + why + ".</p>")) ids.push_back(id);
  }
  return ids;
}

const std::vector<std::string> kOfEvaluation = {"model",        "models",   "as-found",
                                                "compensation", "held-out", "uncertainty"};

}  // namespace

TEST_CASE("the list of contents calls the models ELAM where they are, and where there are none") {
  ReportInput input = example::example_input();
  CHECK(contents_of(render_report(input).html) == entries_with("ELAM"));
  input.fit.taxels.back().fit.model = std::make_shared<PreisachModel>(synthetic::random_preisach());
  input.fit.model = "preisach";
  input.evaluation.levels.clear();  // so that nothing of ELAM is asked for
  const std::string page = render_report(input).html;
  CHECK(contents_of(page) == entries_with("Models"));
  CHECK(not_available(page, "the run sweeps no full loop to evaluate models on") == kOfEvaluation);
  CHECK(not_available(page, "no models were made from this run").empty());
  input.fit.taxels.clear();
  const std::string without = render_report(input).html;
  CHECK(contents_of(without) == entries_with("ELAM"));
  CHECK(not_available(without, "no models were made from this run") == kOfEvaluation);
  CHECK(not_available(without, "the run sweeps no full loop to evaluate models on").empty());
}

TEST_CASE("a whole report's sections: in the order of the contents, and named when they lack models or an evaluation") {
  ReportInput input = example::full_input();
  const std::string page = render_report(input).html;
  CHECK(contents_of(page) == entries_with("ELAM"));
  std::size_t at = 0;
  for (const auto& [id, title] : contents_of(page)) {
    INFO(id);
    at = page.find("<h2 id=\"" + id + "\"", at);
    REQUIRE(at != std::string::npos);
  }
  CHECK(not_available(page, "no models were made from this run").empty());
  input.evaluation = {};
  CHECK(not_available(render_report(input).html, "the run sweeps no full loop to evaluate models on") == kOfEvaluation);
  input.fit = {};
  CHECK(not_available(render_report(input).html, "no models were made from this run") == kOfEvaluation);
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
