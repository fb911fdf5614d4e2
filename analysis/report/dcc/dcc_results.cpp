// The measurement results of a DCC: readings of every taxel, and the figures that were judged.
#include <algorithm>
#include <cmath>

#include "analysis/counted.h"
#include "analysis/report/data/conformity.h"
#include "analysis/report/dcc/dcc.h"
#include "analysis/report/report_facts.h"

namespace tactbench::analysis::dcc {

namespace {

constexpr PressureUnit kUnit = PressureUnit::kKilopascal;

// The schema's word; empty: it has no such word (inconclusive, not judged, report only), and conformity is not stated.
const char* conformity_word(Verdict verdict) {
  switch (verdict) {
    case Verdict::kPass:
      return "pass";
    case Verdict::kConditionalPass:
      return "conditionalPass";
    case Verdict::kConditionalFail:
      return "conditionalFail";
    case Verdict::kFail:
      return "fail";
    case Verdict::kInconclusive:
    case Verdict::kReportOnly:
      break;
  }
  return "";
}

// The conformity, or why there is none.
Markup conformity(const Judgement& judgement, std::optional<Verdict> verdict, const std::string& said) {
  const char* const word = verdict && !judgement.not_judged ? conformity_word(*verdict) : "";
  const std::string why = *word != '\0'          ? ""
                          : judgement.not_judged ? "not judged: " + display_text(*judgement.not_judged, kUnit)
                          : verdict              ? std::string(to_string(*verdict)) + ": conformity is not stated"
                                                 : "not judged: no tolerance limits were given";
  const std::string words = said.empty() ? why : why.empty() ? said : why + ". " + said;
  Markup out;
  if (!words.empty()) out += declared(words);
  if (*word != '\0') out += markup("<dcc:conformity>{}</dcc:conformity>", Text(word));
  return out;
}

Markup method(const char* name, const std::string& words, const char* norm, const char* ref_type) {
  return markup("<dcc:usedMethod refType=\"{}\">{}{}{}</dcc:usedMethod>\n", Text(ref_type), name_of(name),
                described(words), *norm == '\0' ? Markup() : markup("<dcc:norm>{}</dcc:norm>", Text(norm)));
}

Markup calibration_method(const ReportInput& input) {
  std::string words = "The whole array under one gas pressure in a chamber, together with the pressure reference.";
  for (const std::string& sequence : input.method)
    if (!sequence.empty()) words += " " + sequence + ".";
  if (!input.laboratory.deviations.empty()) words += " Deviations: " + input.laboratory.deviations;
  return method("Comparison with a pressure reference", words, "", "basic_calibrationMethod");
}

Markup in_date(DueState state) {
  if (state == DueState::kNotStated) return {};
  return markup("<dcc:inValidityRange>{}</dcc:inValidityRange>", Text(state == DueState::kInDate ? "true" : "false"));
}

Markup equipment(const ReportInput& input) {
  Markup out;
  for (const db::DeviceRecord& device : input.run.devices) {
    const InstrumentCalibration own = calibration_of(device, input.laboratory.instruments);
    out += markup(
        "<dcc:measuringEquipment{}>{}",
        own.role.starts_with("pressure reference") ? Markup::literal(" refType=\"basic_standardUsed\"") : Markup(),
        name_of(own.role));
    if (own.traceable())
      out += markup(
          "<dcc:certificate><dcc:referral><dcc:content>{}</dcc:content></dcc:referral><dcc:referralID>{}"
          "</dcc:referralID><dcc:procedure>none</dcc:procedure><dcc:value>not stated</dcc:value>{}{}</dcc:certificate>",
          stated_text(own.calibrated_by), stated_text(own.certificate),
          described(
              fmt::format("calibrated {}, due {}", doc::stated(own.calibrated_on).text, doc::stated(own.due).text)),
          in_date(due_state(own, input.run.started_utc)));
    if (!own.model.empty()) out += markup("<dcc:model>{}</dcc:model>", stated_text(own.model));
    if (!own.serial.empty()) out += serial_number(own.serial);
    out += Markup::literal("</dcc:measuringEquipment>\n");
  }
  return out;
}

Markup condition(const char* name, const Markup& status, const Markup& data) {
  return markup("<dcc:influenceCondition>{}{}<dcc:data>{}</dcc:data></dcc:influenceCondition>\n", name_of(name), status,
                data);
}

Markup text_data(const std::string& words) { return markup("<dcc:text>{}</dcc:text>", english(words)); }

Markup conditions(const ReportInput& input, const char* status) {
  Markup out, state;
  const auto temperature =
      std::ranges::find(input.history.surroundings, std::string("temperature_c"), &EnvironmentRange::quantity);
  if (temperature != input.history.surroundings.end()) {
    Markup data;
    for (const auto& [type, name, celsius] : {std::tuple("basic_temperatureMin", "lowest", temperature->low),
                                              {"basic_temperatureMax", "highest", temperature->high}}) {
      Markup number;
      append_number(number, celsius, 4);
      data += markup(
          "<dcc:quantity refType=\"{}\">{}<si:real><si:value>{}</si:value><si:unit>\\degreecelsius</si:unit></si:real>"
          "</dcc:quantity>",
          Text(type), name_of(name), number);
    }
    out += condition("Temperature of the surroundings", {}, data);
  }
  if (!input.laboratory.environment.empty() || temperature == input.history.surroundings.end())
    out += condition("Surroundings", {}, text_data(doc::stated(input.laboratory.environment).text));
  out += condition("Mounting, interface material", {}, text_data(doc::stated(input.laboratory.mounting).text));
  out += condition("Medium", {}, text_data("gauge pressure; " + doc::stated(input.laboratory.medium).text));
  if (*status != '\0')
    out += condition(
        "State of the models", markup("<dcc:status>{}</dcc:status>", Text(status)),
        text_data("as found: with the models from before this calibration; as left: with the models made from it"));
  return out;
}

struct ResultParts {
  std::string name;
  Markup methods, results;
  const char* ref_type = "";
  const char* status = "";  // beforeAdjustment | afterAdjustment | empty
};

Markup measurement_result(const ReportInput& input, const ResultParts& parts) {
  return markup(
      "<dcc:measurementResult{}>{}<dcc:usedMethods>\n{}</dcc:usedMethods>\n<dcc:usedSoftware>{}</dcc:usedSoftware>\n"
      "<dcc:measuringEquipments>\n{}</dcc:measuringEquipments>\n<dcc:influenceConditions>\n{}</dcc:influenceConditions>"
      "\n<dcc:results>\n{}</dcc:results></dcc:measurementResult>\n",
      *parts.ref_type == '\0' ? Markup() : markup(" refType=\"{}\"", Text(parts.ref_type)), name_of(parts.name),
      parts.methods, software(input.program_version), equipment(input), conditions(input, parts.status), parts.results);
}

Markup taxel_names(const ReportInput& input, std::size_t taxels) {
  Markup names;
  for (std::size_t i = 0; i < taxels; ++i) {
    const int at = static_cast<int>(i), columns = std::max(1, input.fit.columns);
    names += markup("{}{},{}", i == 0 ? Markup() : Markup::literal(" "), at / columns, at % columns);
  }
  return markup("<dcc:quantity refType=\"tb_taxels\">{}<dcc:charsXMLList>{}</dcc:charsXMLList></dcc:quantity>\n",
                name_of("taxels, row,column from 0"), names);
}

// One level: error, U and k of all taxels.
Markup level_list(const ConditionUncertainty& kind, std::size_t level) {
  const std::size_t width = kind.taxels();
  Markup error, expanded, factor;
  const auto k = markup("{}", Text(fmt::format("{:.3f}", kind.factor)));  // its pattern has no exponent
  for (std::size_t i = level * width; i < (level + 1) * width; ++i) {
    const bool known = std::isfinite(kind.error_psi[i]) && std::isfinite(kind.expanded_psi[i]);
    for (Markup* const list : {&error, &expanded, &factor})
      if (i > level * width) *list += Markup::literal(" ");
    append_number(error, known ? kUnit.of(kind.error_psi[i]) : kNan, 5);
    append_number(expanded, known ? kUnit.of(kind.expanded_psi[i]) : kNan, 4);
    if (known)
      factor += k;
    else
      append_number(factor, kNan, 4);
  }
  return markup(
      "<dcc:list>{}<dcc:quantity refType=\"basic_referenceValue\">{}<si:real>{}</si:real></dcc:quantity>\n"
      "<dcc:quantity refType=\"basic_measurementError\">{}<si:realListXMLList><si:valueXMLList>{}</si:valueXMLList>"
      "<si:unitXMLList>\\kilo\\pascal</si:unitXMLList><si:measurementUncertaintyUnivariateXMLList>"
      "<si:expandedMUXMLList><si:valueExpandedMUXMLList>{}</si:valueExpandedMUXMLList><si:coverageFactorXMLList>{}"
      "</si:coverageFactorXMLList><si:coverageProbabilityXMLList>{}</si:coverageProbabilityXMLList>"
      "</si:expandedMUXMLList></si:measurementUncertaintyUnivariateXMLList></si:realListXMLList></dcc:quantity>"
      "</dcc:list>\n",
      name_of(fmt::format("reference value {}", both_units(kind.pressure_psi[level]))),
      name_of("reference value, gauge pressure"), real(kUnit.of(kind.pressure_psi[level]), 6, true),
      name_of("error of the corrected indication"), error, expanded, factor,
      Text(fmt::format("{}", kCoverageProbability)));
}

Markup readings_of(const ReportInput& input, const ConditionUncertainty& kind, bool as_left) {
  ResultParts parts{.name = "Corrected indication of each taxel: error, U and k. Kind of history: " + kind.name,
                    .methods = calibration_method(input),
                    .results = {},
                    .ref_type = "tb_kind",
                    .status = as_left ? "afterAdjustment" : ""};
  parts.methods += method(
      "Expanded uncertainty",
      fmt::format("U belongs to one corrected indication of one taxel after subtraction of its known error, stated "
                  "with it; it is not the uncertainty of that error. Coverage probability about 95 %; k is the factor "
                  "of the errors counted, in {} of {}, and the reference's own part is added as (2 u) squared. Valid "
                  "for: {}; based on {}; uniform pressure over the array, interface material as calibrated. Not valid "
                  "for other histories, mountings, temperatures or days than those named.",
                  counted(kind.readings, "reading"),
                  counted(kind.histories, "independent history", "independent histories"), kind.name, kind.basis),
      "JCGM 100:2008", "basic_uncertainty");
  for (const bool up : {true, false}) {
    Markup levels;
    for (std::size_t i = 0; i < kind.pressure_psi.size(); ++i)
      if (kind.up[i] == up) levels += level_list(kind, i);
    if (levels.value.empty()) continue;
    const char* const direction = direction_text(up);
    parts.results += markup("<dcc:result>{}<dcc:data><dcc:list>{}{}{}</dcc:list></dcc:data></dcc:result>\n",
                            name_of(fmt::format("Gauge pressure, {}", direction)), name_of(direction),
                            taxel_names(input, kind.taxels()), levels);
  }
  return measurement_result(input, parts);
}

Markup judged_figure(const ReportInput& input, const Judgement& judgement, const JudgedFigure& figure) {
  const bool pressure = quantity_of(figure.criterion) == Quantity::kPressure;
  const auto shown = [&](double value, int digits) {
    return real(pressure ? kUnit.of(value) : value, digits, pressure);
  };
  Markup u;
  if (figure.u.expanded > 0.0) {  // a NaN is not
    Markup expanded;
    append_number(expanded, pressure ? kUnit.of(figure.u.expanded) : figure.u.expanded, 4);
    u = markup(
        "<si:measurementUncertaintyUnivariate><si:expandedMU><si:valueExpandedMU>{}</si:valueExpandedMU>"
        "<si:coverageFactor>{}</si:coverageFactor><si:coverageProbability>{}</si:coverageProbability></si:expandedMU>"
        "</si:measurementUncertaintyUnivariate>",
        expanded, Text(figure.u.factor >= 1.0 ? fmt::format("{:.3f}", figure.u.factor) : "NaN"),
        Text(fmt::format("{}", kCoverageProbability)));
  }
  return markup(
      "<dcc:quantity>{}<si:real>{}{}</si:real><dcc:measurementMetaData><dcc:metaData refType=\"basic_conformity\">{}"
      "<dcc:data><dcc:quantity refType=\"basic_toleranceLimitUpper\">{}<si:real>{}</si:real></dcc:quantity></dcc:data>"
      "</dcc:metaData></dcc:measurementMetaData></dcc:quantity>\n",
      name_of(requirement_name(figure, kUnit) + ", " + title_of_judged(input, figure.run)), shown(figure.value, 6), u,
      conformity(judgement, figure.verdict, ""), name_of("tolerance limit"), shown(figure.limit, 6));
}

Markup judged(const ReportInput& input, const Judgement& judgement, const char* name, const char* status) {
  if (judgement.figures.empty()) return {};
  ResultParts parts{
      .name = name, .methods = calibration_method(input), .results = {}, .ref_type = "", .status = status};
  for (const DecisionRule rule : rules_of(judgement))
    parts.methods += method("Decision rule", rule_text(rule), "ILAC-G8:09/2019", "basic_conformity");
  Markup figures;
  for (const JudgedFigure& figure : judgement.figures) figures += judged_figure(input, judgement, figure);
  parts.results = markup("<dcc:result>{}<dcc:data>\n{}</dcc:data></dcc:result>\n", name_of(name), figures);
  return measurement_result(input, parts);
}

}  // namespace

Markup conformity_statement(const ReportInput& input) {
  const Judgement& judgement = input.judgement;
  std::string said;
  if (!judgement.limits_sha256.empty())
    said = fmt::format("All requirements on all judged runs together: {}; limits file SHA-256 {}",
                       statement_text(judgement, kUnit), judgement.limits_sha256);
  std::string rules;
  for (const DecisionRule rule : rules_of(judgement)) rules += (rules.empty() ? "" : " ") + rule_text(rule) + ".";
  return markup("<dcc:statement refType=\"basic_conformity\">{}{}{}</dcc:statement>\n", name_of("Conformity"),
                rules.empty() ? Markup() : markup("<dcc:convention>{}</dcc:convention>", stated_text(rules)),
                conformity(judgement, judgement.overall, said));
}

Markup measurement_results(const PageData& data) {
  const ReportInput& input = data.input;
  Markup out = Markup::literal("<dcc:measurementResults>\n");
  for (const ConditionUncertainty& kind : input.uncertainty->conditions)
    if (kind.valid() && !kind.pressure_psi.empty()) out += readings_of(input, kind, input.more.previous.has_value());
  const bool both = input.more.previous.has_value();
  out += judged(input, input.judgement, both ? "JudgementRecord figures, as left" : "JudgementRecord figures",
                both ? "afterAdjustment" : "");
  if (both)
    out += judged(input, input.more.previous->judgement, "JudgementRecord figures, as found", "beforeAdjustment");
  return out += Markup::literal("</dcc:measurementResults>\n");
}

}  // namespace tactbench::analysis::dcc
