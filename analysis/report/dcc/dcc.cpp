// The administrative part of a DCC.
#include "analysis/report/dcc/dcc.h"

#include <algorithm>
#include <vector>

#include "analysis/counted.h"
#include "analysis/report/data/conformity.h"
#include "analysis/report/data/traceability.h"
#include "analysis/report/report_facts.h"

namespace tactbench::analysis {

namespace {

using namespace dcc;

// The schema's release; the patterns that 3.3.0 requires are in xml.cpp.
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
  out += dcc::conformity_statement(input);
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
  out += dcc::measurement_results(data);
  out += Markup::literal("</dcc:digitalCalibrationCertificate>\n");
  return out.value;
}

}  // namespace tactbench::analysis
