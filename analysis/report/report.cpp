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

// The sections that name runs, and those that do not: only the first are rendered a second time for the hash.
struct Body {
  Markup verdicts, identification, results, held_out, meaning;
  std::string results_data;
};

std::string content_hash(const ReportInput& input, const Body& body) {
  const ReportInput content = content_of(input);
  std::string text = body.verdicts.value + body.results.value + body.meaning.value + body.results_data;
  text += identification_section(content).value + held_out_section(content).value + identification_json(content);
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
  static constexpr const char* kContents[][2] = {{"verdicts", "Verdicts"},
                                                 {"identification", "Identification"},
                                                 {"raw", "Before compensation"},
                                                 {"loops", "Loops"},
                                                 {"frames", "Frames"},
                                                 {"levels", "Levels"},
                                                 {"model", "ELAM"},
                                                 {"held-out", "Other runs"},
                                                 {"meaning", "What it means"}};
  for (const auto& [id, title] : kContents) {
    out += markup("<li><a href=\"#{}\">{}</a></li>\n", html::Attribute(id), Text(title));
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
  Body body;
  body.verdicts = verdict_section(input);
  body.identification = identification_section(input);
  for (const auto& section : {raw_section, loops_section, frames_section, levels_section, model_section}) {
    body.results += section(input);
  }
  body.held_out = held_out_section(input);
  body.meaning = meaning_section(input);
  body.results_data = results_json(input);
  const std::string number = fmt::format("{}-{}", input.run.run, content_hash(input, body).substr(0, 8));

  Markup page = markup(
      "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\"/>\n"
      "<meta http-equiv=\"Content-Security-Policy\" content=\"{}\"/>\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>\n"
      "<title>Calibration report {}</title>\n<style>{}</style>\n</head>\n<body>\n",
      html::Attribute(kPolicy), Text(number), style_sheet(number, is_simulated(input)));
  page += header(input, number);
  page += markup("<main>\n");
  for (const Markup* part : {&body.verdicts, &body.identification, &body.results, &body.held_out, &body.meaning})
    page += *part;
  page += markup("</main>\n");
  page += footer(number);
  page += markup(
      "<script type=\"application/json\" "
      "id=\"report-data\">{{\"schema\":\"tactbench.report\",\"version\":1,\"number\":\"{}\","
      "\"identification\":{},\n\"results\":{}}}</script>\n</body>\n</html>\n",
      Text(number), html::JsonInHtml(identification_json(input)), html::JsonInHtml(body.results_data));
  return {number, std::move(page.value)};
}

}  // namespace tactbench::analysis
