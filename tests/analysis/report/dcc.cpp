// A made-up report as a digital calibration certificate: what it needs, excluded taxels, verdicts and their absence,
// who signed, hostile text. That real reports agree with their data and with the schema: tests/docs/certificate.py.
#include "analysis/report/dcc/dcc.h"

#include <catch2/catch.hpp>
#include <pugixml.hpp>
#include <sstream>

#include "analysis/error.h"
#include "tests/analysis/report/report_example.h"

using namespace tactbench;
using namespace tactbench::analysis;

namespace {

ReportInput certified() {
  ReportInput input = example::full_input();
  input.laboratory.country = "DE";
  input.laboratory.city = "Sample Town";
  input.laboratory.customer_address = " 1 Sample Street ";
  input.uncertainty->conditions.front().factor = 2.25;
  return input;
}

struct Certificate {
  explicit Certificate(const ReportInput& input) {
    report = render_report(input);
    text = render_dcc(input, report);
    REQUIRE(document.load_string(text.c_str()));
  }
  [[nodiscard]] std::string at(const char* path) const { return document.select_node(path).node().text().get(); }
  [[nodiscard]] std::size_t count(const char* path) const { return document.select_nodes(path).size(); }
  Report report;
  std::string text;
  pugi::xml_document document;
};

std::vector<std::string> words_of(const pugi::xml_node& node) {
  std::istringstream words(node.text().get());
  return {std::istream_iterator<std::string>(words), {}};
}

}  // namespace

TEST_CASE("DCC: every taxel is listed at every level, and is NaN in error, U and k without a model") {
  const ReportInput input = certified();
  const Certificate made(input);
  const ConditionUncertainty& kind = input.uncertainty->conditions.front();
  CHECK(made.count("//dcc:result[dcc:name/dcc:content='Gauge pressure, increasing']") == 1);
  CHECK(made.count("//dcc:result[dcc:name/dcc:content='Gauge pressure, decreasing']") == 1);
  const pugi::xpath_node_set levels = made.document.select_nodes("//dcc:quantity[@refType='basic_measurementError']");
  REQUIRE(levels.size() == kind.pressure_psi.size());
  for (std::size_t i = 0; i < levels.size(); ++i)
    for (const auto& [list, own] : {std::pair(".//si:valueXMLList", &kind.error_psi),
                                    {".//si:valueExpandedMUXMLList", &kind.expanded_psi},
                                    {".//si:coverageFactorXMLList", nullptr}}) {
      const std::vector<std::string> words = words_of(levels[i].node().select_node(list).node());
      REQUIRE(words.size() == 256);
      for (std::size_t taxel = 0; taxel < 256; ++taxel) {
        if (!input.fit.taxels[taxel].fitted()) {
          CHECK(words[taxel] == "NaN");
        } else {
          const double expected = own == nullptr ? 2.25 : 6.894757 * (*own)[i * 256 + taxel];
          CHECK(std::stod(words[taxel]) == Approx(expected).epsilon(1e-3).margin(1e-12));
        }
      }
    }
}

TEST_CASE("DCC: missing statements of the report are named, and a test report is refused") {
  ReportInput input = certified();
  CHECK(dcc_lacks(input).empty());
  const auto lacking = [&](std::string Laboratory::*field) {
    ReportInput less = input;
    less.laboratory.*field = " ";
    return dcc_lacks(less);
  };
  for (const auto& [field, key] : {std::pair(&Laboratory::laboratory, "laboratory"),
                                   {&Laboratory::country, "country"},
                                   {&Laboratory::city, "city"},
                                   {&Laboratory::customer, "customer"},
                                   {&Laboratory::customer_address, "customer_address"}})
    CHECK(contains(lacking(field), key));
  ReportInput undated = input, unnamed = input, without_u = input;
  undated.run.started_utc = "yesterday";
  for (HeldOut& held_out : undated.held_out) held_out.run.started_utc.clear();
  unnamed.run.sensor_serial.clear();
  without_u.uncertainty.reset();
  for (const ReportInput& less : {undated, unnamed, without_u}) {
    CHECK_FALSE(dcc_lacks(less).empty());
    try {
      (void)render_dcc(less, render_report(less));
      FAIL("it was made");
    } catch (const AnalysisError& error) {
      CHECK(error.id() == "TB-REPORT-DCC");
    }
  }
}

