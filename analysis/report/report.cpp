#include "analysis/report/report.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "analysis/error.h"
#include "analysis/report/data/data.h"
#include "analysis/report/dcc/dcc.h"
#include "analysis/report/document/document.h"
#include "analysis/report/page/page.h"
#include "analysis/report/report_facts.h"
#include "analysis/report/sections/sections.h"
#include "db/run_store.h"

namespace tactbench::analysis {
namespace {

// Content (docs/rules.md, Runs) is everything except UUID, wall-clock times, host, tags, notes. The run's number is
// also left out, because the same run has another number in another store.
void keep_content_only(db::RunRecord& run) {
  run.run = 0;
  run.rest_s.reset();
  for (std::string* field : {&run.uuid, &run.started_utc, &run.ended_utc, &run.host, &run.time_zone}) field->clear();
}

// What identifies the item and the measurement, without names, times and host.
ReportInput content_of(const ReportInput& input) {
  ReportInput content = input;
  keep_content_only(content.run);
  for (HeldOut& held_out : content.held_out) keep_content_only(held_out.run);
  for (db::RunRecord& run : content.further) keep_content_only(run);
  content.history.earlier_seating_run = 0;
  content.approvals.clear();
  content.reason.clear();
  if (content.sensor) {
    content.sensor->note.clear();
    content.sensor->added_utc.clear();
  }
  return content;
}

// Figures and verdicts; names runs only in typed texts.
std::string results_text(const ReportInput& input) {
  using Writer = std::string (*)(const ReportInput&);
  static constexpr std::pair<const char*, Writer> kSections[] = {
      {"health", health_json},   {"raw", behaviour_json},   {"as_found", as_found_json},
      {"studies", studies_json}, {"objects", objects_json}, {"uncertainty", uncertainty_json}};
  std::string text = "\"results\":";
  text.reserve(std::size_t{1} << 20);  // its usual size
  text += results_json(input);
  text += ",\n\"sections\":{";
  for (const auto& [name, write] : kSections) {
    text += fmt::format("{}\"{}\":", text.ends_with('{') ? "" : ",\n", name);
    text += write(input);
  }
  return text + '}';
}

std::string content_hash(const ReportInput& input, const std::string& results) {
  return db::sha256_hex(results + identification_json(content_of(input)));
}

const char* document_name(const ReportInput& input) {
  return is_certificate(input)       ? "Calibration certificate"
         : states_uncertainty(input) ? "Calibration report"
                                     : "Test report";
}

Issue issue_of(const ReportInput& input, const Report& report) {
  const std::string& number = report.number;
  Issue issue;
  issue.number = number;
  issue.content_sha256 = report.content_sha256;
  issue.document = document_name(input);
  const auto own = std::ranges::find(input.approvals, number, &db::ReportRecord::number);
  if (own != input.approvals.end()) {
    issue.authorised_by = own->approved_by;
    issue.authorised_utc = own->approved_utc;
    issue.replaces = own->replaces;
    issue.reason = own->reason;
  } else if (!input.approvals.empty()) {
    issue.replaces = input.approvals.back().number;
    issue.reason = input.reason;
  }
  issue.issued = !input.issued.empty() ? input.issued : issue.authorised_utc.substr(0, 10);
  return issue;
}

Page page_frame(const ReportInput& input, const Issue& issue) {
  Page page;
  page.document = issue.document;
  page.number = issue.number;
  page.title = issue.draft() ? issue.number : signed_title_mark(issue.number);
  page.state = issue.draft() ? "draft, not issued" : "issued " + issue.issued;
  page.simulated = is_simulated(input);
  page.paper = input.paper;
  return page;
}

// In a calibration report the second page starts a new page; then the parts follow each other, and unbreakable tables
// and figures move to the next page if necessary.
doc::Document body_of(const PageData& data) {
  doc::Document body = front_page(data);
  const bool calibrated = data.readings.has_value();
  const auto add = [&](doc::Document part, bool begins_page) {
    if (part.blocks.empty()) return;
    if (begins_page) body.add(doc::PageBreak{});
    body.add(std::move(part));
  };
  add(item_and_instruments(data), calibrated);
  add(method_page(data), false);
  if (calibrated) add(contact_pages(data), false);  // else on page 1
  add(levels_page(data), false);
  add(array_page(data), false);
  add(studies_pages(data), false);
  add(budget_page(data), false);
  for (const std::string& name : data.input.annexes) add(annex(data, name), false);
  body.add(doc::Paragraph{{doc::strong(fmt::format("End of {} {}", data.issue.document, data.issue.number))}});
  return body;
}

}  // namespace

bool is_signed(const ReportInput& input, const std::string& number) {
  return std::ranges::find(input.approvals, number, &db::ReportRecord::number) != input.approvals.end();
}

std::string signed_title_mark(const std::string& number) { return number + ", signed"; }

Report render_report(const ReportInput& input) {
  Report report;
  const std::string results = results_text(input);
  report.content_sha256 = content_hash(input, results);
  report.number = fmt::format("{}-{}", input.run.run, report.content_sha256.substr(0, 8));
  const Issue issue = issue_of(input, report);
  const std::string head = fmt::format(
      "{{\"schema\":\"tactbench.report\",\"version\":3,\"document\":\"{}\",\"number\":\"{}\",\"content_sha256\":\"{}\","
      "\"replaces\":{},\"reason\":{}",
      issue.document, report.number, report.content_sha256, json_text(issue.replaces), json_text(issue.reason));
  report.json = head + ",\"identification\":" + identification_json(input) + ",\n" + results + '}';
  Page page = page_frame(input, issue);
  const PageData data{input, reading_figures(input), issue};
  page.body = to_html(body_of(data), input.unit);
  // Identifies the report in the file: another report of the same run may replace it, a report of another store's run
  // may not.
  const std::string short_data = fmt::format("{},\"identification\":{{\"run_uuid\":{},\"approvals\":{}}}}}", head,
                                             json_text(input.run.uuid), approvals_json(input));
  page.json = short_data;
  report.html = page_of(page);
  return report;
}

std::string render_dcc(const ReportInput& input, const Report& report) {
  if (const std::string lacking = dcc_lacks(input); !lacking.empty())
    throw AnalysisError("TB-REPORT-DCC", fmt::format("a digital calibration certificate needs {}", lacking),
                        input.laboratory.sha256.empty() ? "name a laboratory file that states it: --lab lab.toml"
                                                        : "state it there, or take another format");
  return dcc_of({input, {}, issue_of(input, report)});
}

}  // namespace tactbench::analysis
