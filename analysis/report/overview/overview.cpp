// Many sensors on one page.

#include "analysis/report/overview/overview.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <numeric>
#include <set>
#include <tuple>

#include "analysis/counted.h"
#include "analysis/report/data/data.h"
#include "analysis/report/document/document.h"
#include "analysis/report/overview/overview_figures.h"
#include "analysis/report/page/chart.h"
#include "analysis/report/page/page.h"
#include "db/run_store.h"

namespace tactbench::analysis {
namespace {

using doc::Document;
using doc::Phrase;

struct BatchColumn {
  const OverviewFigure* figure;
  std::vector<double> values, scores;  // one per run
};

std::vector<BatchColumn> batch_columns(const std::vector<ReportInput>& runs) {
  std::vector<BatchColumn> columns;
  for (const OverviewFigure& figure : overview_figures()) {
    BatchColumn column{&figure, {}, {}};
    for (const ReportInput& run : runs) column.values.push_back(figure.value(run));
    column.scores = modified_z_scores(column.values);
    columns.push_back(std::move(column));
  }
  return columns;
}

const BatchColumn& column_named(const std::vector<BatchColumn>& columns, const std::string& key) {
  return *std::ranges::find_if(columns, [&](const BatchColumn& column) { return column.figure->key == key; });
}

// Runs that were not judged count as inconclusive.
Verdict rank_of(std::optional<Verdict> overall) {
  return states_conformity(overall) ? *overall : Verdict::kInconclusive;
}

// Passes first, fails last; among equals best first by the mean compensation error; without models by the mean
// hysteresis error; then as given.
std::vector<std::size_t> ranked(const std::vector<ReportInput>& runs, const std::vector<BatchColumn>& columns) {
  const BatchColumn &error = column_named(columns, "mean_error_psi"),
                    &hysteresis = column_named(columns, "hysteresis_mean_fs");
  std::vector<std::size_t> order(error.values.size());
  std::iota(order.begin(), order.end(), 0);
  const auto key = [&](std::size_t i) {
    const double e = error.values[i], h = hysteresis.values[i];
    return std::tuple(rank_of(runs[i].judgement.overall), !std::isfinite(e), std::isfinite(e) ? e : 0.0,
                      std::isfinite(h) ? h : 0.0);
  };
  std::ranges::stable_sort(order, {}, key);
  return order;
}

// If there are limits, a sensor that was not judged counts among the judged ones, because its evidence is missing.
doc::VerdictBox yield_part(const std::vector<ReportInput>& sensors, const std::vector<std::string>& left_out) {
  std::map<std::string, int> verdicts;
  int with_limits = 0, good = 0;
  std::optional<Verdict> worst;
  for (const ReportInput& sensor : sensors) {
    const std::optional<Verdict> overall = sensor.judgement.overall;
    const bool judged = !sensor.judgement.not_judged;
    ++verdicts[!overall ? "no verdict" : judged ? to_string(*overall) : "not judged"];
    with_limits += states_conformity(overall) ? 1 : 0;
    good += passes(overall) ? 1 : 0;
    if (states_conformity(overall)) worst = std::max(worst, overall);
  }
  std::string list;
  for (const auto& [word, number] : verdicts) list += fmt::format("{}{} {}", list.empty() ? "" : ", ", number, word);
  Document text, counts;
  if (with_limits == 0) {
    text.add(doc::Paragraph{{"No yield"}, doc::Paragraph::kLarge});
    text.add(doc::Paragraph{{"No tolerance limits were given."}});
  } else {
    text.add(
        doc::Paragraph{{fmt::format("{} of {} passed", good, counted(with_limits, "sensor"))}, doc::Paragraph::kLarge});
    text.add(doc::Paragraph{
        {"Yield ", doc::percent_of(static_cast<double>(good) / with_limits, 1), " %, conditional passes included."}});
  }
  doc::Table table = doc::pairs(
      "Yield", {{"sensors, runs named", fmt::format("{}, {}", sensors.size(), sensors.size() + left_out.size())},
                {"verdicts", list},
                {"left out: each sensor is represented by its newest run",
                 left_out.empty() ? std::string("none") : fmt::format("{}", fmt::join(left_out, "; "))}});
  table.dense = true;
  counts.add(std::move(table));
  return {worst ? doc::style_of(*worst) : doc::TextStyle::kDoubt, {text, counts}};
}

std::string outlying_figures(const std::vector<BatchColumn>& columns, std::size_t run) {
  std::string names;
  for (const BatchColumn& column : columns) {
    if (!(std::abs(column.scores[run]) > kOutlierScore)) continue;
    names += fmt::format("{}{}", names.empty() ? "" : "; ", column.figure->name);
  }
  return names;
}

doc::Table rank_table(const std::vector<ReportInput>& runs, const std::vector<BatchColumn>& columns) {
  static const std::vector<std::pair<const char*, const char*>> shown = {
      {"mean_error_psi", "mean |error|"},
      {"worst_taxel_mean_error_psi", "worst taxel"},
      {"comp_distance_of_mean_fs", "hysteresis of the mean, % FS"},
      {"hysteresis_max_fs", "hysteresis before correction, max., % FS"},
      {"excluded_taxels", "excluded taxels"},
      {"retries", "retries"}};
  const PressureUnit unit = runs.front().unit;
  doc::Table table{.id = "ranks",
                   .caption =
                       "Sensors ranked: by verdict, best first, then by the mean |error| on the judged run (the worst "
                       "of several; the "
                       "models’ own run where none was judged)",
                   .columns = {{"rank", true}, {"sensor"}, {"run", true}, {"date"}},
                   .dense = true};
  for (const auto& [key, title] : shown)
    table.columns.push_back(
        {is_pressure(*column_named(columns, key).figure) ? fmt::format("{}, {}", title, unit.symbol()) : title, true});
  table.columns.push_back({"verdict"});
  int rank = 0;
  for (const std::size_t i : ranked(runs, columns)) {
    const ReportInput& run = runs[i];
    doc::Row row{{std::to_string(++rank), doc::strong(doc::stated(run.run.sensor_serial).text),
                  std::to_string(run.run.run), date_of(run.run.started_utc)}};
    for (const auto& [key, title] : shown) {
      const BatchColumn& column = column_named(columns, key);
      const bool outlier = std::abs(column.scores[i]) > kOutlierScore;
      row.cells.push_back(Phrase(doc::StyledText{outlier ? "▲ " : "", doc::TextStyle::kDoubt},
                                 shown_figure(*column.figure, column.values[i])));
    }
    row.cells.push_back(overall_phrase(run, "none"));
    table.rows.push_back(std::move(row));
  }
  return table;
}

Document outliers_part(const std::vector<ReportInput>& runs, const std::vector<BatchColumn>& columns) {
  Document out;
  out.add(doc::Heading{2, "Outliers", "outliers"});
  if (runs.size() < 5) {
    out.add(doc::Paragraph{{"not assessed: fewer than five runs"}});
    return out;
  }
  doc::List list;
  for (std::size_t i = 0; i < runs.size(); ++i)
    if (const std::string names = outlying_figures(columns, i); !names.empty())
      list.items.push_back({sensor_and_run(runs[i]), ": ", names});
  if (list.items.empty()) list.items.push_back({"none"});
  out.add(std::move(list));
  out.add(doc::Paragraph{
      {fmt::format("▲: a figure whose modified z-score, 0.6745 (x − median) / MAD, is beyond ±{}: far from the other "
                   "sensors, in either direction. Not assessed where more than half of the figures are equal.",
                   doc::fixed_text(kOutlierScore, 1))},
      doc::Paragraph::kNote});
  return out;
}

// The part of a figure's name after the last comma: its unit.
std::string unit_text(const std::string& name) {
  const std::size_t comma = name.rfind(", ");
  return comma == std::string::npos ? name : "in " + name.substr(comma + 2);
}

Document histograms_part(const std::vector<ReportInput>& runs, const std::vector<BatchColumn>& columns) {
  const PressureUnit unit = runs.front().unit;
  Document out;
  out.add(doc::Heading{2, "Distributions and limits", "histograms"});
  doc::SideBySide pair;
  for (const char* key : {"mean_error_psi", "worst_taxel_mean_error_psi", "comp_distance_of_mean_fs",
                          "hysteresis_max_fs", "gain_std", "excluded_taxels"}) {
    const OverviewFigure& figure = *column_named(columns, key).figure;
    const std::string name = is_pressure(figure) ? fmt::format("{}, {}", figure.name, unit.symbol()) : figure.name;
    std::vector<double> values;
    for (const double value : column_named(columns, key).values) values.push_back(plotted_figure(figure, value, unit));
    const Spread spread = spread_of(values);
    if (spread.count == 0) continue;
    std::set<double> limits;
    for (const ReportInput& run : runs)
      if (const double limit = limit_of(figure, run); std::isfinite(limit)) limits.insert(limit);
    Chart chart{.title = name + ", number of runs", .height = 150.0, .x = {unit_text(name)}, .y = {"runs"}};
    const double margin =
        spread.high > spread.low ? 0.02 * (spread.high - spread.low) : std::max(0.5, 0.1 * std::abs(spread.high));
    chart.bars.push_back(
        bars_of(values, spread.low - margin, spread.high + margin,
                std::clamp(static_cast<int>(2.0 * std::sqrt(static_cast<double>(runs.size()))), 4, 24)));
    std::string beyond;
    if (limits.size() == 1) {
      const double limit = plotted_figure(figure, *limits.begin(), unit),
                   span = spread.high - spread.low + 2.0 * margin;
      if (limit > spread.low - 2.0 * span && limit < spread.high + 2.0 * span)
        chart.rules.push_back({limit, "limit", kRed, true});
      else
        beyond = fmt::format("; limit {}: beyond this axis", doc::fixed_text(limit, figure.digits));
    }
    const int digits = is_pressure(figure) ? unit.digits(figure.digits) : figure.digits;
    Document part;
    part.add(doc::Drawing{chart_svg(chart),
                          chart.title,
                          {name, "; ", counted(spread.count, "run"), ": ", doc::number(spread.low, digits), " to ",
                           doc::number(spread.high, digits), ", median ", doc::number(spread.median, digits), beyond,
                           limits.size() > 1 ? "; the runs were judged by several limits: none is drawn" : ""}});
    pair.parts.push_back(std::move(part));
    if (pair.parts.size() == 2) out.add(std::exchange(pair, {}));
  }
  if (!pair.parts.empty()) out.add(std::move(pair));
  return out;
}

}  // namespace

std::vector<std::size_t> batch_rows(const std::vector<ReportInput>& named) {
  const auto standing = [](const ReportInput& input) {
    return std::tuple(!input.run.is_void(), !input.fit.taxels.empty(), input.run.started_utc, input.run.run);
  };
  std::vector<std::size_t> rows;
  for (std::size_t i = 0; i < named.size(); ++i) {
    const bool gives_way = std::ranges::any_of(named, [&](const ReportInput& other) {
      return !other.run.sensor_serial.empty() && other.run.sensor_serial == named[i].run.sensor_serial &&
             standing(other) > standing(named[i]);
    });
    if (!gives_way) rows.push_back(i);
  }
  return rows;
}

Report render_batch(const std::vector<ReportInput>& named) {
  std::vector<ReportInput> runs;
  std::vector<std::string> left_out;
  const std::vector<std::size_t> rows = batch_rows(named);
  for (std::size_t i = 0; i < named.size(); ++i) {
    if (std::ranges::find(rows, i) != rows.end())
      runs.push_back(named[i]);
    else
      left_out.push_back(sensor_and_run(named[i]));
  }
  const std::vector<BatchColumn> columns = batch_columns(runs);
  Report report;
  std::string content, numbers;
  for (const ReportInput& run : runs) {
    content += fmt::format("{}{}", content.empty() ? "" : ",\n", content_of_run(run));
    numbers += fmt::format("{}{}", numbers.empty() ? "" : ",", run.run.run);
  }
  report.content_sha256 = db::sha256_hex(content);
  report.number = report.content_sha256.substr(0, 8);
  report.json =
      fmt::format("{{\"schema\":\"tactbench.batch\",\"version\":2,\"number\":\"{}\",\"runs\":[{}],\n\"content\":[{}]}}",
                  report.number, numbers, content);
  Document body;
  body.add(doc::Heading{1, "Batch of sensors", {}});
  body.add(doc::Paragraph{{doc::strong("No. " + report.number),
                           fmt::format("\n{}, {} named. Not a calibration report: each run has its own.",
                                       counted(runs.size(), "sensor"), counted(named.size(), "run"))}});
  body.add(yield_part(runs, left_out));
  body.add(rank_table(runs, columns));
  body.add(outliers_part(runs, columns));
  body.add(histograms_part(runs, columns));
  std::vector<const ReportInput*> all;
  for (const ReportInput& run : runs) all.push_back(&run);
  body.add(loops_overlaid(all));
  Page page{.document = "Batch of sensors", .number = report.number, .title = {}, .state = "not a calibration report"};
  page.simulated = std::ranges::any_of(runs, [](const ReportInput& run) { return is_simulated(run); });
  page.paper = runs.front().paper;
  page.body = to_html(body, runs.front().unit);
  page.json = report.json;
  report.html = page_of(page);
  return report;
}

// Two runs side by side: as found and as left, or two sensors.

namespace {

using doc::Document;
using doc::Phrase;

bool same_sensor(const ReportInput& a, const ReportInput& b) {
  return !a.run.sensor_serial.empty() && a.run.sensor_serial == b.run.sensor_serial;
}

std::string sequences_of(const db::RunRecord& run) {
  std::string names;
  for (const db::SequenceRecord& sequence : run.sequences)
    names += fmt::format("{}{} ({} ×)", names.empty() ? "" : ", ", sequence.name, sequence.repeats);
  return names;
}

doc::Table who_table(const ReportInput& a, const ReportInput& b) {
  doc::Table table{
      .id = "runs", .caption = "The two runs", .columns = {{""}, {"first"}, {"second"}}, .rows = {}, .dense = true};
  const auto both = [&](const char* name, auto field) { table.rows.push_back({{name, field(a), field(b)}}); };
  const auto text = [&](const char* name, auto field) {
    both(name, [&](const ReportInput& i) { return Phrase(doc::stated(field(i))); });
  };
  text("run", [](const ReportInput& i) { return std::to_string(i.run.run); });
  text("sensor", [](const ReportInput& i) { return i.run.sensor_serial; });
  text("scanner electronics", [](const ReportInput& i) { return scanner_serial_of(i.run, i.sensor); });
  text("origin", [](const ReportInput& i) { return i.run.origin; });
  text("started (UTC)", [](const ReportInput& i) { return moment_text(i.run.started_utc); });
  text("operator", [](const ReportInput& i) { return i.run.operator_name; });
  text("bench", [](const ReportInput& i) { return i.run.bench_id; });
  text("recipes", [](const ReportInput& i) { return sequences_of(i.run); });
  text("outcome", [](const ReportInput& i) { return std::string(db::to_string(i.run.outcome)); });
  both("declared void", [](const ReportInput& i) {
    if (!i.run.is_void()) return Phrase("no");
    return Phrase(doc::StyledText{
        fmt::format("✗ VOID: by {}, {}: {}", i.run.void_by, i.run.void_utc, i.run.void_reason), doc::TextStyle::kBad});
  });
  both("content, SHA-256",
       [](const ReportInput& i) { return Phrase(doc::code_text(i.run.content_sha256.substr(0, 16))); });
  return table;
}

// One line about the change: the error if both runs have one, else the loops before correction.
Phrase change_text(const ReportInput& a, const ReportInput& b) {
  const bool models = !a.evaluation.levels.empty() && !b.evaluation.levels.empty();
  const bool refound = models && same_sensor(a, b) && !a.held_out.empty();
  if (models) {
    const double before = refound ? a.held_out.front().evaluation.mean_error_psi : a.evaluation.mean_error_psi;
    return {"Mean |error| ", doc::pressure(b.evaluation.mean_error_psi, 2), refound ? ", as found " : ", first ",
            doc::pressure(before, 2)};
  }
  if (a.behaviour.loops.empty() || b.behaviour.loops.empty()) return "No figure that both runs have";
  return {"Hysteresis before correction ", doc::percent_of(b.behaviour.loops.front().hysteresis_mean, 2),
          " % FS, first ", doc::percent_of(a.behaviour.loops.front().hysteresis_mean, 2), " % FS"};
}

// The verdicts of both runs; the frame is that of the second.
doc::VerdictBox verdicts(const ReportInput& a, const ReportInput& b) {
  const bool stated = states_conformity(b.judgement.overall) && !b.judgement.not_judged;
  Document text;
  text.add(doc::Paragraph{change_text(a, b), doc::Paragraph::kLarge});
  doc::Table table{.id = "verdicts",
                   .caption = "Verdicts",
                   .columns = {{"run"}, {"sensor"}, {"measured"}, {"verdict"}},
                   .rows = {},
                   .dense = true};
  for (const auto& [name, own] : {std::pair("first", &a), {"second", &b}})
    table.rows.push_back(
        {{doc::strong(fmt::format("{}, run {}", name, own->run.run)), doc::stated(own->run.sensor_serial),
          date_of(own->run.started_utc), overall_phrase(*own, "no tolerance limits were given")}});
  Document right;
  right.add(std::move(table));
  return {stated ? doc::style_of(*b.judgement.overall) : doc::TextStyle::kDoubt, {text, right}};
}

doc::Table figures_table(const ReportInput& a, const ReportInput& b) {
  doc::Table table{
      .id = "figures",
      .caption = "Figures",
      .columns = {{"figure"}, {"first", true}, {"second", true}, {"second − first", true}, {"change, %", true}},
      .rows = {},
      .dense = true};
  for (const OverviewFigure& figure : overview_figures()) {
    const double x = figure.value(a), y = figure.value(b);
    table.rows.push_back({{name_of(figure, a.unit), shown_figure(figure, x), shown_figure(figure, y),
                           shown_figure(figure, y - x), doc::percent_of(x != 0.0 ? y / x - 1.0 : kNan, 1)}});
  }
  return table;
}

// The second run's data with the first run's models and with its own.
Document found_and_left_by(const ReportInput& a, const ReportInput& b) {
  Document out;
  if (a.held_out.empty()) return out;
  const Evaluation& found = a.held_out.front().evaluation;
  const bool left = !b.evaluation.levels.empty();
  doc::Table table{.id = "as-found",
                   .caption = "The second run’s data, corrected with the first run’s models and with its own",
                   .columns = {{"figure"}, {"as found (first run’s models)", true}, {"as left (its own models)", true}},
                   .rows = {},
                   .dense = true};
  const auto row = [&](const char* name, double Evaluation::*figure, auto shown) {
    table.rows.push_back({{name, shown(found.*figure), shown(left ? b.evaluation.*figure : kNan)}});
  };
  const auto in_unit = [](double psi) { return doc::pressure(psi, 2); };
  const auto in_percent = [](double share) { return doc::percent_of(share, 2); };
  row("mean |error| on its own run", &Evaluation::mean_error_psi, in_unit);
  row("largest |error|", &Evaluation::max_error_psi, in_unit);
  row("worst taxel’s mean |error|", &Evaluation::worst_taxel_mean_error_psi, in_unit);
  row("hysteresis, mean over taxels, % FS", &Evaluation::comp_distance, in_percent);
  row("hysteresis of the mean of all, % FS", &Evaluation::comp_distance_of_mean, in_percent);
  out.add(std::move(table));
  out.add(doc::Paragraph{{"As found: how well the sensor measured until now. As left: on the run from which the models "
                          "were made; only other runs are an independent verification."},
                         doc::Paragraph::kNote});
  return out;
}

// Ratio of each taxel's output to that of the other run at the level of the equilibration; empty if they cannot be
// compared.
std::vector<double> output_ratios(const ReportInput& a, const ReportInput& b) {
  const Behaviour &x = a.behaviour, &y = b.behaviour;
  if (x.loops.empty() || y.loops.empty() || x.gain.size() != y.gain.size() || a.health.columns != b.health.columns)
    return {};
  if (!(std::abs(x.equilibration_psi - y.equilibration_psi) < 0.5)) return {};
  const auto mean_at_level = [](const Behaviour& behaviour) {
    const auto at = std::ranges::find(behaviour.pressure_psi, behaviour.equilibration_psi);
    return behaviour.loops.front().up_v[static_cast<std::size_t>(at - behaviour.pressure_psi.begin())];
  };
  const double means = mean_at_level(y) / mean_at_level(x);
  std::vector<double> ratios;
  for (std::size_t i = 0; i < x.gain.size(); ++i) ratios.push_back(y.gain[i] / x.gain[i] * means);
  return ratios;
}

Document ratio_figures(const ReportInput& a, const ReportInput& b, const std::vector<double>& ratios) {
  Document out, left, right;
  const Spread spread = spread_of(ratios);
  if (spread.count == 0) {
    out.add(doc::Paragraph{{"Taxel by taxel: not available, the runs share no level or shape."}});
    return out;
  }
  const double reach = std::max({std::abs(spread.low - 1.0), std::abs(spread.high - 1.0), 1e-3});
  const TaxelMap map{.title = "Output of each taxel, second run over first",
                     .rows = a.health.rows,
                     .columns = a.health.columns,
                     .values = ratios,
                     .low = 1.0 - reach,
                     .high = 1.0 + reach,
                     .two_sided = true,
                     .size = 200.0};
  left.add(doc::Drawing{
      taxel_map_svg(map),
      map.title,
      {"Output of each taxel at ", doc::pressure(b.behaviour.equilibration_psi),
       ", increasing, second over first: ", doc::number(spread.low, 3), " (brown) to ", doc::number(spread.high, 3),
       " (blue), median ", doc::number(spread.median, 3), ". A cross: not in both runs."}});
  Chart chart{.title = "Number of taxels by ratio of outputs", .x = {"second over first"}, .y = {"taxels"}};
  const double margin = std::max(0.02 * (spread.high - spread.low), 1e-3);
  chart.bars.push_back(bars_of(ratios, spread.low - margin, spread.high + margin, 20));
  right.add(doc::Drawing{chart_svg(chart), chart.title, {}});
  out.add(doc::SideBySide{{left, right}, {1, 1}});
  return out;
}

doc::Table health_changes(const ReportInput& a, const ReportInput& b) {
  const auto states = [](const ReportInput& input) {
    std::set<std::pair<int, std::string>> out;
    for (const TaxelHealth& finding : input.health.findings) out.emplace(finding.taxel, finding.state);
    return out;
  };
  const auto before = states(a), after = states(b);
  const auto list = [&](const auto& from, const auto& without) {
    std::string text;
    for (const auto& one : from)
      if (!without.contains(one))
        text += fmt::format("{}{} ({})", text.empty() ? "" : ", ", one.second,
                            doc::text_of(Phrase(doc::Taxel{one.first, a.health.columns}), {}));
    return text.empty() ? std::string("none") : text;
  };
  return doc::pairs("Findings on taxels",
                    {{"only in the first run", list(before, after)}, {"only in the second run", list(after, before)}});
}

}  // namespace

Report render_comparison(const ReportInput& a, const ReportInput& b) {
  const std::vector<double> ratios = output_ratios(a, b);
  Report report;
  const std::string found =
      a.held_out.empty() ? "null" : fmt::format("{:a}", a.held_out.front().evaluation.mean_error_psi);
  report.content_sha256 = db::sha256_hex(fmt::format("{}\n{}\n{}", content_of_run(a), content_of_run(b), found));
  report.number = fmt::format("{}-{}-{}", a.run.run, b.run.run, report.content_sha256.substr(0, 8));
  report.json = fmt::format(
      "{{\"schema\":\"tactbench.comparison\",\"version\":2,\"number\":\"{}\",\"runs\":[{},{}],\n\"first\":{},"
      "\n\"second\":{},\n\"output_ratio\":{}}}",
      report.number, a.run.run, b.run.run, content_of_run(a), content_of_run(b), json_text(number_list(ratios)));
  Document body;
  body.add(doc::Heading{1, "Comparison of two runs", {}});
  body.add(doc::Paragraph{{doc::strong("No. " + report.number),
                           fmt::format("\n{}: {} and {}. Not a calibration report: each run has its own.",
                                       same_sensor(a, b) ? "One sensor at two times" : "Two sensors", sensor_and_run(a),
                                       sensor_and_run(b))}});
  body.add(verdicts(a, b));
  body.add(loops_overlaid({&a, &b}));
  body.add(figures_table(a, b));
  if (same_sensor(a, b)) body.add(found_and_left_by(a, b));
  body.add(ratio_figures(a, b, ratios));
  body.add(health_changes(a, b));
  body.add(who_table(a, b));
  Page page{
      .document = "Comparison of two runs", .number = report.number, .title = {}, .state = "not a calibration report"};
  page.simulated = is_simulated(a) || is_simulated(b);
  page.paper = a.paper;
  page.body = to_html(body, a.unit);
  page.json = report.json;
  report.html = page_of(page);
  return report;
}

}  // namespace tactbench::analysis
