#include "analysis/report/report.h"

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <string_view>

#include "analysis/report/data/data.h"
#include "analysis/report/data/section_data.h"
#include "analysis/report/page/page.h"
#include "analysis/report/parts.h"
#include "analysis/report/sections/sections.h"
#include "db/run_store.h"

namespace tactbench::analysis {
namespace {

using html::markup;
using html::Markup;
using html::Text;

// Content (docs/rules.md, Runs) is everything but UUID, wall-clock times, host, tags, notes. The run's own number is
// left out too: it stands before the hash, and the same run in another store has another one.
void keep_content_only(db::RunRecord& run) {
  run.run = 0;
  run.rest_s.reset();
  for (std::string* field : {&run.uuid, &run.started_utc, &run.ended_utc, &run.host, &run.time_zone}) field->clear();
}

// Verdicts name their run by its place in the report: 0 the report's own, -1 the first held out.
void forget_verdicts_runs(ReportInput& content) {
  std::map<std::int64_t, std::int64_t> places;
  for (std::size_t i = 0; i < content.held_out.size(); ++i) {
    std::int64_t& number = content.held_out[i].evaluation.run;
    const auto place = -static_cast<std::int64_t>(i) - 1;
    places.emplace(number, place);
    number = place;
  }
  places[content.run.run] = 0;
  const auto move = [&](std::int64_t& run) {
    if (const auto known = places.find(run); known != places.end()) run = known->second;
  };
  Judgement& judgement = content.judgement;
  for (std::vector<JudgedFigure>* rows : {&judgement.figures, &judgement.stored_worse}) {
    for (JudgedFigure& figure : *rows) {
      move(figure.run);
      move(figure.model_run);
    }
  }
  for (JudgedRun& run : judgement.runs) move(run.run);
  for (std::int64_t& run : judgement.decided_by) move(run);
  for (VoidRun& run : judgement.void_counted) move(run.run);
  for (Remark& remark : judgement.remarks) {
    move(remark.run);
    move(remark.voided.run);
  }
}

ReportInput content_of(const ReportInput& input) {
  ReportInput content = input;
  forget_verdicts_runs(content);
  keep_content_only(content.run);
  forget_run_numbers(content.more);
  for (HeldOut& held_out : content.held_out) keep_content_only(held_out.run);
  for (db::RunRecord& run : content.further) keep_content_only(run);
  content.history.earlier_seating_run = 0;
  content.approvals.clear();
  content.reason.clear();
  content.unit = PressureUnit();
  if (content.sensor) {
    content.sensor->note.clear();
    content.sensor->added_utc.clear();
  }
  return content;
}

// The order of the page and of its list of contents: one line per section.
struct ReportPart {
  const char* id;     // of its heading
  const char* title;  // in the list of contents
  Markup (*write)(const ReportInput&);
  bool names_runs;  // numbers, times, hosts: written again without them for the content hash
  // The data behind the section as JSON in ASCII, member `id` of "sections"; null: they stand in "results". Names no
  // run.
  std::string (*data)(const ReportInput&) = nullptr;
  bool needs_evaluation = false;  // without one the part only says so
};

constexpr ReportPart kReportParts[] = {
    {"verdicts", "Statement of conformity", verdict_section, true},
    {"identification", "Identification", identification_section, true},
    {"health", "Sensor health", health_section, true, health_json},
    {"raw", "Indication before correction", raw_section, false, behaviour_json},
    {"loops", "Loops", loops_section, false},
    {"frames", "Frames", frames_section, false},
    {"levels", "Levels", levels_section, false},
    {"model", "ELAM", model_section, false, nullptr, true},
    {"models", "Models compared", models_section, false, models_json, true},
    {"as-found", "As found, as left", as_found_section, true, nullptr, true},
    {"compensation", "Single taxels", compensation_section, false, compensation_json, true},
    {"studies", "Further studies", studies_section, true, studies_json},
    {"objects", "Under objects", objects_section, true, objects_json},
    {"held-out", "Other runs", held_out_section, true, nullptr, true},
    {"uncertainty", "Uncertainty", uncertainty_section, false, uncertainty_json, true},
    {"meaning", "Terms and limits", meaning_section, false},
};

// The models are called ELAM only where they are.
const char* title_of(const ReportPart& part, const ReportInput& input) {
  const bool others = !input.fit.taxels.empty() && elam_of(input.fit.mean_taxel()) == nullptr;
  return others && std::string_view(part.id) == "model" ? "Models" : part.title;
}

Markup write_part(const ReportPart& part, const ReportInput& input) {
  if (!part.needs_evaluation || !input.evaluation.levels.empty()) return part.write(input);
  Markup out = section_start(part.id, part.title);
  out += markup("<p>not available: {}.</p>\n",
                Text(input.fit.taxels.empty() ? "no models were made from this run"
                                              : "the run sweeps no full loop to evaluate models on"));
  return out;
}

// The hash over the hashes of data, identification and each part, without concatenating them. The number is that of the
// page in kPa, whatever unit it is shown in.
std::string content_hash(const ReportInput& input, const std::vector<Markup>& parts, const std::string& results) {
  const ReportInput content = content_of(input);
  const bool in_units_of_content = input.unit == content.unit;
  std::string hashes = db::sha256_hex(results) + db::sha256_hex(identification_json(content));
  for (std::size_t i = 0; i < parts.size(); ++i)
    hashes +=
        db::sha256_hex(kReportParts[i].names_runs || !in_units_of_content ? write_part(kReportParts[i], content).value
                                                                          : parts[i].value);
  return db::sha256_hex(hashes);
}

// Signatures stored for this report and for earlier reports of the same run.
struct Issue {
  std::string authorised_by, authorised_utc, issued, replaces, reason;
};

Issue issue_of(const ReportInput& input, const std::string& number) {
  Issue issue;
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

const char* document_name(const ReportInput& input) {
  return is_certificate(input)       ? "Calibration certificate"
         : states_uncertainty(input) ? "Calibration report"
                                     : "Test report";
}

// The date of the run decides whether a reference was overdue; one that fell due later is mentioned without effect.
html::Text due_since_then(const ReportInput& input, const std::string& issued) {
  const ReferenceUncertainty reference = reference_uncertainty(input.run, input.laboratory.instruments);
  if (reference.overdue || due_state(reference.calibration, issued) != DueState::kOverdue) return Text("");
  return Text(
      fmt::format(" The pressure reference fell due on {}, after the measurement: it was in date when the run was "
                  "made, which is what counts.",
                  reference.calibration.due));
}

Markup issue_table(const ReportInput& input, const std::string& number) {
  const Issue issue = issue_of(input, number);
  const auto field = [](const html::Safe& content) { return markup("{}", content); };
  std::vector<Pair> rows = {
      {"number", field(Text(number))},
      {"date of issue", markup("{}{}", html::stated(issue.issued), due_since_then(input, issue.issued))},
      {"authorised by", issue.authorised_by.empty()
                            ? markup("not stated: nobody has signed for this report")
                            : markup("{}, {}", Text(issue.authorised_by), moment(issue.authorised_utc))},
      {"replaces", field(Text(issue.replaces.empty() ? "no earlier report of this run" : issue.replaces))}};
  if (!issue.replaces.empty()) {  // ISO/IEC 17025:2017, 7.8.8.1
    const char* missing = issue.authorised_by.empty() ? "not stated; it is needed to sign this report" : "not stated";
    rows.push_back({"reason for the change", field(Text(issue.reason.empty() ? missing : issue.reason))});
  }
  return pairs_table("Issue", rows);
}

Markup opening(const ReportInput& input, const std::string& number) {
  Markup out =
      markup("<p>Tactile sensor array {}, run {}, {}. {}</p>\n", html::stated(input.run.sensor_serial), input.run.run,
             input.run.started_utc.empty() ? Text("date not stated") : moment(input.run.started_utc),
             is_certificate(input) ? Text(fmt::format("Issued under accreditation {}.", input.laboratory.accreditation))
                                   : Text("Not issued by an accredited laboratory."));
  if (input.run.is_void())
    out += markup(
        "<p class=\"void\"><span class=\"sign\">✗</span> VOID: the run was declared void by {}: {} ({}). It no longer "
        "counts.</p>\n",
        Text(input.run.void_by), Text(input.run.void_reason), moment(input.run.void_utc));
  out += markup(
      "<p class=\"note\">{} Shown in {}, beside it in {}; 1 psi = 6.894757 kPa. <a href=\"#meaning\">Terms</a></p>\n",
      Text(kGaugeInWords), Text(input.unit.symbol()), Text(input.unit.beside().symbol()));
  out += issue_table(input, number);
  return out;
}

}  // namespace

bool is_signed(const ReportInput& input, const std::string& number) {
  return std::ranges::find(input.approvals, number, &db::ReportRecord::number) != input.approvals.end();
}

std::string signed_title_mark(const std::string& number) { return number + ", signed"; }

Report render_report(const ReportInput& input) {
  std::vector<Markup> parts;
  for (const ReportPart& part : kReportParts) parts.push_back(write_part(part, input));
  std::string results = "\"results\":";
  results.reserve(std::size_t{1} << 20);  // its usual size
  results += results_json(input);
  results += ",\n\"sections\":{";
  bool first = true;
  for (const ReportPart& part : kReportParts) {
    if (part.data == nullptr) continue;
    results += fmt::format("{}\"{}\":", first ? "" : ",\n", part.id);
    results += part.data(input);
    first = false;
  }
  results += '}';
  Report report;
  report.content_sha256 = content_hash(input, parts, results);
  report.number = fmt::format("{}-{}", input.run.run, report.content_sha256.substr(0, 8));
  const std::string& number = report.number;
  const Issue issue = issue_of(input, number);
  report.json = fmt::format(
      "{{\"schema\":\"tactbench.report\",\"version\":2,\"document\":\"{}\",\"number\":\"{}\",\"replaces\":{},"
      "\"reason\":{},\"identification\":{},\n",
      document_name(input), number, json_text(issue.replaces), json_text(issue.reason), identification_json(input));
  report.json += results;
  report.json += '}';

  Page page;
  page.document = document_name(input);
  page.number = number;
  page.title = is_signed(input, number) ? signed_title_mark(number) : number;
  page.simulated = is_simulated(input);
  page.paper = input.paper;
  page.opening = opening(input, number);
  for (const ReportPart& part : kReportParts) page.contents.emplace_back(part.id, title_of(part, input));
  page.main = std::move(parts);
  page.json = report.json;
  report.html = page_of(page);
  return report;
}

}  // namespace tactbench::analysis
