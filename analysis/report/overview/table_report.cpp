#include "analysis/report/overview/table_report.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "analysis/counted.h"
#include "analysis/identify/stored/model_document.h"
#include "analysis/json_fields.h"
#include "analysis/report/document/document.h"
#include "analysis/report/overview/overview_figures.h"
#include "analysis/report/page/page.h"
#include "analysis/report/report_facts.h"
#include "db/run_store.h"

namespace tactbench::analysis {

namespace {

using doc::Document;
using nlohmann::ordered_json;

bool in_psi(const TableReportInput& input) { return input.histories.input_unit == "psi"; }

std::size_t samples_of(const Histories& histories) {
  std::size_t samples = 0;
  for (const TaxelHistories& taxel : histories.taxels)
    if (taxel.taxel != kMeanTaxel)
      for (const History& history : taxel.score) samples += history.x.size();
  return samples;
}

std::size_t taxels_of(const Histories& histories) {
  return histories.taxels.size() -
         static_cast<std::size_t>(std::ranges::count(histories.taxels, kMeanTaxel, &TaxelHistories::taxel));
}

doc::Table errors_table(const TableReportInput& input, PressureUnit shown_unit) {
  const std::vector<ModelScore>& scores = input.scores;
  const std::string& own = input.histories.input_unit;
  const std::string unit = in_psi(input) ? shown_unit.symbol() : own.empty() ? "input" : own;
  doc::Table table{
      .id = {},
      .caption = "Errors of the output (% FS) and of the input read back, on the data that the models were made from",
      .columns = {{"model"},
                  {"fit", true},
                  {"taxels", true},
                  {"mean, % FS", true},
                  {"max, % FS", true},
                  {"mean, " + unit, true},
                  {"max, " + unit, true}}};
  const auto error = [&](double value) { return fmt::format("{:.3g}", in_psi(input) ? shown_unit.of(value) : value); };
  for (std::size_t i = 0; i < scores.size(); ++i) {
    const ModelScore& score = scores[i];
    const SensorModel& model = input.models[i];
    table.rows.push_back({{label_of(model), std::to_string(model.fit), std::to_string(score.count),
                           fmt::format("{:.3f}", 100.0 * score.taxels.direct.mean() / score.full_scale),
                           fmt::format("{:.3f}", 100.0 * score.taxels.direct.max / score.full_scale),
                           error(score.taxels.compensated.mean()), error(score.taxels.compensated.max)}});
  }
  if (!scores.empty())
    table.rows.push_back({{"none (straight line)", "–", std::to_string(scores.front().count), "–", "–",
                           error(scores.front().taxels.raw.mean()), error(scores.front().taxels.raw.max)}});
  return table;
}

doc::Paragraph none_text(const TableReportInput& input) {
  return {{fmt::format("No models: tactbench fit {} makes some.", input.run.run)}};
}

ordered_json data_of(const TableReportInput& input) {
  const std::vector<ModelScore>& scores = input.scores;
  const Histories& h = input.histories;
  ordered_json json = {{"table", input.run.devices.empty() ? "" : input.run.devices.front().model},
                       {"content", input.run.content_sha256},
                       JSON_FIELDS(h, input_unit, output_unit, sequences),
                       {"taxels", taxels_of(h)},
                       {"samples", samples_of(h)},
                       {"warnings", h.warnings},
                       {"models", ordered_json::array()}};
  const auto error_json = [](const ErrorSum& error) {
    return ordered_json{{"mean", error.mean()}, {"max", error.max}};
  };
  for (std::size_t i = 0; i < scores.size(); ++i)
    json["models"].push_back({{"model", label_of(input.models[i])},
                              {"sha256", sha256_of(input.models[i])},
                              {"taxels", scores[i].count},
                              {"full_scale", scores[i].full_scale},
                              {"output_error", error_json(scores[i].taxels.direct)},
                              {"input_error", error_json(scores[i].taxels.compensated)},
                              {"straight_line_error", error_json(scores[i].taxels.raw)}});
  return json;
}

std::string ascii(const ordered_json& json) { return json.dump(-1, ' ', true, ordered_json::error_handler_t::replace); }

}  // namespace

Report render_table_report(const TableReportInput& input) {
  const ordered_json data = data_of(input);
  Report report;
  report.content_sha256 = db::sha256_hex(ascii(data));
  report.number = fmt::format("{}-{}", input.run.run, report.content_sha256.substr(0, 8));
  ordered_json json = {{"schema", "tactbench.table-report"},
                       {"version", 1},
                       JSON_FIELDS(report, number, content_sha256),
                       {"identification", {{"run_uuid", input.run.uuid}}}};
  json.update(data);
  report.json = ascii(json);
  const Histories& h = input.histories;
  Document body;
  body.add(doc::Heading{1, "Report on a table", {}});
  body.add(doc::Paragraph{{doc::strong("No. " + report.number),
                           "\nNot a calibration report: the data were imported, and nothing is known of the rig, the "
                           "reference or the uncertainty."}});
  body.add(doc::pairs(
      {}, {{"table", doc::stated(data["table"].get<std::string>())},
           {"imported", date_of(input.run.started_utc)},
           {"by", doc::stated(input.run.operator_name)},
           {"purpose", doc::stated(input.run.purpose)},
           {"data", fmt::format("{} of {} in {}: {}", counted(samples_of(h), "sample"), counted(taxels_of(h), "taxel"),
                                counted(h.sequences.size(), "sequence"), fmt::join(h.sequences, ", "))},
           {"input, output", fmt::format("{}, {}", doc::stated(h.input_unit).text, doc::stated(h.output_unit).text)}}));
  for (const std::string& warning : h.warnings)
    body.add(doc::Paragraph{{doc::StyledText{"▲ " + warning, doc::TextStyle::kDoubt}}});
  body.add(doc::Heading{2, "Loop", "loop"});
  std::vector<const SensorModel*> newest;
  if (!input.models.empty()) newest.push_back(&input.models.back());
  const auto add_chart = [&](const Chart& chart) {
    body.add(doc::Drawing{chart_svg(chart), chart.title, {chart.title + "."}});
  };
  add_chart(fitted_loop(h, newest, input.unit));
  if (!newest.empty()) add_chart(fitted_errors(h, *newest.front(), input.unit));
  body.add(doc::Heading{2, "Models", "models"});
  if (input.models.empty())
    body.add(none_text(input));
  else
    body.add(errors_table(input, input.unit));
  Page page{.document = "Report on a table", .number = report.number, .title = {}, .state = "not a calibration report"};
  page.paper = input.paper;
  page.body = to_html(body, input.unit);
  page.json = report.json;
  report.html = page_of(page);
  return report;
}

doc::Document summary_of(const TableReportInput& input, PressureUnit unit) {
  Document body;
  if (input.models.empty())
    body.add(none_text(input));
  else
    body.add(errors_table(input, unit));
  return body;
}

}  // namespace tactbench::analysis
