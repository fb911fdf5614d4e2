#include "analysis/report/dcc/dcc.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <vector>

#include "analysis/counted.h"
#include "analysis/report/data/conformity.h"
#include "analysis/report/data/traceability.h"
#include "analysis/report/document/document.h"
#include "analysis/report/report_facts.h"

namespace tactbench::analysis::dcc {
namespace {

using html::Markup;
using html::markup;
using html::Text;

constexpr const char* kLanguage = "en";  // language of the program's texts; typed texts have none

// "v0.1.0" of "0.1.0, commit 0123": a letter and numbers.
std::string release_of(const std::string& version) {
  return "v" + version.substr(0, version.find_first_not_of("0123456789."));
}

// Text in the form that the schema requires: not empty, no blanks at its ends; "not stated" if it is empty.
Text stated_text(const std::string& untrusted) {
  constexpr const char* kBlanks = " \t\r\n";
  const std::size_t from = untrusted.find_first_not_of(kBlanks);
  return Text(from == std::string::npos
                  ? doc::stated("").text
                  : doc::stated(untrusted.substr(from, untrusted.find_last_not_of(kBlanks) + 1 - from)).text);
}

// dcc:content
Markup english(const std::string& text) {
  return markup("<dcc:content lang=\"{}\">{}</dcc:content>", Text(kLanguage), stated_text(text));
}

// dcc:name in English
Markup name_of(const std::string& text) { return markup("<dcc:name>{}</dcc:name>", english(text)); }

// dcc:description in English
Markup described(const std::string& text) { return markup("<dcc:description>{}</dcc:description>", english(text)); }

// dcc:declaration in English
Markup declared(const std::string& text) { return markup("<dcc:declaration>{}</dcc:declaration>", english(text)); }

// dcc:name of a person, firm, instrument
Markup typed_name(const std::string& untrusted) {
  return markup("<dcc:name><dcc:content>{}</dcc:content></dcc:name>", stated_text(untrusted));
}

// dcc:software, this program
Markup software(const std::string& version) {
  return markup("<dcc:software>{}<dcc:release>{}</dcc:release><dcc:type>application</dcc:type>{}</dcc:software>",
                typed_name("tactbench"), stated_text(release_of(version)), described(version));
}

// dcc:identifications
Markup serial_number(const std::string& serial) {
  return markup(
      "<dcc:identifications><dcc:identification><dcc:issuer>manufacturer</dcc:issuer><dcc:value>{}</dcc:value>{}"
      "</dcc:identification></dcc:identifications>",
      stated_text(serial), name_of("serial number"));
}

void append_number(Markup& to, double value, int digits) {
  if (!std::isfinite(value)) {
    to.value += "NaN";
    return;
  }
  std::array<char, 32> text;
  const auto end =
      std::to_chars(text.data(), text.data() + text.size(), value + 0.0, std::chars_format::general, digits);
  to.value.append(text.data(), end.ptr);
}

// si:value, si:unit; `digits` significant ones
Markup real(double value, int digits, bool kilopascal) {
  Markup number;
  append_number(number, value, digits);
  return markup("<si:value>{}</si:value><si:unit>{}</si:unit>", number, Text(kilopascal ? "\\kilo\\pascal" : "\\one"));
}

// The measurement results of a DCC: readings of every taxel, and the figures that were judged.

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
  const std::string text = said.empty() ? why : why.empty() ? said : why + ". " + said;
  Markup out;
  if (!text.empty()) out += declared(text);
  if (*word != '\0') out += markup("<dcc:conformity>{}</dcc:conformity>", Text(word));
  return out;
}

Markup method(const char* name, const std::string& text, const char* norm, const char* ref_type) {
  return markup("<dcc:usedMethod refType=\"{}\">{}{}{}</dcc:usedMethod>\n", Text(ref_type), name_of(name),
                described(text), *norm == '\0' ? Markup() : markup("<dcc:norm>{}</dcc:norm>", Text(norm)));
}

Markup calibration_method(const ReportInput& input) {
  std::string text = "The whole array under one gas pressure in a chamber, together with the pressure reference.";
  for (const std::string& sequence : input.method)
    if (!sequence.empty()) text += " " + sequence + ".";
  if (!input.laboratory.deviations.empty()) text += " Deviations: " + input.laboratory.deviations;
  return method("Comparison with a pressure reference", text, "", "basic_calibrationMethod");
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

Markup text_data(const std::string& text) { return markup("<dcc:text>{}</dcc:text>", english(text)); }

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

// One statement about all judged figures.
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
  out += judged(input, input.judgement, both ? "Judged figures, as left" : "Judged figures",
                both ? "afterAdjustment" : "");
  if (both) out += judged(input, input.more.previous->judgement, "Judged figures, as found", "beforeAdjustment");
  return out += Markup::literal("</dcc:measurementResults>\n");
}

}  // namespace
}  // namespace tactbench::analysis::dcc

