// Output of `calibrate` as text and JSON: the verdict with its reason, and the bad taxels.
#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "analysis/pressure_unit.h"
#include "bench/cli/models/fit_models.h"
#include "bench/reporting/judgement.h"

namespace tactbench::bench {

struct Session;

struct CalibrationResult {
  std::string sensor, origin, limits;  // limits: name in their file
  bool registered = false;             // the sensor was new
  std::int64_t run = 0, held_out = 0;  // measured for the models; judged
  JudgedFit fit;                       // its evaluations: the run's own, then the held-out run's
  analysis::Judgement judgement;       // as in the report
  std::string report_number, report_path;
  std::string drift;  // drift_text() of a sensor that was measured before; empty: not known
  analysis::PressureUnit unit = analysis::PressureUnit::kPsi;  // of the page; the document stays in psi
};

struct BadTaxel {
  int row = 0, column = 0;
  std::string why;  // "dead"; "mean |error| 3.40 psi, the largest"
};
// Taxels without a model, in the order of their numbers; then, where the requirement on the worst taxel does not pass,
// that one.
std::vector<BadTaxel> bad_taxels(const JudgedFit& fit, const analysis::Judgement& judgement,
                                 analysis::PressureUnit unit = analysis::PressureUnit::kPsi);

// One line about the fit, without a line end; and the document that ends `calibrate`, below the verdict in block
// letters.
std::string fit_line(const CalibrationResult& result);
analysis::doc::Document verdict_document(const CalibrationResult& result, const Session& session);
nlohmann::ordered_json calibration_json(const CalibrationResult& result);

}  // namespace tactbench::bench
