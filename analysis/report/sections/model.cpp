#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "analysis/identify/dynamic/dynamic_alone.h"
#include "analysis/report/page/figure.h"
#include "analysis/report/parts.h"
#include "analysis/report/sections/sections.h"

namespace tactbench::analysis {

using html::markup;
using html::Markup;
using html::Text;

namespace {

constexpr std::size_t kParameters = kElamParameterNames.size();

// Of ELAM: those of the other models are many, and no five of them say what the model is.
std::array<double, kParameters> parameters_of(const ModelTaxel& taxel) {
  const ElamParameters& p = elam_of(taxel)->parameters;
  return {p.alpha_d, p.beta_d, p.alpha_a1, p.alpha_a0, p.beta_a};
}

bool is_elam(const SensorModel& fit) { return elam_of(fit.mean_taxel()) != nullptr; }

Text name_of(const SensorModel& fit) { return Text(model_name(fit)); }

Text unit_of(std::size_t parameter) { return Text(parameter == 2 ? "1/psi" : "1"); }

bool at_bound(const ModelFit& fit, std::size_t parameter) { return ((fit.at_bound >> parameter) & 1u) != 0; }

Markup mean_taxel_table(const ReportInput& input) {
  const ModelTaxel& mean = input.fit.mean_taxel();
  Markup out = markup(
      "<table><caption>{} of the mean taxel</caption><thead><tr><th scope=\"col\">quantity</th>"
      "<th scope=\"col\" class=\"n\">value</th><th scope=\"col\">unit</th><th "
      "scope=\"col\">remark</th></tr></thead><tbody>\n",
      name_of(input.fit));
  const auto row = [&](const html::Safe& name, const html::Safe& value, const html::Safe& unit,
                       const html::Safe& remark) {
    out += markup("<tr><th scope=\"row\">{}</th><td class=\"n\">{}</td><td>{}</td><td>{}</td></tr>\n", name, value,
                  unit, remark);
  };
  for (std::size_t i = 0; is_elam(input.fit) && i < kParameters; ++i) {
    row(Text(kElamParameterNames[i]), html::fixed(parameters_of(mean)[i], 4), unit_of(i),
        Text(at_bound(mean.fit, i) ? "at a bound of the search" : ""));
  }
  const double full_scale = mean.full_scale();
  row(Text("J, Eq. (1)"), html::fixed(mean.fit.j, 4), Text("V²"),
      Text("sum of squared differences, model and measured"));
  row(Text("mean error, Eq. (49)"), html::fixed(mean.fit.mean_error, 4), Text("V"),
      markup("{} % FS", html::percent(mean.fit.mean_error / full_scale, 2)));
  row(Text("maximum error"), html::fixed(mean.fit.max_error, 4), Text("V"),
      markup("{} % FS", html::percent(mean.fit.max_error / full_scale, 2)));
  row(Text("full scale (FS)"), html::fixed(full_scale, 3), Text("V"),
      markup("of the mean taxel: {}", Text(kFullScaleOfModel)));
  row(Text("noise of one sample"), html::fixed(1000.0 * mean.noise, 2), Text("mV"), Text("standard deviation"));
  out += markup("</tbody></table>\n");
  return out;
}

// What a dynamic model undoes beside hysteresis, and the runs that this was taken from.
Markup dynamics_table(const SensorModel& fit, PressureUnit unit) {
  if (!fit.dynamics) return {};
  const bool one_run = fit.dynamics->rate.run == 0;
  if (one_run && !in_time(*fit.dynamics))
    return markup(
        "<p class=\"note\">Preisach's model on the linearised output u = v / (1 − c v), with an observer of the gain "
        "at full pressure. Creep and lag are left in: the models come from one run, which tells no creep.</p>\n");
  const Dynamics& d = fit.dynamics->shared;
  Markup creep;
  for (std::size_t j = 0; j < kCreepElements; ++j)
    creep += markup("{}{} % in {} s", Text(j == 0 ? "" : ", "), html::percent(d.creep_share[j], 2),
                    html::significant(d.creep_s[j], 3));
  const auto source = [](const SensorDynamics::Source& from) {
    return from.run == 0 ? markup("the fitted run") : markup("run {}, content {}", from.run, code(from.content_sha256));
  };
  const Markup creeps = markup("{} of the output; half of it at {}", creep, html::pressure(d.creep_half, unit, 1));
  const bool own = creep_of_fitted_run(*fit.dynamics) && fit.dynamics->creep.run != 0;
  const Markup creep_from =
      own ? markup("the fitted run; by taxel: {}", source(fit.dynamics->creep)) : source(fit.dynamics->creep);
  if (one_run && !undoes_lag(*fit.dynamics))
    return pairs_table("Creep that the models undo: the array's",
                       {{"creep", creeps}, {"creep taken from", creep_from}, {"lag", markup("left in")}});
  return pairs_table("Lag and creep that the models undo: the array's",
                     {{"lag", markup("{} % of a change of pressure comes late, in {} s", html::percent(d.lag_share, 1),
                                     html::fixed(d.lag_s, 2))},
                      {"lag taken from", source(fit.dynamics->rate)},
                      {"creep", creeps},
                      {"creep taken from", creep_from}});
}

std::vector<const ModelTaxel*> fitted(const SensorModel& fit) {
  std::vector<const ModelTaxel*> out;
  for (const ModelTaxel& taxel : fit.array()) {
    if (taxel.status == TaxelStatus::kFitted) out.push_back(&taxel);
  }
  return out;
}

Markup distribution_table(const ReportInput& input) {
  const auto taxels = fitted(input.fit);
  Markup out = markup(
      "<table><caption>{} of the {} fitted taxels: distribution</caption><thead><tr><th scope=\"col\">quantity</th>"
      "<th scope=\"col\">unit</th><th scope=\"col\" class=\"n\">minimum</th><th scope=\"col\" class=\"n\">median</th>"
      "<th scope=\"col\" class=\"n\">maximum</th><th scope=\"col\" class=\"n\">taxels at a "
      "bound</th></tr></thead><tbody>\n",
      name_of(input.fit), taxels.size());
  const auto row = [&](const html::Safe& name, const html::Safe& unit, std::vector<double> values, int digits,
                       const html::Safe& bounds) {
    const Spread spread = spread_of(std::move(values));
    out += markup("<tr><th scope=\"row\">{}</th><td>{}</td>{}{}{}<td class=\"n\">{}</td></tr>\n", name, unit,
                  number_cell(html::fixed(spread.low, digits)), number_cell(html::fixed(spread.median, digits)),
                  number_cell(html::fixed(spread.high, digits)), bounds);
  };
  const auto collect = [&](auto figure) {
    std::vector<double> values;
    for (const ModelTaxel* taxel : taxels) values.push_back(figure(*taxel));
    return values;
  };
  for (std::size_t i = 0; is_elam(input.fit) && i < kParameters; ++i) {
    const auto bounds =
        std::count_if(taxels.begin(), taxels.end(), [&](const ModelTaxel* t) { return at_bound(t->fit, i); });
    row(Text(kElamParameterNames[i]), unit_of(i), collect([&](const ModelTaxel& t) { return parameters_of(t)[i]; }), 4,
        markup("{}", bounds));
  }
  const Text none("–");
  row(Text("J"), Text("V²"), collect([](const ModelTaxel& t) { return t.fit.j; }), 4, none);
  row(Text("mean error"), Text("V"), collect([](const ModelTaxel& t) { return t.fit.mean_error; }), 4, none);
  row(Text("mean error"), Text("% FS of the taxel"),
      collect([](const ModelTaxel& t) { return 100.0 * t.fit.mean_error / t.full_scale(); }), 2, none);
  row(Text("maximum error"), Text("V"), collect([](const ModelTaxel& t) { return t.fit.max_error; }), 4, none);
  row(Text("maximum error"), Text("% FS of the taxel"),
      collect([](const ModelTaxel& t) { return 100.0 * t.fit.max_error / t.full_scale(); }), 2, none);
  row(Text("full scale of the taxel"), Text("V"), collect([](const ModelTaxel& t) { return t.full_scale(); }), 3, none);
  row(Text("noise of one sample"), Text("mV"), collect([](const ModelTaxel& t) { return 1000.0 * t.noise; }), 2, none);
  out += markup("</tbody></table>\n");
  return out;
}

std::string reason_of(const ModelTaxel& taxel) {
  switch (taxel.status) {
    case TaxelStatus::kFitted:
      return "";
    case TaxelStatus::kDead:
      return "the output stays near 0 V";
    case TaxelStatus::kStuck:
      return "the output stays at one value other than 0 V";
    case TaxelStatus::kSaturated:
      return "the output stood at the limit of the converter";
    case TaxelStatus::kConstant:
      return "the output does not change";
    case TaxelStatus::kUnfit:
      if (!taxel.reason.empty()) return taxel.reason;
      if (!(taxel.full_scale() > 0.0)) return "the output moves, but not with the pressure";
      return fmt::format("the model's mean error, {} V, is too large", html::fixed(taxel.fit.mean_error, 3).value);
  }
  return "";
}

Markup unfitted_table(const SensorModel& fit) {
  Markup rows;
  for (std::size_t i = 0; i < fit.array().size(); ++i) {
    const TaxelStatus status = fit.taxels[i].status;
    if (status == TaxelStatus::kFitted) continue;
    rows += markup("<tr><th scope=\"row\">{}</th><td>{}</td><td>{}</td><td>{}</td></tr>\n", i,
                   Text(place_of(static_cast<int>(i), fit.columns)), Text(to_string(status)),
                   Text(reason_of(fit.taxels[i])));
  }
  if (rows.value.empty()) return markup("<p>All {} taxels were fitted; none was left out.</p>\n", fit.array().size());
  return markup(
      "<table><caption>Taxels without a model, left out of every figure of the corrected "
      "indication</caption><thead><tr>"
      "<th scope=\"col\">taxel</th><th scope=\"col\">place</th><th scope=\"col\">state</th><th "
      "scope=\"col\">reason</th></tr>"
      "</thead><tbody>\n{}</tbody></table>\n",
      rows);
}

Markup error_map(const ReportInput& input) {
  const Evaluation& evaluation = input.evaluation;
  const Spread spread = spread_of(evaluation.taxel_mean_error_psi);
  if (spread.count == 0) return markup("<p>Map of the error: not available</p>\n");
  const ColourScale scale{0.0, spread.high > 0.0 ? spread.high : 1.0};
  const PressureUnit unit = input.unit;
  const FrameMap map{fmt::format("Mean absolute error of each taxel in {}", unit.symbol()),
                     input.fit.rows,
                     input.fit.columns,
                     evaluation.taxel_mean_error_psi,
                     scale,
                     416.0};
  Markup out = markup("<figure>{}", numbered_map(pressure_map(map, unit), kTwoSignificant));
  out += pressure_bar(scale, "Colour scale of the error map", unit, 2);
  out += markup(
      "<figcaption>Mean of |corrected indication − reference value| of each taxel over all frames, in {}. Row 0 on "
      "top, "
      "column 0 on the left; a cross marks a taxel without a model.</figcaption></figure>\n",
      Text(unit.symbol()));
  return out;
}

Markup error_table(const ReportInput& input) {
  const Evaluation& evaluation = input.evaluation;
  const Health& health = input.health;
  const PressureUnit unit = input.unit;
  Markup out = markup(
      "<table><caption>Absolute error |corrected indication − reference value|, all fitted taxels and "
      "frames</caption><thead><tr>"
      "<th scope=\"col\">figure</th><th scope=\"col\" class=\"n\">all</th><th scope=\"col\" class=\"n\">without flat "
      "samples</th>"
      "</tr></thead><tbody>\n");
  const auto row = [&](const char* name, const html::Safe& all, const html::Safe& observable) {
    out += markup("<tr><th scope=\"row\">{}</th>{}{}</tr>\n", Text(name), number_cell(all), number_cell(observable));
  };
  row("mean", html::pressure(evaluation.mean_error_psi, unit, 3),
      html::pressure(evaluation.mean_error_observable_psi, unit, 3));
  row("maximum", html::pressure(evaluation.max_error_psi, unit, 2),
      html::pressure(evaluation.max_error_observable_psi, unit, 2));
  row("mean of the worst taxel", html::pressure(evaluation.worst_taxel_mean_error_psi, unit, 3), Text("not assessed"));
  out += markup("</tbody></table>\n");
  if (evaluation.worst_taxel >= 0) {
    const auto known = std::ranges::find(health.findings, evaluation.worst_taxel, &TaxelHealth::taxel);
    out += markup("<p class=\"note\">Worst taxel: {} ({}{}).</p>\n", evaluation.worst_taxel,
                  Text(place_of(evaluation.worst_taxel, input.fit.columns)),
                  Text(known == health.findings.end() ? "" : ", " + known->state));
  }
  return out;
}

}  // namespace

Markup model_section(const ReportInput& input) {
  Markup out = section_start(
      "model", is_elam(input.fit) ? "External Loop Adaptation Method (ELAM)" : "Hysteresis models of the taxels");
  // First: below a long table a map of this height would leave half a page blank.
  out += markup("<div class=\"beside\">\n{}<div>{}</div>\n</div>\n", error_map(input), error_table(input));
  out += mean_taxel_table(input);
  out += dynamics_table(input.fit, input.unit);
  out += distribution_table(input);
  out += markup(
      "<p class=\"note\">FS of a taxel: of its own external loop {}. Parameters of a taxel whose curve of decreasing "
      "pressure is saturated are weakly determined: judge the error, not the parameter.</p>\n",
      Text(kFullScaleOfModel));
  out += unfitted_table(input.fit);
  out += is_elam(input.fit) ? elam_parameters_part(input)
                            : markup(
                                  "<p class=\"note\">ELAM’s five parameters are not here: these models are of another "
                                  "kind. “tactbench fit RUN --model elam” makes ELAM’s.</p>\n");
  return out;
}

}  // namespace tactbench::analysis
