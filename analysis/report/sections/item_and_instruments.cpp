// Page 2: the item, the chain from the SI to it, instruments, conditions, laboratory and customer.
#include <algorithm>

#include "analysis/counted.h"
#include "analysis/report/data/traceability.h"
#include "analysis/report/document/document.h"
#include "analysis/report/page/chart.h"
#include "analysis/report/report_facts.h"
#include "analysis/report/sections/sections.h"

namespace tactbench::analysis {

namespace {

using doc::Document;
using doc::Phrase;

doc::Table chain(const PageData& data) {
  const ReportInput& input = data.input;
  const ReferenceUncertainty reference = reference_uncertainty(input.run, input.laboratory.instruments);
  const InstrumentCalibration& standard = reference.calibration;
  doc::Table table{.id = "chain",
                   .caption = "Traceability",
                   .columns = {{"SI"},
                               {"→ calibration laboratory"},
                               {"→ pressure standard"},
                               {"→ this calibration"},
                               {"→ this sensor"}},
                   .dense = true};
  const double u = 2.0 * reference.largest_certificate_u();
  table.rows.push_back(
      {{"pascal, by a national institute",
        Phrase(doc::stated(standard.calibrated_by),
               doc::quiet("\ncertificate " + doc::stated(standard.certificate).text)),
        has_reference(input.run)
            ? Phrase(doc::stated(standard.serial), "\n",
                     u > 0.0 ? Phrase("U = ", doc::pressure_rounded_to_u(u, u), " ", input.unit.symbol(), " (k = 2)")
                             : Phrase("U not stated"))
            : Phrase("none: the regulator’s feedback was used"),
        Phrase("No. " + data.issue.number, doc::quiet("\n" + date_of(input.run.started_utc))),
        Phrase(doc::strong(doc::stated(input.run.sensor_serial).text),
               doc::quiet(states_uncertainty(input) ? "\nU of a reading: page 1" : "\nU of a reading not stated"))}});
  return table;
}

doc::Table instruments(const ReportInput& input) {
  doc::Table table{.id = "instruments",
                   .caption = "Instruments",
                   .columns = {{"instrument"},
                               {"serial, firmware"},
                               {"certificate"},
                               {"laboratory"},
                               {"date"},
                               {"due"},
                               {"U"},
                               {"it covers"}},
                   .dense = true};
  for (const db::DeviceRecord& device : input.run.devices) {
    const InstrumentCalibration fields = calibration_of(device, input.laboratory.instruments);
    const auto or_dash = [](const std::string& text) { return Phrase(text.empty() ? "–" : text); };
    Phrase due = or_dash(fields.due);
    if (due_state(fields, input.run.started_utc) == DueState::kOverdue)
      due = {doc::StyledText{"✗ overdue since " + fields.due, doc::TextStyle::kBad}};
    Phrase name(fields.role, doc::quiet("\n" + doc::stated(fields.model).text));
    for (const std::string& more : fields.remarks) name.add(doc::StyledText{"\n▲ " + more, doc::TextStyle::kDoubt});
    if (!fields.note.empty()) name.add(doc::quiet("\n" + fields.note));
    const bool certified = fields.traceable();
    table.rows.push_back({{name, or_dash(fields.serial).add(device.firmware.empty() ? "" : "\n" + device.firmware),
                           or_dash(fields.certificate), or_dash(fields.calibrated_by), or_dash(fields.calibrated_on),
                           due, fields.stated_u ? Phrase(display_text(*fields.stated_u, input.unit)) : Phrase("–"),
                           Phrase(certified ? display_text(covers_of(device)) : "–")}});
  }
  if (input.run.devices.empty()) table.rows.push_back({{"not stated"}});
  return table;
}

doc::Drawing counting(const Health& health) {
  TaxelMap map{.title = "Numbering of the taxels: row 0, column 0 is at the upper left",
               .rows = health.rows,
               .columns = health.columns,
               .size = 96.0};
  map.values.assign(static_cast<std::size_t>(health.rows * health.columns), 0.15);
  if (!map.values.empty()) map.values.front() = 1.0;
  for (const TaxelHealth& finding : health.findings)
    if (finding.excluded) map.values[static_cast<std::size_t>(finding.taxel)] = kNan;
  return {taxel_map_svg(map),
          map.title,
          {"A taxel is named row, column, both from 0; blue: 0, 0. A cross: left out of all figures."}};
}

std::string surroundings_of(const ReportInput& input) {
  std::string text;
  for (const EnvironmentRange& range : input.history.surroundings) {
    const bool celsius = range.quantity == "temperature_c";
    text += fmt::format("{}{} to {} {} ({})", text.empty() ? "" : "; ", doc::fixed_text(range.low, 1),
                        doc::fixed_text(range.high, 1),
                        celsius                          ? "°C"
                        : range.quantity == "supply_bar" ? "bar air supply"
                                                         : range.quantity,
                        counted(range.readings, "reading"));
  }
  if (input.laboratory.environment.empty()) return text;
  return text.empty() ? input.laboratory.environment : text + "; " + input.laboratory.environment;
}

// Rows of the stated facts; the names of the missing ones are one row.
class StatedRows {
 public:
  void add(const std::string& name, const std::string& value) {
    if (value.find_first_not_of(" \t\r\n") == std::string::npos)
      missing_ += (missing_.empty() ? "" : "; ") + name;
    else
      rows_.emplace_back(name, value);
  }
  [[nodiscard]] doc::Table table(const std::string& caption) {
    if (!missing_.empty()) rows_.emplace_back("not stated", doc::quiet(missing_));
    return doc::pairs(caption, std::move(rows_));
  }

