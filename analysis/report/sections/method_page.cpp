// Page 3: the method, the output before correction, the pressures applied, deviations, repeatability and zero, what was
// not assessed.
#include <algorithm>
#include <cmath>

#include "analysis/counted.h"
#include "analysis/report/document/document.h"
#include "analysis/report/page/chart.h"
#include "analysis/report/report_facts.h"
#include "analysis/report/sections/sections.h"

namespace tactbench::analysis {

namespace {

using doc::Document;
using doc::Phrase;

constexpr std::size_t kMostTrajectories = 6;
constexpr std::size_t kMostDeviations = 8;  // printed one by one

doc::Table method(const PageData& data) {
  const ReportInput& input = data.input;
  std::vector<std::pair<std::string, Phrase>> rows = {
      {"principle", input.history.presses
                        ? "an object pressed on the array under a force sensor"
                        : "the whole array under one gas pressure in a chamber, together with the pressure reference"}};
  for (std::size_t i = 0; i < input.run.sequences.size(); ++i) {
    const db::SequenceRecord& sequence = input.run.sequences[i];
    const bool known = i < input.method.size() && !input.method[i].empty();
    rows.emplace_back(sequence.name, known ? input.method[i] : counted(sequence.repeats, "repeat"));
  }
  const RunLog& history = input.history;
  rows.emplace_back("frames", fmt::format("{} used, {} flagged, {} in void branches", history.frames, history.flagged,
                                          history.void_frames));
  if (!input.fit.taxels.empty())
    rows.emplace_back("model", fmt::format("{}, of each taxel, from these frames", model_name(input.fit)));
  if (!input.held_out.empty()) {
    std::string titles;
    for (const HeldOut& own : input.held_out) titles += (titles.empty() ? "" : "; ") + own.title;
    rows.emplace_back("verification",
                      titles + ": the models are not from " + (input.held_out.size() == 1 ? "it" : "them"));
  }
  for (const db::RunRecord& further : input.further)
    rows.emplace_back("further run", fmt::format("run {}", further.run));
  doc::Table table = doc::pairs("Method", std::move(rows));
  table.dense = true;
  return table;
}

doc::Drawing loops(const ReportInput& input) {
  const Behaviour& b = input.behaviour;
  Chart chart{.title =
                  "Output before correction against pressure: loops of the mean taxel and of those with the least, "
                  "median and largest hysteresis",
              .width = 336.0,
              .height = 232.0,
              .x = {fmt::format("gauge pressure in {}", input.unit.symbol())},
              .y = {"output in V"},
              .labels_at_ends = true};
  std::size_t style = 0;
  for (const RawLoop& loop : b.loops) {
    const char* const name = loop.taxel < 0         ? "mean of all"
                             : loop.name == "best"  ? "least"
                             : loop.name == "worst" ? "largest"
                                                    : "median";
    Curve curve{fmt::format("{} {} %", name, doc::fixed_text(100.0 * loop.hysteresis_mean, 1)),
                {},
                {},
                kStrokes[style++ % std::size(kStrokes)]};
    for (std::size_t i = 0; i < 2 * b.pressure_psi.size(); ++i) {
      const std::size_t n = b.pressure_psi.size(),
                        at = i < n ? n - 1 - i : i - n;  // down, then up, which ends at the right
      curve.x.push_back(input.unit.of(b.pressure_psi[at]));
      curve.y.push_back(i < n ? loop.down_v[at] : loop.up_v[at]);
    }
    chart.curves.push_back(std::move(curve));
  }
  return {chart_svg(chart),
          chart.title,
          {"Output before correction; hysteresis, mean over the levels, in % of the taxel’s own full scale."}};
}

doc::SideBySide trajectories(const ReportInput& input) {
  doc::SideBySide out;
  const std::size_t shown = std::min(input.applied.size(), kMostTrajectories);
  for (std::size_t i = 0; i < shown; ++i) {
    const AppliedPressures& own = input.applied[i];
    Chart chart{.title = "Pressure applied over time: " + own.title,
                .width = shown > 3 ? 140.0 : 222.0,
                .height = 130.0,
                .x = {"min"},
                .y = {i == 0 ? input.unit.symbol() : "", 0.0, {}}};
    Curve curve{"", {}, {}, own.verification ? kBrown : kBlue};
    curve.stroke.width = 1.0;
    for (std::size_t k = 0; k < own.time_s.size(); ++k) {
      curve.x.push_back(own.time_s[k] / 60.0);
      curve.y.push_back(input.unit.of(own.pressure_psi[k]));
    }
    chart.curves = {std::move(curve)};
    Document part;
    part.add(doc::Drawing{chart_svg(chart),
                          chart.title,
                          {doc::strong(own.verification ? "Verification: " : "Calibration: "), own.title,
                           own.repeats > 1 ? fmt::format(", first of {}", counted(own.repeats, "repeat")) : ""}});
    out.parts.push_back(std::move(part));
  }
  return out;
}

// Also prints 0: otherwise a run without deviations would look like an unchecked one.
Document deviations(const ReportInput& input) {
  const RunLog& history = input.history;
  Document out;
  out.add(doc::Heading{3, "Deviations from the method", {}});
  if (!history.loaded) {
    out.add(doc::Paragraph{{"not available"}});
    return out;
  }
  const auto count = [&](const char* kind) {
    return std::ranges::count(history.events, std::string(kind), &RunLogEvent::kind);
  };
  std::string flags, checks;
  for (const auto& [word, frames] : history.flags)
    flags += fmt::format("{}{} {}", flags.empty() ? "" : ", ", frames, word);
  for (const db::CheckRecord& check : history.checks)
    checks += fmt::format("{}{} {}", checks.empty() ? "" : ", ", check.kind, check.verdict);
  out.add(doc::Paragraph{
      {fmt::format("{} void and repeated, {} after a fault, {}, {}, {}, {}; {} of {} frames flagged{}. Checks of the "
                   "set-up: {}. By the operator: {}.",
                   counted(history.voids.size(), "branch", "branches"), counted(count("attempt"), "attempt"),
                   counted(count("pause"), "pause"), counted(count("suspension"), "suspension"),
                   counted(count("fault"), "fault"), counted(count("warning"), "warning"), history.flagged,
                   history.frames, flags.empty() ? "" : " (" + flags + ")", checks.empty() ? "none recorded" : checks,
                   input.laboratory.deviations.empty() ? "none stated" : input.laboratory.deviations)}});
  doc::List list;
  for (const RunLogEvent& event : history.events)
    if (event.kind == "warning" || event.kind == "fault")
      list.items.push_back({fmt::format("at {} s, {}: ", doc::fixed_text(event.time_s, 0), event.kind), event.text});
  const std::size_t all = list.items.size();
  if (all > kMostDeviations) {
    list.items.resize(kMostDeviations);
    list.items.push_back({fmt::format("and {} more: --annex events", all - kMostDeviations)});
  }
  if (all > 0) out.add(std::move(list));
  return out;
}

doc::Table repeatability(const ReportInput& input) {
  const Behaviour& b = input.behaviour;
  doc::Table table{.id = "repeatability",
                   .caption = "Repeatability, zero and noise of the output",
                   .columns = {{"figure"}, {"increasing", true}, {"decreasing", true}}};
  const auto largest = [&](double LevelRepeatability::*member) {
    double most = kNan;
    for (const LevelRepeatability& level : b.repeatability)
      most = std::isnan(most) ? level.*member : std::max(most, level.*member);
    return doc::number(1e3 * most, 2);
  };
  if (!b.repeatability.empty()) {
    table.rows.push_back({{fmt::format("repeatability over {}, largest of the levels, mV: mean of all taxels",
                                       counted(b.repeats, "repeat")),
                           largest(&LevelRepeatability::mean_up_v), largest(&LevelRepeatability::mean_down_v)}});
    table.rows.push_back({{"the same for one taxel, root mean square, mV", largest(&LevelRepeatability::taxel_up_v),
                           largest(&LevelRepeatability::taxel_down_v)}});
  }
  for (const ZeroReturn& zero : b.zero_returns)
    table.rows.push_back(
        {{fmt::format("zero after minus zero before, {}, mV: mean of all taxels (largest of {})", zero.sequence,
                      counted(zero.repeats, "repeat")),
          "", Phrase(doc::number(1e3 * zero.mean_v, 2), " (", doc::number(1e3 * zero.largest_v, 2), ")")}});
  if (std::isfinite(input.health.median_noise_v) && !input.health.noise_v.empty())
    table.rows.push_back(
        {{"noise of one frame, median taxel, mV", "", doc::number(1e3 * input.health.median_noise_v, 2)}});
  for (const bool up : {true, false}) {
    std::vector<double> pressures, shares;
    for (const Creep& creep : b.creep) {
      if (creep.up != up) continue;
      pressures.push_back(creep.pressure_psi);
      shares.push_back(creep.per_decade);
    }
    if (shares.empty()) continue;
    const auto [low, high] = std::ranges::minmax(pressures);
    const auto [least, most] = std::ranges::minmax(shares);
    const Phrase range = shares.size() == 1 ? Phrase(doc::percent_of(most, 2))
                                            : Phrase(doc::percent_of(least, 2), " to ", doc::percent_of(most, 2));
    table.rows.push_back(
        {{Phrase("creep of the mean of all taxels, % per decade of time: ", counted(shares.size(), "hold"), ", ",
                 doc::bare_pressure(low), " to ", doc::pressure(high)),
          up ? range : Phrase(""), up ? Phrase("") : range}});
  }
  return table;
}

// Sources with one reason are one row.
doc::Table not_assessed(const PageData& data) {
  std::vector<std::pair<std::string, std::string>> rows;
  const auto add = [&](const std::string& name, const std::string& why) {
    const auto same = std::ranges::find(rows, why, &std::pair<std::string, std::string>::second);
    if (same == rows.end())
      rows.emplace_back(name, why);
    else
      same->first += "; " + name;
  };
  const ReportInput& input = data.input;
  for (const Source source : input.judgement.not_assessed) add(to_string(source), why_not_assessed(source));
  // "re-mounting" of the judgement is both contributions of that name to U.
  const auto listed = [&](const std::string& name) {
    return std::ranges::any_of(input.judgement.not_assessed,
                               [&](Source own) { return name.starts_with(to_string(own)); });
  };
  if (!input.uncertainty)
    add("uncertainty of a reading",
        input.fit.taxels.empty() ? "no models were made from this run" : "not assessed on this run");
  else
    for (std::size_t i = 0; i < kUncertaintySources; ++i)
      if (const std::string& why = input.uncertainty->missing[i]; !why.empty())
        if (const std::string name = text_of(static_cast<UncertaintySource>(i)).name; !listed(name)) add(name, why);
  doc::Table table = doc::pairs("Not assessed, and not in any U", {rows.begin(), rows.end()});
  table.id = "not-assessed";
  return table;
}

}  // namespace

Document method_page(const PageData& data) {
  const ReportInput& input = data.input;
  Document out, left, right;
  out.add(doc::Heading{2, "How it was measured", "how"});
  if (!input.applied.empty()) {  // first, because they fill the rest of the previous page
    out.add(doc::Heading{3, "Pressures applied", {}});
    out.add(trajectories(input));
  }
  left.add(method(data));
  if (!input.behaviour.loops.empty()) right.add(loops(input));
  out.add(right.blocks.empty() ? doc::SideBySide{{left}, {1}} : doc::SideBySide{{left, right}, {1, 1}});
  out.add(deviations(input));
  doc::Table figures = repeatability(input);
  if (!figures.rows.empty()) out.add(std::move(figures));
  out.add(not_assessed(data));
  return out;
}

}  // namespace tactbench::analysis
