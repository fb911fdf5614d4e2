// Page 1 states the verdict, the error of a reading, its range, the conditions of use, the validity, and the
// instruments.
#include <algorithm>
#include <cmath>

#include "analysis/counted.h"
#include "analysis/report/data/conformity.h"
#include "analysis/report/data/traceability.h"
#include "analysis/report/document/document.h"
#include "analysis/report/page/chart.h"
#include "analysis/report/report_facts.h"
#include "analysis/report/sections/sections.h"

namespace tactbench::analysis {

namespace {

using doc::Document;
using doc::Phrase;

std::string state_of(const Issue& issue) {
  if (issue.draft()) return "Draft: not signed";
  return fmt::format("Issued {}, signed by {}", issue.issued, issue.authorised_by);
}

doc::SideBySide letterhead(const PageData& data) {
  const Laboratory& lab = data.input.laboratory;
  Document left, right, code;
  Phrase who(lab.laboratory.empty() ? doc::quiet("Laboratory not stated") : doc::strong(lab.laboratory));
  if (!lab.address.empty()) who.add("\n" + lab.address);
  who.add(doc::quiet(is_certificate(data.input) ? "\nAccreditation " + lab.accreditation : "\nNot accredited"));
  left.add(doc::Paragraph{who});
  right.add(doc::Heading{1, data.issue.document, {}});
  right.add(doc::Paragraph{{doc::strong("No. " + data.issue.number), "\n", doc::quiet(state_of(data.issue))}});
  if (!data.issue.replaces.empty())
    right.add(doc::Paragraph{{"Replaces ", data.issue.replaces, ": ", doc::stated(data.issue.reason)},
                             doc::Paragraph::kNote});
  // The number, the hash of the content, how to check a copy.
  const std::string check =
      fmt::format("report {}\nSHA-256 {}\ntactbench report verify FILE", data.issue.number, data.issue.content_sha256);
  code.add(doc::Drawing{qr_code_svg(check, check, 84.0), check, {}});
  return {{left, right, code}, {9, 7, 2}};
}

doc::SideBySide facts(const PageData& data) {
  const ReportInput& input = data.input;
  doc::SideBySide out{.parts = {}, .shares = {}, .ruled = true};
  const auto fact = [&](const char* name, const Phrase& value) {
    Document part;
    part.add(doc::Paragraph{{doc::quiet(name), "\n", value}});
    out.parts.push_back(part);
  };
  fact("Item", {doc::strong(fmt::format("Tactile array {} × {}", input.health.rows, input.health.columns)), "\n",
                doc::stated(input.sensor ? input.sensor->type : "")});
  fact("Serial number", {doc::StyledText{doc::stated(input.run.sensor_serial).text, doc::TextStyle::kStrong},
                         "\nscanner ", doc::stated(scanner_serial_of(input.run, input.sensor))});
  fact("Customer",
       {doc::stated(input.laboratory.customer), order_of(input).empty() ? "" : "\norder " + order_of(input)});
  Phrase when(doc::StyledText{date_of(input.run.started_utc), doc::TextStyle::kStrong});
  if (data.readings) when.add("\n0 to ").add(doc::both_units(data.readings->full_psi)).add(" gauge");
  fact(states_uncertainty(input) ? "Calibrated" : "Measured", when);
  const std::string until = valid_until(input.laboratory, input.run.started_utc);
  fact("Valid until", until.empty() ? Phrase("not stated by the laboratory") : Phrase(doc::strong(until)));
  return out;
}

Phrase decided_text(const ReportInput& input, const JudgedFigure& figure, PressureUnit unit) {
  return {requirement_name(figure, unit),
          ": ",
          figure_phrase(figure.criterion, figure.value, figure.u.expanded),
          ", limit ",
          figure_phrase(figure.criterion, figure.limit),
          ", ",
          title_of_judged(input, figure.run)};
}

Document verdict_names(const ReportInput& input, PressureUnit unit) {
  const Judgement& judgement = input.judgement;
  Document out;
  const auto large = [&](const std::string& text) { out.add(doc::Paragraph{{text}, doc::Paragraph::kLarge}); };
  const auto met =
      std::ranges::count_if(judgement.figures, [](const JudgedFigure& own) { return passes(own.verdict); });
  const auto all = std::ssize(judgement.figures);
  if (judgement.not_judged) {
    large("▲ Not judged");
    out.add(doc::Paragraph{{title_case(display_text(*judgement.not_judged, unit)) + "."}});
  } else if (!states_conformity(judgement.overall)) {
    large("No verdict");
    out.add(doc::Paragraph{{all == 0 ? "No tolerance limits were given." : "The limits file requests a report only."}});
  } else {
    const Verdict overall = *judgement.overall;
    large(doc::sign_of(overall) + " " + title_case(to_string(overall)) +
          (judgement.rests_on_means_alone ? ", for means only" : ""));
    if (passes(overall) && judgement.closest_pass)
      out.add(doc::Paragraph{{fmt::format("{} of {} passed. Closest to its limit: ", met, counted(all, "check")),
                              decided_text(input, judgement.figures[*judgement.closest_pass], unit), "."}});
    else if (judgement.deciding)
      out.add(doc::Paragraph{{"Decided by ", decided_text(input, judgement.figures[*judgement.deciding], unit),
                              fmt::format(". {} of {} passed.", met, counted(all, "check"))}});
    if (judgement.rests_on_means_alone)
      out.add(doc::Paragraph{
          {"No limit applies to single readings; the error of a single reading may exceed that of any mean."}});
    if (judgement.untraced) out.add(doc::Paragraph{{title_case(display_text(*judgement.untraced, unit)) + "."}});
    if (passes(overall) && !judgement.not_assessed.empty())
      out.add(doc::Paragraph{{doc::quiet("Under repeatability conditions only.")}});
  }
  const auto warn = [&](const std::string& text) {
    out.add(doc::Paragraph{{doc::StyledText{"▲ " + text + ".", doc::TextStyle::kDoubt}}});
  };
  if (const auto worst = std::ranges::max_element(judgement.stored_worse, {}, &JudgedFigure::verdict);
      worst != judgement.stored_worse.end())
    warn(fmt::format("A stored verdict on these models is worse: {}, {}", to_string(worst->verdict),
                     title_of_judged(input, worst->run)));
  for (const Remark& remark : judgement.remarks) warn(title_case(display_text(remark, unit)));
  return out;
}

Document runs_text(const ReportInput& input, PressureUnit unit) {
  Document out;
  const Judgement& judgement = input.judgement;
  if (judgement.runs.empty()) return out;
  doc::Table table{.id = "runs",
                   .caption = "Runs judged",
                   .columns = {{"run judged"},
                               {fmt::format("mean\n|error|, {}", unit.symbol()), true},
                               {fmt::format("worst taxel’s\nmean, {}", unit.symbol()), true},
                               {"checks\npassed", true},
                               {"verdict"}},
                   .dense = true};
  for (const JudgedRun& run : judgement.runs) {
    const Evaluation* const evaluation = evaluation_of(input, run.run);
    std::ptrdiff_t met = 0, of = 0;
    for (const JudgedFigure& figure : judgement.figures) {
      if (figure.run != run.run) continue;
      ++of;
      met += passes(figure.verdict) ? 1 : 0;
    }
    const std::string trajectory = run.trajectory.trajectory == Trajectory::kAsFitted
                                       ? to_string(run.trajectory.trajectory)
                                       : "not fitted, " + counted(run.trajectory.reversals, "turning point");
    table.rows.push_back({{Phrase(doc::strong(title_of_judged(input, run.run)), doc::quiet("\n" + trajectory)),
                           doc::bare_pressure(evaluation == nullptr ? kNan : evaluation->mean_error_psi),
                           doc::bare_pressure(evaluation == nullptr ? kNan : evaluation->worst_taxel_mean_error_psi),
                           fmt::format("{} of {}", met, of), run.verdict}});
  }
  out.add(std::move(table));
  return out;
}

std::string within_text(const ReadingFigures& readings, double psi, PressureUnit unit) {
  const std::string share = doc::fixed_text(100.0 * psi / readings.full_psi, 0);
  return fmt::format("± {} ({} % of full pressure{})", doc::text_of(doc::pressure(psi), unit), share,
                     readings.by_mpe ? ", the limit" : "");
}

std::string headline(const std::optional<ReadingFigures>& readings, PressureUnit unit) {
  if (!readings || !readings->known()) return "The error of a single reading was not established";
  const std::string within = within_text(*readings, readings->headline_psi, unit);
  if (!readings->headline.any) return fmt::format("At no pressure do 95 % of the taxels read within {}", within);
  return fmt::format("95 % of the taxels read within {}, {}", within, span_text(readings->headline, unit));
}

Phrase chart_caption(const ReadingFigures& readings) {
  if (!readings.known())
    return "Line: median of the taxels’ mean errors in full sweeps. Light: 95 % of the taxels. The error of a single "
           "reading is larger, by an unknown amount.";
  return {
      "Line: median of the taxels’ errors. Dark: median ± median U. Light: 2.5 % quantile of error − U to 97.5 % "
      "quantile of error + U. U: expanded uncertainty of one reading, coverage probability about 95 %, for “",
      readings.kind,
      "”, the worst of the histories measured. Triangles: beyond the axis. Green: measuring interval, where |error| "
      "+ U of 95 % of the taxels is within ",
      doc::both_units(readings.tolerance_psi),
      readings.by_mpe ? ", the maximum permissible error."
                      : fmt::format(", {:.0f} % of full pressure.", 100.0 * kToleratedShare),
      " Values: ",
      doc::StyledText{"every level", doc::TextStyle::kPlain, "levels"},
      "."};
}

Document uses(const ReportInput& input) {
  Document out;
  out.add(doc::Heading{3, "Holds for", {}});
  doc::List list;
  std::string others;
  if (input.uncertainty)
    for (const ConditionUncertainty& kind : input.uncertainty->conditions) {
      const std::string& name = kind.name;
      if (kind.valid())
        list.items.push_back(
            {doc::StyledText{"✓ ", doc::TextStyle::kGood}, name, ": median U ", doc::pressure(kind.median_psi)});
      else
        others += (others.empty() ? "" : "; ") + name;
    }
  if (!others.empty())
    list.items.push_back({doc::StyledText{"✗ ", doc::TextStyle::kBad}, doc::quiet("not for: " + others)});
  if (list.items.empty()) list.items.push_back({"U of a reading was not assessed"});
  if (!input.history.presses)
    list.items.push_back(
        {doc::StyledText{"✓ ", doc::TextStyle::kGood}, "uniform pressure on the whole array, ",
         input.laboratory.mounting.empty() ? "interface material as calibrated" : input.laboratory.mounting});
  out.add(std::move(list));
  return out;
}

Document measured_by(const ReportInput& input) {
  Document out;
  out.add(doc::Heading{3, "Measured by", {}});
  for (const Traceability& one : traceability_of(input, input.unit))
    out.add(doc::Paragraph{{one.traceable ? doc::StyledText{one.statement}
                                          : doc::StyledText{"✗ " + one.statement, doc::TextStyle::kBad}}});
  for (const std::string& warning : instrument_warnings(input))
    out.add(doc::Paragraph{{doc::StyledText{"▲ " + warning, doc::TextStyle::kDoubt}}});
  return out;
}

Document taxels_and_open(const PageData& data) {
  const ReportInput& input = data.input;
  Document out;
  out.add(doc::Heading{3, "Taxels", {}});
  const auto all = static_cast<std::ptrdiff_t>(input.health.rows * input.health.columns);
  const auto excluded = std::ranges::count_if(input.health.findings, &TaxelHealth::excluded);
  Phrase used(fmt::format("{} of {} used", all - excluded, all));
  const Phrase findings = findings_summary(input.health);
  if (!findings.empty()) used.add("; ").add(findings);
  out.add(doc::Paragraph{used.add(".")});
  if (data.readings && data.readings->worst.taxel >= 0) {
    const WorstTaxel& worst = data.readings->worst;
    out.add(doc::Paragraph{
        {"Worst taxel: ", doc::strong(doc::text_of(Phrase(doc::Taxel{worst.taxel, input.health.columns}), input.unit)),
         ", ", doc::pressure_with_u(worst.error_psi, worst.expanded_psi), " at ", doc::pressure(worst.pressure_psi),
         " ", direction_text(worst.up), worst.kind.empty() ? "" : ", " + worst.kind, "."}});
  }
  if (const std::string names = not_assessed_text(input.judgement); !names.empty()) {
    out.add(doc::Heading{3, "Not assessed", {}});
    out.add(doc::Paragraph{{names + " (", doc::StyledText{"why", doc::TextStyle::kPlain, "not-assessed"}, ")."}});
  }
  return out;
}

}  // namespace

Document front_page(const PageData& data) {
  const ReportInput& input = data.input;
  Document out;
  out.add(letterhead(data));
  if (input.run.is_void())
    out.add(doc::Paragraph{{doc::StyledText{fmt::format("✗ VOID: declared void by {}: {} ({}). It no longer counts.",
                                                        input.run.void_by, input.run.void_reason, input.run.void_utc),
                                            doc::TextStyle::kBad}},
                           doc::Paragraph::kLarge});
  out.add(facts(data));
  const Document runs = runs_text(input, input.unit);
  const bool stated = states_conformity(input.judgement.overall) && !input.judgement.not_judged;
  doc::VerdictBox verdict{stated ? doc::style_of(*input.judgement.overall) : doc::TextStyle::kDoubt,
                          {verdict_names(input, input.unit)}};
  if (!runs.blocks.empty()) verdict.parts.push_back(runs);
  out.add(std::move(verdict));
  if (data.readings) {
    out.add(doc::Heading{2, headline(data.readings, input.unit), "readings"});
    out.add(readings_chart(*data.readings, input.unit));
    out.add(doc::Paragraph{chart_caption(*data.readings), doc::Paragraph::kNote});
  } else if (input.more.contacts.empty()) {
    out.add(doc::Heading{2, "The error of a reading was not assessed", "readings"});
  } else {
    out.add(contact_pages(data));
  }
  out.add(doc::SideBySide{
      .parts = {uses(input), taxels_and_open(data), measured_by(input)}, .shares = {1, 1, 1}, .ruled = true});
  return out;
}

std::string span_text(const MeasuringInterval& span, PressureUnit unit) {
  if (!span.any) return "nowhere";
  const auto whole = [&](double psi) {
    return doc::fixed_text(unit.of(psi), unit == PressureUnit(PressureUnit::kKilopascal) ? 0 : unit.digits(1));
  };
  if (span.low_psi == span.high_psi) return fmt::format("at {} {} alone", whole(span.low_psi), unit.symbol());
  return fmt::format("{} to {} {}", whole(span.low_psi), whole(span.high_psi), unit.symbol());
}

std::string title_case(std::string text) {
  if (!text.empty() && text.front() >= 'a' && text.front() <= 'z')
    text.front() = static_cast<char>(text.front() - 'a' + 'A');
  return text;
}

namespace {

constexpr double kShownShare =
    0.08;  // of the full pressure: the chart's axis, so that one bad taxel does not flatten the rest
constexpr double kShownTolerances = 1.7;
constexpr double kWideShare = 0.05;  // a second line if the limits state no MPE

Chart panel(const ReadingFigures& readings, bool up, PressureUnit unit) {
  const Stroke stroke = up ? kBlue : kBrown;
  const double most = unit.of(std::max(kShownShare * readings.full_psi, kShownTolerances * readings.tolerance_psi));
  Chart chart{
      .title = fmt::format("Error of a reading with its expanded uncertainty against pressure, {}",
                           up ? "increasing" : "decreasing"),
      .heading = up ? "Increasing pressure" : "Decreasing pressure",
      .width = up ? 336.0 : 344.0,
      .height = 256.0,
      .x = {fmt::format("reference pressure (gauge) in {}, below it in {}", unit.symbol(), unit.other().symbol()), 0.0,
            unit.of(readings.full_psi)},
      .y = {up ? fmt::format("error of a reading in {}", unit.symbol()) : "", -most, most},
      .heading_stroke = stroke};
  chart.x.second_unit = unit.other().symbol();
  chart.x.second_unit_factor = unit.other().of(1.0) / unit.of(1.0);
  if (!up) {
    chart.y.second_unit = "% of full pressure";
    chart.y.second_unit_factor = 100.0 / unit.of(readings.full_psi);
  }
  Band spread{
      readings.known() ? "95 % of the taxels, with U" : "95 % of the taxels", {}, {}, {}, up ? "#d7e4f2" : "#f1e0d3"};
  Band median{readings.known() ? "median, with U" : "", {}, {}, {}, up ? "#8db4dc" : "#d3a683"};
  Curve middle{"", {}, {}, {stroke.colour, "", 2.0}};
  for (const ReadingLevel& level : readings.levels) {
    if (level.up != up) continue;
    const double x = unit.of(level.pressure_psi), y = unit.of(level.median_error_psi),
                 u = unit.of(level.median_expanded_psi);
    for (Band* band : {&spread, &median}) band->x.push_back(x);
    spread.low.push_back(unit.of(level.low_psi));
    spread.high.push_back(unit.of(level.high_psi));
    median.low.push_back(y - u);
    median.high.push_back(y + u);
    middle.x.push_back(x);
    middle.y.push_back(y);
  }
  chart.bands = {spread, median};
  chart.curves = {middle};
  const MeasuringInterval& span = up ? readings.span_up : readings.span_down;
  if (span.any) chart.stretches.push_back({unit.of(span.low_psi), unit.of(span.high_psi), span_text(span, unit)});
  const auto tolerance = [&](double psi, const Stroke& line) {
    const std::string name = fmt::format("{} %: {} {}", doc::fixed_text(100.0 * psi / readings.full_psi, 0),
                                         doc::text_of(doc::bare_pressure(psi), unit), unit.symbol());
    chart.rules.push_back({unit.of(psi), readings.by_mpe ? "limit, " + name : name, line});
    chart.rules.push_back({-unit.of(psi), "", line});
  };
  tolerance(readings.tolerance_psi, kRed);
  if (!readings.by_mpe) tolerance(kWideShare * readings.full_psi, kRedDots);
  return chart;
}

}  // namespace

doc::SideBySide readings_chart(const ReadingFigures& readings, PressureUnit unit) {
  doc::SideBySide out;
  for (const bool up : {true, false}) {
    const Chart chart = panel(readings, up, unit);
    doc::Document part;
    part.add(doc::Drawing{chart_svg(chart), chart.title, {}});
    out.parts.push_back(std::move(part));
    out.shares.push_back(static_cast<int>(chart.width));
  }
  return out;
}

}  // namespace tactbench::analysis