 private:
  std::vector<std::pair<std::string, Phrase>> rows_;
  std::string missing_;
};

doc::Paragraph statements(const PageData& data) {
  const ReportInput& input = data.input;
  Phrase text(doc::strong("Statements. "));
  if (states_uncertainty(input))
    text.add(
        "The expanded uncertainty is the standard uncertainty times a coverage factor k from the effective degrees "
        "of freedom, for a coverage probability of approximately 95 % (JCGM 100). ");
  text.add(
      "The results relate only to the item described, with the scanner named, in the mounting described, at the time "
      "of the measurement. ");
  if (!input.history.presses)
    text.add(
        "The pressure was uniform over the array: for objects, or another interface material, this report does not "
        "state the errors. ");
  if (!has_reference(input.run) && !input.history.presses)
    text.add("An error of the regulator’s feedback is contained in the models and cannot be seen in any error here. ");
  const std::string until = valid_until(input.laboratory, input.run.started_utc);
  text.add(until.empty() ? "No interval of recalibration is stated. "
                         : "Valid until " + until + ", as the laboratory states. ");
  text.add("This report may be reproduced only in full.");
  return {text, doc::Paragraph::kNote};
}

}  // namespace

Document item_and_instruments(const PageData& data) {
  const ReportInput& input = data.input;
  const db::RunRecord& run = input.run;
  const Laboratory& lab = input.laboratory;
  const std::string scanner = scanner_serial_of(run, input.sensor), surroundings = surroundings_of(input);
  Document out, item, conditions;
  out.add(doc::Heading{
      2, states_uncertainty(input) ? "What was calibrated, against what" : "What was measured, against what",
      "against-what"});
  out.add(chain(data));
  out.add(instruments(input));
  StatedRows of_item, of_conditions, of_laboratory;
  of_item.add("sensor, serial number", run.sensor_serial);
  of_item.add("type", input.sensor ? input.sensor->type : "");
  of_item.add("array",
              fmt::format("{} × {}", counted(input.health.rows, "row"), counted(input.health.columns, "column")));
  of_item.add("scanner", scanner);
  of_item.add("cable", cable_of(input));
  of_item.add("received", lab.received);
  of_item.add("condition", lab.condition);
  of_item.add("mounting, interface material", lab.mounting);
  of_item.add("note", input.sensor ? input.sensor->note : "");
  of_conditions.add("surroundings", surroundings);
  of_conditions.add("medium", lab.medium);
  of_conditions.add("pressure", "gauge: the excess over the surrounding air");
  of_conditions.add("place", lab.place);
  of_conditions.add("performed", moment_text(run.started_utc) + " to\n" + moment_text(run.ended_utc));
  of_conditions.add("operator", run.operator_name);
  of_conditions.add("purpose", run.purpose);
  of_conditions.add("bench", run.bench_id);
  of_laboratory.add("name", lab.laboratory);
  of_laboratory.add("address", lab.address);
  of_laboratory.add("accreditation",
                    is_certificate(input) ? "No. " + lab.accreditation : "none: this is not a certificate");
  of_laboratory.add("remarks", lab.remarks);
  of_laboratory.add("customer", lab.customer);
  of_laboratory.add("its address", lab.customer_address);
  of_laboratory.add("order", order_of(input));
  item.add(of_item.table("Item"));
  item.add(counting(input.health));
  conditions.add(of_conditions.table("Conditions"));
  conditions.add(of_laboratory.table("Laboratory and customer"));
  out.add(doc::SideBySide{{item, conditions}, {1, 1}});
  out.add(statements(data));
  return out;
}

}  // namespace tactbench::analysis
