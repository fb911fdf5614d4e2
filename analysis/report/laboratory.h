// What no instrument can know of a calibration and somebody has to type: the fields of a laboratory file. Empty fields
// print as "not stated".
#pragma once

#include <string>
#include <vector>

namespace tactbench::analysis {

// Joins the run's instrument with this serial number; what is stated here stands before what the run stored.
struct InstrumentNote {
  std::string serial, certificate, calibrated_by, calibrated_on, due, note;  // dates as 2026-01-31
};

struct Laboratory {
  std::string laboratory, address, place;
  std::string accreditation;  // its number; without one no document is called a certificate
  std::string customer, customer_address, order;
  std::string received;         // date on which the sensor came
  std::string condition;        // of the sensor when it came
  std::string cable, mounting;  // cable between sensor and scanner; what lies on the sensor, how it is mounted
  std::string environment;      // temperature, humidity, where no instrument measured them
  std::string deviations;       // from the method, beside those that the run recorded
  std::string remarks;
  std::vector<InstrumentNote> instruments;
  std::string sha256;  // of the file; empty: there was none
};

}  // namespace tactbench::analysis
