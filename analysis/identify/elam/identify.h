// Identification of the five ELAM parameters of a taxel from its branches, exact and deterministic: with measured
// turning points J of Eq. (1) separates into a descending and an ascending half.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "analysis/identify/elam/repeats.h"
#include "analysis/loop.h"
#include "analysis/models/elam.h"

namespace tactbench::analysis {

// One taxel's inner and outer branches on the common grid, for fitting and scoring.
struct TaxelBranch {
  bool ascending = true;
  std::vector<double> pressure_psi;  // from the turning point on
  std::vector<double> volts;
};

struct ElamFit {
  ElamModel model;
  double j_v2 = 0.0;          // Eq. (1), descending + ascending
  double mean_error_v = 0.0;  // Eq. (49)
  double max_error_v = 0.0;
  double full_scale_v = 0.0;  // largest output of the external loop, without sign
  unsigned at_bound = 0;      // bit i: parameter i at a bound; alpha_a1: the split of the longest branch is
};

// Fits alpha_d, beta_d on descending branches and the rest on ascending ones [A18]. Bounds: alpha_d, beta_d, beta_a and
// the relative split alpha_a1 L + alpha_a0 at L = 0 and L = xu - x0 in [0, 1]. Inner branches start at their measured
// turning point [A9], external ones at (x0, y0) or (xu, yu); a branch's first sample is its turning point and is not
// scored. Throws std::invalid_argument on malformed branches or patterns that do not meet.
ElamFit identify_elam(const PatternCurve& ascending, const PatternCurve& descending,
                      std::span<const TaxelBranch> branches, const ElamOptions& options = {});

enum class TaxelStatus { kFitted, kDead, kStuck, kSaturated, kUnfit };
const char* to_string(TaxelStatus status);

struct TaxelFit {
  TaxelStatus status = TaxelStatus::kUnfit;
  ElamFit fit;
  double noise_v = 0.0;  // carried from the dataset: the compensator's dead band follows it
};

struct ArrayFit {
  int rows = 0, columns = 0;
  std::int64_t run = 0;
  std::string origin, sensor_serial, scanner_serial;  // a model is bound to these
  std::vector<double> pressure_psi;                   // common grid
  std::vector<TaxelFit> taxels;                       // rows x columns
  TaxelFit mean_taxel;                                // of the mean of the fitted taxels
  double full_scale_v = 0.0;                          // largest mean output
  // The sensor's output falls when the pressure rises: all models are those of the negated output [A20].
  bool falling = false;
  std::vector<RepeatDrift> repeats;  // of the mean of the fitted taxels; not stored
};

struct ArrayFitOptions {
  ElamOptions elam;
  CommonOptions common;
  int threads = 0;            // 0: as many as there are cores
  double dead_v = 0.05;       // a taxel whose output spans less is dead (0 V) or stuck
  double unfit_share = 0.10;  // a taxel whose mean error exceeds this share of its full scale is unfit
};

// The dataset as the models of `fit` see it: outputs negated where they are those of a falling sensor.
Dataset as_modelled(Dataset dataset, const ArrayFit& fit);

// All taxels; threads by taxel, the result does not depend on their number. Throws AnalysisError.
ArrayFit fit_array(const Dataset& dataset, const ArrayFitOptions& options = {});

// To and from the store. load_fit: TB-ANALYSIS-NO-FIT when the run has none. made_by: build and class of processor,
// kept for who recomputes the fit (fit_rows.h).
std::int64_t store_fit(db::RunStore& store, const ArrayFit& fit, const std::string& program_version,
                       const std::string& utc, const std::string& made_by = {});
ArrayFit load_fit(const db::RunStore& store, std::int64_t run);
ArrayFit load_fit(const db::RunStore& store, const db::FitRecord& record);  // of the model kElamFit
inline constexpr const char* kElamFit = "elam";

}  // namespace tactbench::analysis
