// Facts about a report's input that several of its pages state.
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
std::string model_name(const SensorModel& fit);   // "ELAM" for the paper's, else as tables name it

bool is_simulated(const ReportInput& input);
// The word "certificate" is allowed: an accreditation number and uncertainties are stated, the data are real, the
// pressure is traceable to a certificate of its reference that was in date.
bool is_certificate(const ReportInput& input);
// U of a reading is valid for some kind of history; else a document is a test report.
bool states_uncertainty(const ReportInput& input);
std::string model_sha256(const SensorModel& fit);  // of all parameters and patterns, bit for bit
// A pressure reference that is a device of its own, not the regulator's feedback.
bool has_reference(const db::RunRecord& run);
// By the laboratory file: a date, or so many months after the measurement; empty: not stated.
std::string valid_until(const Laboratory& lab, const std::string& measured_utc);
// The operator's entry, else as the run stored it with the scanner.
std::string cable_of(const ReportInput& input);
// As typed with the run, else by the laboratory file; both where they differ.
std::string order_of(const ReportInput& input);
// Findings that the signer of a pass must know: taxels left out, noisy, lines swapped. Empty: none.
doc::Phrase findings_summary(const Health& health);

struct Spread {
  double low, median, high;  // NaN when there is no finite value
  std::size_t count = 0;
};
Spread spread_of(std::vector<double> values);

int fitted_taxels(const SensorModel& fit);
// A figure over the observable taxels of a level: NaN where none is left, which the evaluation gives as 0.
double observable(const LevelFigures& level, double LevelFigures::*figure, int fitted);

}  // namespace tactbench::analysis