TEST_CASE("verdicts of a DCC: the schema's four words, or a reason for a verdict without such a word") {
  ReportInput input = certified();
  std::vector<JudgedFigure> figures;
  for (const Verdict verdict : {Verdict::kPass, Verdict::kConditionalPass, Verdict::kConditionalFail, Verdict::kFail,
                                Verdict::kInconclusive, Verdict::kReportOnly})
    figures.push_back(by_hand::judged_figure(12, Criterion::kMeanError, 0.5, 1.0, verdict));
  figures.front().u.expanded = 0.25;
  figures.front().u.factor = 2.0;
  input.more.previous.reset();
  input.judgement = by_hand::judgement_of(figures);
  const auto stated = [](const Certificate& made) {
    std::vector<std::string> words;
    for (const pugi::xpath_node& one : made.document.select_nodes("//dcc:metaData")) {
      words.emplace_back(one.node().child("dcc:conformity").text().get());
      CHECK(words.back().empty() == !one.node().child("dcc:declaration").empty());
    }
    return words;
  };
  const Certificate made(input);
  CHECK(stated(made) == std::vector<std::string>{"pass", "conditionalPass", "conditionalFail", "fail", "", ""});
  CHECK(made.at("//dcc:statement[@refType='basic_conformity']/dcc:conformity") == "fail");
  CHECK(std::stod(made.at("//dcc:quantity[dcc:measurementMetaData]/si:real/si:value")) == Approx(0.5 * 6.894757));
  CHECK(std::stod(made.at("//si:valueExpandedMU")) == Approx(0.25 * 6.894757).epsilon(1e-3));
  CHECK(std::stod(made.at("//dcc:quantity[@refType='basic_toleranceLimitUpper']//si:value")) == Approx(6.894757));

  input.judgement.not_judged = Remark{};
  CHECK(stated(Certificate(input)) == std::vector<std::string>(6));
  input.judgement = {};
  CHECK(Certificate(input).count("//dcc:conformity") == 0);
}

TEST_CASE("DCC: as found and as left are two results with their states") {
  const Certificate made(certified());
  CHECK(made.count("//dcc:measurementResult[.//dcc:status='beforeAdjustment']//dcc:metaData") == 5);
  CHECK(made.count("//dcc:measurementResult[.//dcc:status='afterAdjustment']//dcc:metaData") == 5);
}

TEST_CASE("DCC: the identifier states simulated and draft, and a later report states which one it replaces") {
  ReportInput input = certified();
  const auto identifier = [](const Certificate& made) { return made.at("//dcc:uniqueIdentifier"); };
  const Certificate draft(input);
  CHECK(identifier(draft) == "SIMULATED-DRAFT-" + draft.report.number);
  CHECK(draft.count("//dcc:statement[@refType='tb_simulated']") == 1);
  input.approvals = {
      {12, draft.report.number, "", "C. Chief", "2024-05-07T00:00:00Z", "12-0000000a", "name corrected"}};
  const Certificate issued(input);
  CHECK(identifier(issued) == "SIMULATED-" + draft.report.number);
  CHECK(issued.at("//dcc:respPerson//dcc:content") == "C. Chief");
  CHECK(issued.at("//dcc:issueDate") == "2024-05-07");
  CHECK(issued.at("//dcc:replacedUniqueIdentifier") == "SIMULATED-12-0000000a");
  CHECK(contains(issued.text, signed_title_mark(draft.report.number)));
  input.run.origin = "hardware";
  for (HeldOut& held_out : input.held_out) held_out.run.origin = "hardware";
  const Certificate real(input);
  CHECK_FALSE(contains(real.text, "SIMULATED"));
  CHECK(real.count("//dcc:statement[@refType='tb_simulated']") == 0);
}

TEST_CASE("DCC: markup, control characters and blanks in typed texts remain text") {
  for (const std::string& hostile : {std::string("</dcc:content><x y=\"1\">&amp;]]>"), std::string("a\x01\x1b\0b", 5),
                                     std::string("\n \t two  words \r\n"), std::string(" ")}) {
    ReportInput input = certified();
    for (std::string Laboratory::*field :
         {&Laboratory::address, &Laboratory::environment, &Laboratory::mounting, &Laboratory::medium,
          &Laboratory::deviations, &Laboratory::postcode, &Laboratory::signer_function, &Laboratory::order})
      input.laboratory.*field = hostile;
    for (db::DeviceRecord& device : input.run.devices) device.model = device.serial = device.role = hostile;
    input.method = {hostile};
    input.sensor->type = hostile;
    const Certificate made(input);
    CHECK(made.count("//x") == 0);
    for (const pugi::xpath_node& one : made.document.select_nodes("//dcc:content|//dcc:model|//dcc:value|//dcc:role")) {
      const std::string text = one.node().text().get();
      REQUIRE_FALSE(text.empty());
      CHECK_FALSE(std::isspace(static_cast<unsigned char>(text.front())));
      CHECK_FALSE(std::isspace(static_cast<unsigned char>(text.back())));
    }
  }
}
