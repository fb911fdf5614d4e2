// The fields of a laboratory file: facts of a calibration that no instrument knows. Empty fields print as "not stated".
#pragma once

#include <string>
#include <vector>

#include "analysis/statistics/uncertainty/instrument_calibration.h"

namespace tactbench::analysis {

struct Laboratory {
  std::string laboratory, address, place;
  std::string city, postcode, country;  // of the laboratory; country: ISO 3166-1, two capital letters
  std::string signer_function;          // of who signs: "technical manager"
  std::string accreditation;            // its number; without one no document is called a certificate
  std::string customer, customer_address, order;
  std::string received;         // date on which the sensor came
  std::string condition;        // of the sensor when it came
  std::string cable, mounting;  // cable between sensor and scanner; what lies on the sensor, how it is mounted
  std::string medium;           // that the pressure is made with
  std::string environment;      // temperature, humidity, where no instrument measured them
  std::string deviations;       // from the method, beside those that the run recorded
  std::string remarks;
  std::string valid_until;                  // date until which the calibration counts; empty: see below
  int recalibrate_after_months = 0;         // after the measurement; 0: no rule
  std::vector<InstrumentNote> instruments;  // instrument_calibration.h says what counts beside what the run stored
  std::string sha256;                       // of the file; empty: there was none
};

}  // namespace tactbench::analysis
