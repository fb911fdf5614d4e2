// What several pages say about a report's input: whether it is a certificate, simulated, of a table; its title, dates
// and names.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "analysis/report/document/document.h"
#include "analysis/report/report.h"

namespace tactbench::analysis {

const char* direction_text(bool up);              // "increasing", "decreasing" pressure
std::string moment_text(const std::string& utc);  // "2024-05-06 07:08:09Z"
std::string date_of(const std::string& utc);      // "2024-05-06"; "not stated"
std::string model_name(const SensorModel& fit);   // "ELAM" for the paper's model, else the name used in tables

bool is_simulated(const ReportInput& input);
// Whether the document may be called a certificate: an accreditation number and uncertainties are stated, the data are
// not simulated, and the pressure is traceable to a certificate of the reference that was valid.
bool is_certificate(const ReportInput& input);
// Whether U of a reading is valid for some kind of history; else the document is a test report.
bool states_uncertainty(const ReportInput& input);
std::string model_sha256(const SensorModel& fit);  // hash of all parameters and patterns, bit for bit
// Whether the run had a separate pressure reference, not only the regulator's feedback.
bool has_reference(const db::RunRecord& run);
// Date from the laboratory file, stated directly or as months after the measurement; empty: not stated.
std::string valid_until(const Laboratory& lab, const std::string& measured_utc);
// The operator's entry, else the one stored with the run's scanner.
std::string cable_of(const ReportInput& input);
// As typed with the run, else from the laboratory file; both if they differ.
std::string order_of(const ReportInput& input);
// Findings that the signer of a pass must know: taxels left out, noisy, lines swapped. Empty: none.
doc::Phrase findings_summary(const Health& health);

struct Spread {
  double low, median, high;  // NaN when there is no finite value
  std::size_t count = 0;
};
Spread spread_of(std::vector<double> values);

int fitted_taxels(const SensorModel& fit);
// A figure over the observable taxels of a level: NaN if there are none (the evaluation gives 0).
double observable(const LevelFigures& level, double LevelFigures::*figure, int fitted);

}  // namespace tactbench::analysis
