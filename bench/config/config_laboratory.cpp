// The laboratory file: facts for reports that no instrument knows.
#include "bench/config/config_laboratory.h"

#include <fmt/format.h>

#include <algorithm>

#include "bench/config/config_calibration.h"
#include "db/run_store.h"
#include "sequences/toml/key_table.h"

namespace tactbench::bench {

using sequences::KeyTable;
using sequences::TomlDocument;
using sequences::TomlTable;
namespace key = sequences::key;

namespace {

KeyTable laboratory_rows(analysis::Laboratory& lab) {
  return {
      key::schema(),
      key::text("laboratory", lab.laboratory, "Name of the laboratory"),
      key::text("address", lab.address, "Address of the laboratory"),
      key::text("city", lab.city, "City of the laboratory; a digital calibration certificate needs it"),
      key::text("postcode", lab.postcode, "Its postcode"),
      key::text("country", lab.country,
                "Country of the laboratory, two capital letters by ISO 3166-1: \"DE\"; a digital calibration "
                "certificate needs it"),
      key::text("signer_function", lab.signer_function, "Function of the signer: \"technical manager\""),
      key::text("place", lab.place, "Where the calibration was made, if elsewhere"),
      key::text(
          "accreditation", lab.accreditation,
          "Number of the accreditation; without it, or on simulated data, a report is never called a certificate"),
      key::text("customer", lab.customer, "Name of the customer"),
      key::text("customer_address", lab.customer_address, "Address of the customer"),
      key::text("order", lab.order, "Number of the order, the customer's or your own; --order of a run has precedence"),
      date_key("received", lab.received, "Date on which the sensor was received"),
      key::text("condition", lab.condition,
                "Condition of the sensor at receipt: \"new\", \"scratched at the edge of row 0\""),
      key::text("cable", lab.cable, "Cable between sensor and scanner: type, length, serial number"),
      key::text("mounting", lab.mounting,
                "What lies on the sensor and below it: \"cotton fabric 0.4 mm on a steel plate\""),
      key::text("medium", lab.medium, "Pressure medium and its state: \"dry compressed air, dew point -40 °C\""),
      key::text("environment", lab.environment,
                "Temperature and humidity, if no instrument of the bench measured them"),
      key::text("deviations", lab.deviations, "Deviations from the method, in addition to those recorded by the run"),
      key::text("remarks", lab.remarks, "Remarks of the laboratory, printed on the report"),
      date_key("valid_until", lab.valid_until, "Last day on which the calibration is valid, by the laboratory's rule"),
      key::number("recalibrate_after_months", lab.recalibrate_after_months, {"months"}, {0.0, 1200.0},
                  "Validity in months after the measurement; 0: not stated")};
}

KeyTable instrument_rows(analysis::InstrumentNote& note) {
  return {
      key::required(key::text("serial", note.serial, "Serial number of the instrument to which the other keys apply")),
      key::text("certificate", note.certificate, "Number of its calibration certificate"),
      key::text("calibrated_by", note.calibrated_by, "Who calibrated it"),
      date_key("calibrated_on", note.calibrated_on, "Date of the calibration"),
      date_key("due", note.due, "Last day on which the calibration is valid; of two due dates the earlier one counts"),
      key::text("note", note.note, "Remark on it")};
}

analysis::Laboratory laboratory_of(const TomlDocument& document) {
  const TomlTable root = document.root();
  analysis::Laboratory lab;
  lab.sha256 = db::sha256_hex(document.text());
  read_keys(root, laboratory_rows(lab));
  const auto capital = [](char c) { return c >= 'A' && c <= 'Z'; };
  if (!lab.country.empty() && (lab.country.size() != 2 || !std::ranges::all_of(lab.country, capital)))
    root.fail("country", fmt::format("'{}' is not a country code", lab.country),
              "write two capital letters by ISO 3166-1, as \"DE\", or leave it empty");
  for (const TomlTable& row : root.tables("instrument")) {
    analysis::InstrumentNote& note = lab.instruments.emplace_back();
    read_keys(row, instrument_rows(note));
    if (note.serial.empty()) row.fail("serial", "an instrument without a serial number", "write the serial number");
    row.finish();
  }
  root.finish();
  return lab;
}

}  // namespace

analysis::Laboratory read_laboratory(const std::string& path) { return laboratory_of(TomlDocument::from_file(path)); }
analysis::Laboratory parse_laboratory(const std::string& text, const std::string& name) {
  return laboratory_of(TomlDocument::from_text(text, name));
}

std::vector<sequences::KeyFacts> laboratory_keys() {
  analysis::Laboratory lab;
  analysis::InstrumentNote note;
  std::vector<sequences::KeyFacts> all;
  add_facts(all, "", laboratory_rows(lab));
  add_facts(all, "instrument[]", instrument_rows(note));
  return all;
}

}  // namespace tactbench::bench
