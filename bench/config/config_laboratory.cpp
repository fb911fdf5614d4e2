// The laboratory file: facts for reports that no instrument knows.
#include "bench/config/config_laboratory.h"

#include "bench/config/config_calibration.h"
#include "db/run_store.h"
#include "sequences/toml/strict_toml.h"

namespace tactbench::bench {

using sequences::TomlDocument;
using sequences::TomlTable;

namespace {

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
  lab.received = read_date(root, "received");
  lab.condition = root.text("condition", "");
  lab.cable = root.text("cable", "");
  lab.mounting = root.text("mounting", "");
  lab.medium = root.text("medium", "");
  lab.environment = root.text("environment", "");
  lab.deviations = root.text("deviations", "");
  lab.remarks = root.text("remarks", "");
  for (const TomlTable& row : root.tables("instrument")) {
    analysis::InstrumentNote note;
    note.serial = row.text("serial");
    if (note.serial.empty()) row.fail("serial", "an instrument without a serial number", "write the serial number");
    note.certificate = row.text("certificate", "");
    note.calibrated_by = row.text("calibrated_by", "");
    note.calibrated_on = read_date(row, "calibrated_on");
    note.due = read_date(row, "due");
    note.note = row.text("note", "");
    row.finish();
    lab.instruments.push_back(note);
  }
  root.finish();
  return lab;
}

}  // namespace

analysis::Laboratory read_laboratory(const std::string& path) { return laboratory_of(TomlDocument::from_file(path)); }
analysis::Laboratory parse_laboratory(const std::string& text, const std::string& name) {
  return laboratory_of(TomlDocument::from_text(text, name));
}

}  // namespace tactbench::bench
