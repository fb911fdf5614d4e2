// Checks how well a stored model describes later data: the change of each taxel's zero and gain since the fit, and
// whether adjusting them is enough.
#pragma once

#include "analysis/identify/stored/model_document.h"

namespace tactbench::analysis {

// Measured outputs are taken as zero + gain x the model's along the same inputs (least squares). Shares of full scale
// are of the taxel's fit. Uncertainties are standard ones, from the residuals taken as independent.
struct TaxelDrift {
  int taxel = 0;
  double zero = 0.0, zero_alone = 0.0, zero_u = 0.0;  // output's unit; zero_alone: with the gain left as it was
  double gain = 1.0, gain_u = 0.0;
  double as_is = 0.0, zeroed = 0.0,
         adjusted = 0.0;  // mean |residual| of the model as it is, with zero, with both; of FS
};

// kZero: what is left by a new zero alone is within the tolerance, and it is not the gain that moved.
enum class DriftVerdict { kGood, kZero, kGain, kRecalibrate };
const char* to_string(DriftVerdict verdict);  // good | re-zero enough | gain adjustment enough | recalibrate

struct Drift {
  std::vector<TaxelDrift> taxels;
  double as_is = 0.0, zeroed = 0.0, adjusted = 0.0;  // means over the taxels
  double tolerance = 0.0;                            // share of full scale
  // Mean change of the taxels' zeros (share of full scale) and gains (of 1) since the fit, and U (k = 2): the taxels'
  // own uncertainties taken as one common error, the scatter of their changes, and what both leave: `adjusted`, a
  // change of the pattern in addition to the model's error. gain_u 0: the inputs do not determine a gain.
  double zero = 0.0, zero_u = 0.0, gain = 0.0, gain_u = 0.0;
  DriftVerdict verdict = DriftVerdict::kGood;
  [[nodiscard]] bool drifted() const { return verdict != DriftVerdict::kGood; }
  [[nodiscard]] bool zero_moved() const;  // in the mean, by more than its U
  [[nodiscard]] bool gain_moved() const;
};
// "good"; else what moved and what that takes: "the gain moved: gain adjustment enough".
std::string display_text(const Drift& drift);

// tolerance 0: twice the mean error of the model's own fit, at least 0.5 % of full scale. A gain is fitted where the
// inputs cover at least a tenth of the model's range. Throws AnalysisError as score_model does.
Drift drift_of(const SensorModel& document, const Histories& histories, double tolerance = 0.0);

// The child: `document` with zero (and gain) of each taxel adjusted by `drift`. Names its parent and the data.
SensorModel adjusted(SensorModel document, const Drift& drift, const Histories& by, bool gain);

}  // namespace tactbench::analysis
