// The laboratory file: what a report says and no instrument knows.
#include <fmt/format.h>

#include "bench/config_laboratory.h"

#include "db/run_store.h"
#include "sequences/strict_toml.h"

namespace tactbench::bench {

using sequences::TomlDocument;
using sequences::TomlTable;

namespace {

// "2026-01-31" or nothing.
std::string date_of(const TomlTable& table, const std::string& key) {
  std::string text = table.text(key, "");
  if (text.empty() || is_iso_date(text)) return text;
  table.fail(key, fmt::format("'{}' is not a date", text), "write it as \"2026-01-31\", or leave it empty");
}

analysis::Laboratory laboratory_of(const TomlDocument& document) {
  const TomlTable root = document.root();
  (void)root.integer("schema", 1, 1);
  analysis::Laboratory lab;
  lab.sha256 = db::sha256_hex(document.text());
  lab.laboratory = root.text("laboratory", "");
  lab.address = root.text("address", "");
  lab.place = root.text("place", "");
  lab.accreditation = root.text("accreditation", "");
  lab.customer = root.text("customer", "");
  lab.customer_address = root.text("customer_address", "");
  lab.order = root.text("order", "");
  lab.received = date_of(root, "received");
  lab.condition = root.text("condition", "");
  lab.cable = root.text("cable", "");
  lab.mounting = root.text("mounting", "");
  lab.environment = root.text("environment", "");
  lab.deviations = root.text("deviations", "");
  lab.remarks = root.text("remarks", "");
  for (const TomlTable& row : root.tables("instrument")) {
    analysis::InstrumentNote note;
    note.serial = row.text("serial");
    if (note.serial.empty()) row.fail("serial", "an instrument without a serial number", "write the serial number");
    note.certificate = row.text("certificate", "");
    note.calibrated_by = row.text("calibrated_by", "");
    note.calibrated_on = date_of(row, "calibrated_on");
    note.due = date_of(row, "due");
    note.note = row.text("note", "");
    row.finish();
    lab.instruments.push_back(note);
  }
  root.finish();
  return lab;
}

}  // namespace

bool is_iso_date(const std::string& text) {
  if (text.size() != 10 || text[4] != '-' || text[7] != '-') return false;
  for (std::size_t i = 0; i < text.size(); ++i)
    if (i != 4 && i != 7 && (text[i] < '0' || text[i] > '9')) return false;
  const int month = std::stoi(text.substr(5, 2)), day = std::stoi(text.substr(8, 2));
  return month >= 1 && month <= 12 && day >= 1 && day <= 31;
}

analysis::Laboratory read_laboratory(const std::string& path) { return laboratory_of(TomlDocument::from_file(path)); }
analysis::Laboratory parse_laboratory(const std::string& text, const std::string& name) {
  return laboratory_of(TomlDocument::from_text(text, name));
}

}  // namespace tactbench::bench
