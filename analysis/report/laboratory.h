// The fields of a laboratory file: facts about a calibration that no instrument can supply. Empty fields print as "not
// stated".
#pragma once

#include <string>
#include <vector>

#include "analysis/statistics/uncertainty/instruments.h"

namespace tactbench::analysis {

struct Laboratory {
  std::string laboratory, address, place;
  std::string city, postcode, country;  // of the laboratory; country: ISO 3166-1, two capital letters
  std::string signer_function;          // function of the signer: "technical manager"
  std::string accreditation;            // accreditation number; without it no document is called a certificate
  std::string customer, customer_address, order;
  std::string received;         // date on which the sensor was received
  std::string condition;        // condition of the sensor at receipt
  std::string cable, mounting;  // cable between sensor and scanner; what lies on the sensor, how it is mounted
  std::string medium;           // pressure medium
  std::string environment;      // temperature and humidity, if no instrument measured them
  std::string deviations;       // deviations from the method, in addition to those recorded in the run
  std::string remarks;
  std::string valid_until;                  // date until which the calibration is valid; empty: see below
  int recalibrate_after_months = 0;         // validity in months after the measurement; 0: no rule
  std::vector<InstrumentNote> instruments;  // notes in addition to the run's stored data: instruments.h
  std::string sha256;                       // hash of the file; empty: there was none
};

}  // namespace tactbench::analysis
