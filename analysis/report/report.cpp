#include "analysis/report/report.h"

#include "analysis/report/page.h"
#include "analysis/report/style.h"
#include "db/run_store.h"

namespace tactbench::analysis {
namespace {

using html::markup;
using html::Markup;
using html::Text;

constexpr const char* kPolicy = "default-src 'none'; style-src 'unsafe-inline'; img-src data:";
constexpr const char* kBanner = "SIMULATED – made on simulated devices, not a measurement of a real sensor";

// contract.md, "Runs": content is everything but UUID, wall-clock times, host, tags, notes. The run's own number is
// left out too: it stands before the hash, and the same run in another store has another one.
void keep_content_only(db::RunRecord& run) {
  run.run = 0;
  for (std::string* field : {&run.uuid, &run.started_utc, &run.ended_utc, &run.host, &run.time_zone}) field->clear();
}

ReportInput content_of(const ReportInput& input) {
  ReportInput content = input;
  keep_content_only(content.run);
  for (HeldOut& held_out : content.held_out) keep_content_only(held_out.run);
  if (content.sensor) {
    content.sensor->note.clear();
    content.sensor->added_utc.clear();
  }
  return content;
}

// The order of the page and of its list of contents: a section more is a line more.
struct ReportPart {
  const char* id;     // of its heading
  const char* title;  // in the list of contents
  Markup (*write)(const ReportInput&);
  bool names_runs;  // numbers, times, hosts: written once more without them for the content hash
  // The data behind the section as JSON in ASCII, member `id` of "sections"; null: they stand in "results". Names no
  // run.
  std::string (*data)(const ReportInput&) = nullptr;
};

constexpr ReportPart kReportParts[] = {
    {"verdicts", "Verdicts", verdict_section, false},
    {"identification", "Identification", identification_section, true},
    {"raw", "Before compensation", raw_section, false},
    {"loops", "Loops", loops_section, false},
    {"frames", "Frames", frames_section, false},
    {"levels", "Levels", levels_section, false},
    {"model", "ELAM", model_section, false},
    {"held-out", "Other runs", held_out_section, true},
    {"meaning", "What it means", meaning_section, false},
};

std::string content_hash(const ReportInput& input, const std::vector<Markup>& parts, const std::string& results) {
  const ReportInput content = content_of(input);
  std::string text = results + identification_json(content);
  for (std::size_t i = 0; i < parts.size(); ++i) {
    text += kReportParts[i].names_runs ? kReportParts[i].write(content).value : parts[i].value;
  }
  return db::sha256_hex(text);
}

Markup header(const ReportInput& input, const std::string& number) {
  Markup out;
  if (is_simulated(input)) out += markup("<div class=\"banner\" role=\"note\">{}</div>\n", Text(kBanner));
  out += markup("<header>\n<h1>Calibration report</h1>\n<p class=\"number\">No. {}</p>\n", Text(number));
  out += markup("<p>Tactile sensor array {}, run {}, {}. Not issued by an accredited laboratory.</p>\n",
                html::stated(input.run.sensor_serial), input.run.run,
                input.run.started_utc.empty() ? Text("date not stated") : moment(input.run.started_utc));
  out += markup("<nav aria-label=\"Contents\"><ul>\n");
  for (const ReportPart& part : kReportParts) {
    out += markup("<li><a href=\"#{}\">{}</a></li>\n", html::Attribute(part.id), Text(part.title));
  }
  out += markup("</ul></nav>\n</header>\n");
  return out;
}

Markup footer(const std::string& number) {
  return markup(
      "<footer>\n<p>End of calibration report {}. The data behind each figure stand in this file as JSON (element "
      "“report-data”); shares of full scale are not in per cent there, and null means not available.</p>\n</footer>\n",
      Text(number));
}

}  // namespace

Report render_report(const ReportInput& input) {
  std::vector<Markup> parts;
  for (const ReportPart& part : kReportParts) parts.push_back(part.write(input));
  std::string results = fmt::format("\"results\":{},\n\"sections\":{{", results_json(input));
  bool first = true;
  for (const ReportPart& part : kReportParts) {
    if (part.data == nullptr) continue;
    results += fmt::format("{}\"{}\":{}", first ? "" : ",\n", part.id, part.data(input));
    first = false;
  }
  results += '}';
  Report report;
  report.content_sha256 = content_hash(input, parts, results);
  report.number = fmt::format("{}-{}", input.run.run, report.content_sha256.substr(0, 8));
  const std::string& number = report.number;
  report.json =
      fmt::format("{{\"schema\":\"tactbench.report\",\"version\":1,\"number\":\"{}\",\"identification\":{},\n{}}}",
                  number, identification_json(input), results);

  Markup page = markup(
      "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\"/>\n"
      "<meta http-equiv=\"Content-Security-Policy\" content=\"{}\"/>\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>\n"
      "<title>Calibration report {}</title>\n<style>{}</style>\n</head>\n<body>\n",
      html::Attribute(kPolicy), Text(number), style_sheet(number, is_simulated(input)));
  page += header(input, number);
  page += markup("<main>\n");
  for (const Markup& part : parts) page += part;
  page += markup("</main>\n");
  page += footer(number);
  page += markup("<script type=\"application/json\" id=\"report-data\">{}</script>\n</body>\n</html>\n",
                 html::JsonInHtml(report.json));
  report.html = std::move(page.value);
  return report;
}

}  // namespace tactbench::analysis
