#include <algorithm>
#include <nlohmann/json.hpp>
#include <set>

#include "analysis/json_io.h"
#include "analysis/report/data/data.h"
#include "analysis/report/data/section_data.h"
#include "analysis/report/page/figure.h"
#include "analysis/report/parts.h"
#include "analysis/report/sections/sections.h"
#include "analysis/statistics/figures/levels.h"

namespace tactbench::analysis {

using html::markup;
using html::Markup;
using html::Text;

namespace {

constexpr std::size_t kMostFindingsListed = 64;

std::vector<std::pair<std::string, std::string>> health_rules(const Health& health) {
  const HealthOptions& o = health.options;
  return {{"dead", fmt::format("output moves less than {:g} V over the whole run and stays below that{}", o.dead_v,
                               health.loaded ? "" : "; not assessed: the run pressed on a part of the array only")},
          {"stuck", fmt::format("output moves less than {:g} V over the whole run, away from 0 V{}", o.dead_v,
                                health.loaded ? "" : "; not assessed: the run pressed on a part of the array only")},
          {"saturated", "at least one sample at the limit of the converter"},
          {"unfit", fmt::format("output moves, but not with the pressure, or no model meets it better than {:g} % of "
                                "the taxel's full scale",
                                100.0 * kUnfitShare)},
          {"noisy", health.noise_v.empty()
                        ? std::string("not assessed: one scan a frame gives no noise")
                        : fmt::format("standard deviation of a sample, from the scans of one frame, above {:g} times "
                                      "the median taxel's {:.2f} mV",
                                      o.noisy_factor, 1e3 * health.median_noise_v)}};
}

// "unfit" is the key of limits files and data.
Text state_in_words(const std::string& state) { return Text(state == "unfit" ? "not modelled" : state); }

Markup rules_table(const Health& health) {
  Markup out = markup(
      "<table><caption>Criteria of sensor health</caption><thead><tr><th scope=\"col\">state</th><th scope=\"col\" "
      "class=\"n\">taxels</th><th scope=\"col\">criterion</th></tr></thead>"
      "<tbody>\n");
  for (const auto& [state, words] : health_rules(health)) {
    out += markup("<tr><th scope=\"row\">{}</th><td class=\"n\">{}</td><td>{}</td></tr>\n", state_in_words(state),
                  health.count(state), Text(words));
  }
  out += markup(
      "</tbody></table>\n<p class=\"note\">Dead, stuck, saturated and unmodelled taxels are excluded from loops, "
      "hysteresis, relative sensitivity, repeatability, zero deviation, creep, models, corrected indications, means "
      "and standard deviations; only their indication is shown, in the frames. Noisy taxels count everywhere.</p>\n");
  return out;
}

Markup findings_table(const Health& health) {
  Markup out = markup(
      "<table><caption>Taxels with findings</caption><thead><tr><th scope=\"col\">taxel</th>"
      "<th scope=\"col\">place</th><th scope=\"col\">state</th><th scope=\"col\">criterion</th>"
      "<th scope=\"col\">excluded from</th></tr></thead><tbody>\n");
  for (std::size_t i = 0; i < health.findings.size() && i < kMostFindingsListed; ++i) {
    const TaxelHealth& finding = health.findings[i];
    out += markup("<tr><th scope=\"row\">{}</th><td>{}</td><td class=\"state\">{}</td><td>{}</td><td>{}</td></tr>\n",
                  finding.taxel, Text(place_of(finding.taxel, health.columns)), state_in_words(finding.state),
                  Text(finding.reason), Text(finding.excluded ? "every figure" : "nothing"));
  }
  out += markup("</tbody></table>\n");
  if (health.findings.size() > kMostFindingsListed)
    out += markup("<p class=\"note\">The first {} of {} are printed; all stand in the data.</p>\n", kMostFindingsListed,
                  health.findings.size());
  return out;
}

Markup swaps_words(const ReportInput& input) {
  const Health& health = input.health;
  if (!health.swaps_assessed)
    return markup(
        "<p>Swapped rows or columns: not assessed, {}.</p>\n",
        Text(input.history.seating_v.empty() ? "this run has no seating check"
                                             : "there is no earlier good seating of this sensor to compare with"));
  Markup out = markup(
      "<p>Swapped rows or columns: {}. Each pair of lines of the seating check was compared with the earlier good "
      "seating, of run {}; lines count as swapped when they fit at least {} better in each other’s place, with a "
      "correlation of at least {}. Taxels left out do not count.</p>\n",
      Text(health.swaps.empty()
               ? "none found"
               : fmt::format("{} {} found", health.swaps.size(), health.swaps.size() == 1 ? "pair" : "pairs")),
      input.history.earlier_seating_run, html::fixed(health.options.swap_margin, 1),
      html::fixed(health.options.swap_correlation, 1));
  for (const SwappedLines& swap : health.swaps) {
    const char* what = swap.rows ? "rows" : "columns";
    out += markup(
        "<p class=\"fail\"><span class=\"sign\">✗</span> {} {} and {} stand in each other’s place (correlation {} "
        "exchanged, {} as they are)</p>\n",
        Text(what), swap.first, swap.second, html::fixed(swap.exchanged, 2), html::fixed(swap.as_is, 2));
  }
  if (!health.swaps.empty())
    out += markup(
        "<p class=\"note\">No figure excludes swapped lines: the figures of this run hold as the lines are wired "
        "now. Maps and models made before belong to the other line.</p>\n");
  return out;
}

// The seating check's findings, from its JSON.
Markup seating_words(const ReportInput& input) {
  Markup out;
  for (const db::CheckRecord& check : input.history.checks) {
    if (check.kind != "seating") continue;
    const auto json = try_json(check.detail_json);
    if (!json.is_object() || !json.contains("findings") || !json["findings"].is_array()) continue;
    for (const auto& finding : json["findings"]) {
      if (!finding.is_object() || !finding.contains("text") || !finding["text"].is_string()) continue;
      out += markup("<li>{}</li>\n", Text(finding["text"].get<std::string>()));
    }
  }
  if (out.value.empty()) return out;
  return markup("<p>Findings of the seating check:</p>\n<ul>\n{}</ul>\n", out);
}

Markup response_map(const Health& health) {
  std::vector<double> span;
  std::set<int> bad;
  for (const TaxelHealth& finding : health.findings)
    if (finding.excluded) bad.insert(finding.taxel);
  for (std::size_t i = 0; i < health.high_v.size(); ++i) {
    const bool out = bad.contains(static_cast<int>(i));
    span.push_back(out ? kNan : health.high_v[i] - health.low_v[i]);
  }
  const Spread spread = spread_of(span);
  if (spread.count == 0) return {};
  const ColourScale scale{0.0, spread.high > 0.0 ? spread.high : 1.0};
  Markup out =
      markup("<figure>{}",
             frame_map({"Span of each taxel's output over the run", health.rows, health.columns, span, scale, 220.0}));
  out += colour_bar(scale, "Colour scale of the spans", "V", 2);
  out += markup(
      "<figcaption>Span of the output over the run: highest less lowest. A cross marks an excluded taxel."
      "</figcaption></figure>\n");
  return out;
}

Markup noise_histogram(const Health& health) {
  if (health.noise_v.empty()) return {};
  Histogram histogram;
  histogram.title = "Noise of one sample, number of taxels";
  histogram.x_label = "noise of one sample in mV";
  histogram.y_label = "taxels";
  for (const double noise : health.noise_v) histogram.values.push_back(1e3 * noise);
  histogram.limit = 1e3 * health.options.noisy_factor * health.median_noise_v;
  histogram.limit_name = "noisy above";
  histogram.width = 420;
  histogram.height = 240;
  return markup(
      "<figure>{}<figcaption>Standard deviation of one sample of each taxel; {} beyond the "
      "line.</figcaption></figure>\n",
      histogram_chart(histogram), health.count("noisy"));
}

}  // namespace

Markup health_section(const ReportInput& input) {
  const Health& health = input.health;
  Markup out = section_start("health", "Sensor health");
  if (health.high_v.empty()) {
    out += markup("<p>not available</p>\n");
    return out;
  }
  const auto taxels = health.high_v.size();
  const auto excluded = std::ranges::count_if(health.findings, &TaxelHealth::excluded);
  out += markup("<p>{} of {} taxels used, {} excluded.</p>\n", taxels - static_cast<std::size_t>(excluded), taxels,
                excluded);
  out += rules_table(health);
  if (!health.findings.empty()) out += findings_table(health);
  out += swaps_words(input);
  out += seating_words(input);
  out += markup("<div class=\"pair\">\n{}{}</div>\n", response_map(health), noise_histogram(health));
  return out;
}

std::string health_json(const ReportInput& input) {
  const Health& health = input.health;
  nlohmann::ordered_json findings = nlohmann::ordered_json::array(), swaps = nlohmann::ordered_json::array();
  for (const TaxelHealth& finding : health.findings)
    findings.push_back({{"taxel", finding.taxel},
                        {"state", finding.state},
                        {"reason", finding.reason},
                        {"excluded", finding.excluded}});
  for (const SwappedLines& swap : health.swaps)
    swaps.push_back({{"lines", swap.rows ? "rows" : "columns"},
                     {"first", swap.first},
                     {"second", swap.second},
                     {"correlation_as_is", swap.as_is},
                     {"correlation_exchanged", swap.exchanged}});
  return json_text({{"dead_v", health.options.dead_v},
                    {"noisy_factor", health.options.noisy_factor},
                    {"median_noise_v", health.median_noise_v},
                    {"low_v", number_list(health.low_v)},
                    {"high_v", number_list(health.high_v)},
                    {"noise_v", number_list(health.noise_v)},
                    {"findings", findings},
                    {"swaps_assessed", health.swaps_assessed},
                    {"swaps", swaps}});
}

}  // namespace tactbench::analysis