namespace tactbench::analysis {
namespace {

using namespace dcc;

// The schema's release.
constexpr const char* kSchemaVersion = "3.3.0";

// The days on which the report's runs were made.
struct Performance {
  std::string begin, end;
};
Performance performance_of(const ReportInput& input) {
  Performance days;
  const auto widen = [&](const db::RunRecord& run) {
    const std::string from = run.started_utc.substr(0, 10), to = run.ended_utc.substr(0, 10);
    if (!is_date(from)) return;
    if (days.begin.empty() || from < days.begin) days.begin = from;
    days.end = std::max({days.end, from, is_date(to) ? to : from});
  };
  widen(input.run);
  for (const HeldOut& held_out : input.held_out) widen(held_out.run);
  return days;
}

// States "simulated" and "draft", for readers that do not evaluate the statements.
std::string identifier_of(const PageData& data, const std::string& number) {
  return fmt::format("{}{}{}", is_simulated(data.input) ? "SIMULATED-" : "", data.issue.draft() ? "DRAFT-" : "",
                     number);
}

Markup identification(const char* issuer, const std::string& value, const char* name) {
  return markup("<dcc:identification><dcc:issuer>{}</dcc:issuer><dcc:value>{}</dcc:value>{}</dcc:identification>",
                Text(issuer), stated_text(value), name_of(name));
}

Markup core_data(const PageData& data) {
  const ReportInput& input = data.input;
  const Laboratory& lab = input.laboratory;
  const Performance days = performance_of(input);
  Markup identifications = identification("calibrationLaboratory", data.issue.content_sha256, "SHA-256 of the content");
  if (!order_of(input).empty()) identifications += identification("customer", order_of(input), "order");
  Markup out = markup(
      "<dcc:coreData><dcc:countryCodeISO3166_1>{}</dcc:countryCodeISO3166_1>\n"
      "<dcc:usedLangCodeISO639_1>{}</dcc:usedLangCodeISO639_1><dcc:mandatoryLangCodeISO639_1>{}"
      "</dcc:mandatoryLangCodeISO639_1>\n<dcc:uniqueIdentifier>{}</dcc:uniqueIdentifier>\n"
      "<dcc:identifications>{}</dcc:identifications>\n",
      Text(lab.country), Text(kLanguage), Text(kLanguage), stated_text(identifier_of(data, data.issue.number)),
      identifications);
  if (is_date(lab.received)) out += markup("<dcc:receiptDate>{}</dcc:receiptDate>", Text(lab.received));
  out += markup(
      "<dcc:beginPerformanceDate>{}</dcc:beginPerformanceDate><dcc:endPerformanceDate>{}</dcc:endPerformanceDate>"
      "<dcc:performanceLocation>{}</dcc:performanceLocation>",
      Text(days.begin), Text(days.end), Text(lab.place.empty() ? "laboratory" : "other"));
  if (is_date(data.issue.issued)) out += markup("<dcc:issueDate>{}</dcc:issueDate>", Text(data.issue.issued));
  if (!data.issue.replaces.empty())
    out += markup(
        "<dcc:reportAmendedSubstituted><dcc:typeOfChange>substituted</dcc:typeOfChange><dcc:replacedUniqueIdentifier>{}"
        "</dcc:replacedUniqueIdentifier></dcc:reportAmendedSubstituted>",
        stated_text((is_simulated(input) ? "SIMULATED-" : "") + data.issue.replaces));
  return out += Markup::literal("</dcc:coreData>\n");
}

Markup items(const ReportInput& input) {
  const std::string type = input.sensor ? input.sensor->type : "";
  Markup out = markup("<dcc:items><dcc:item id=\"item1\">{}<dcc:model>{}</dcc:model>{}</dcc:item>\n",
                      name_of(fmt::format("Tactile sensor array of {} and {}", counted(input.fit.rows, "row"),
                                          counted(input.fit.columns, "column"))),
                      stated_text(type), serial_number(input.run.sensor_serial));
  out += markup("<dcc:item id=\"item2\">{}{}</dcc:item></dcc:items>\n", name_of("Scanner electronics of the array"),
                serial_number(scanner_serial_of(input.run, input.sensor)));
  return out;
}

Markup laboratory(const Laboratory& lab) {
  Markup place =
      markup("<dcc:city>{}</dcc:city><dcc:countryCode>{}</dcc:countryCode>", stated_text(lab.city), Text(lab.country));
  if (!lab.postcode.empty()) place += markup("<dcc:postCode>{}</dcc:postCode>", stated_text(lab.postcode));
  if (!lab.address.empty())
    place += markup("<dcc:further><dcc:content>{}</dcc:content></dcc:further>", stated_text(lab.address));
  Markup out = Markup::literal("<dcc:calibrationLaboratory>");
  if (!lab.accreditation.empty())
    out += markup("<dcc:calibrationLaboratoryCode>{}</dcc:calibrationLaboratoryCode>", stated_text(lab.accreditation));
  return out += markup("<dcc:contact>{}<dcc:location>{}</dcc:location></dcc:contact></dcc:calibrationLaboratory>\n",
                       typed_name(lab.laboratory), place);
}

Markup people(const PageData& data) {
  const Laboratory& lab = data.input.laboratory;
  Markup role;
  if (!lab.signer_function.empty()) role = markup("<dcc:role>{}</dcc:role>", stated_text(lab.signer_function));
  return markup(
      "<dcc:respPersons><dcc:respPerson><dcc:person>{}</dcc:person>{}<dcc:mainSigner>true</dcc:mainSigner>"
      "</dcc:respPerson></dcc:respPersons>\n<dcc:customer>{}<dcc:location><dcc:further><dcc:content>{}</dcc:content>"
      "</dcc:further></dcc:location></dcc:customer>\n",
      data.issue.draft() ? name_of("draft: not signed") : typed_name(data.issue.authorised_by), role,
      typed_name(lab.customer), stated_text(lab.customer_address));
}

Markup statement(const char* name, const Markup& more, const char* ref_type = "") {
  const std::string type = *ref_type == '\0' ? "" : fmt::format(" refType=\"{}\"", ref_type);
  Markup attribute;
  attribute.value = type;  // a literal of this program
  return markup("<dcc:statement{}>{}{}</dcc:statement>\n", attribute, name_of(name), more);
}

Markup dcc_statements(const PageData& data) {
  const ReportInput& input = data.input;
  const Issue& issue = data.issue;
  Markup out = Markup::literal("<dcc:statements>\n");
  if (is_simulated(input))
    out += statement("Simulated", declared("Made on simulated devices: not a measurement of a real sensor."),
                     "tb_simulated");
  out += statement("State",
                   declared(issue.draft() ? "Draft: not signed."
                                          : fmt::format("{}, by {} on {}.", signed_title_mark(issue.number),
                                                        issue.authorised_by, issue.authorised_utc)),
                   "tb_state");
  if (!is_certificate(input))
    out += statement(
        "Not a certificate of an accredited laboratory",
        declared(issue.document +
                 ": it lacks an accreditation, data of real devices, or a pressure traceable to a valid certificate."));
  if (!issue.replaces.empty())
    out += statement("Replaces", declared(fmt::format("{}: {}", issue.replaces, doc::stated(issue.reason).text)));
  if (input.run.is_void())
    out += statement("Void", declared(fmt::format("Declared void: {}. It no longer counts.", input.run.void_reason)));
  out += statement("Item",
                   markup("<dcc:norm>ISO/IEC 17025:2017</dcc:norm><dcc:reference>7.8.2.1 l</dcc:reference>{}",
                          declared("The results relate only to the item described, with the scanner named, in the "
                                   "mounting described, at the time of the measurement, under uniform pressure.")));
  for (const Traceability& one : traceability_of(input, PressureUnit::kKilopascal))
    out += statement("Traceability", markup("<dcc:traceable>{}</dcc:traceable>{}",
                                            Text(one.traceable ? "true" : "false"), declared(one.statement)));
  if (const std::string until = valid_until(input.laboratory, input.run.started_utc); is_date(until))
    out += statement("Valid until, as the laboratory states", markup("<dcc:date>{}</dcc:date>", Text(until)));
  out += conformity_statement(input);
  return out += Markup::literal("</dcc:statements>\n");
}

}  // namespace

std::string dcc_lacks(const ReportInput& input) {
  if (!states_uncertainty(input)) return "U of a reading: this is a test report";
  const Laboratory& lab = input.laboratory;
  std::string keys;
  for (const auto& [key, value] : {std::pair("laboratory", &lab.laboratory),
                                   {"country", &lab.country},
                                   {"city", &lab.city},
                                   {"customer", &lab.customer},
                                   {"customer_address", &lab.customer_address}})
    if (doc::stated(*value).text != *value) keys += (keys.empty() ? "" : ", ") + std::string(key);
  if (!keys.empty()) return keys + " of the laboratory file";
  if (input.run.sensor_serial.empty()) return "a serial number of the sensor";
  return performance_of(input).begin.empty() ? "a date of the run" : "";
}

std::string dcc_of(const PageData& data) {
  const ReportInput& input = data.input;
  Markup out = markup(
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<dcc:digitalCalibrationCertificate xmlns:dcc=\"https://ptb.de/dcc\" "
      "xmlns:si=\"https://ptb.de/si\" xmlns:xsi=\"http://www.w3.org/2001/XMLSchema-instance\" "
      "xsi:schemaLocation=\"https://ptb.de/dcc https://ptb.de/dcc/v{}/dcc.xsd\" schemaVersion=\"{}\">\n",
      Text(kSchemaVersion), Text(kSchemaVersion));
  out += markup(
      "<dcc:administrativeData>\n<dcc:dccSoftware>{}</dcc:dccSoftware>\n<dcc:refTypeDefinitions>"
      "<dcc:refTypeDefinition>{}{}<dcc:namespace>tb</dcc:namespace><dcc:link>docs/reports.md</dcc:link>"
      "</dcc:refTypeDefinition></dcc:refTypeDefinitions>\n",
      software(input.program_version), name_of("terms of tactbench"),
      described("tb_taxels: names of the taxels, row,column counted from 0, in the order of every list of values; "
                "tb_simulated: data of simulated devices; tb_state: draft, or signed by whom and when; tb_kind: kind "
                "of history that U is valid for"));
  out += core_data(data);
  out += items(input);
  out += laboratory(input.laboratory);
  out += people(data);
  out += dcc_statements(data);
  out += Markup::literal("</dcc:administrativeData>\n");
  out += measurement_results(data);
  out += Markup::literal("</dcc:digitalCalibrationCertificate>\n");
  return out.value;
}

}  // namespace tactbench::analysis
