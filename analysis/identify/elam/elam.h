// Identification of the five ELAM parameters of a taxel from its branches, exact and deterministic: with measured
// turning points J of Eq. (1) separates into a descending and an ascending half. The samples that it sums over, merged
// once; the search of each half is in search.h; which parameters the samples determine; further split points.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <string>
#include <vector>

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
  unsigned undetermined = 0;  // bit i, likewise: the data leave it open (elam.h); not stored
};

// Fits alpha_d, beta_d on descending branches and the rest on ascending ones [A18]. Bounds: alpha_d, beta_d, beta_a and
// the relative split alpha_a1 L + alpha_a0 at L = 0 and L = xu - x0 in [0, 1]. Inner branches start at their measured
// turning point [A9], external ones at (x0, y0) or (xu, yu); a branch's first sample is its turning point and is not
// scored. `settle`: what the data leave open is taken near the pattern (elam.h). Throws
// std::invalid_argument on malformed branches or patterns that do not meet.
ElamFit identify_elam(const PatternCurve& ascending, const PatternCurve& descending,
                      std::span<const TaxelBranch> branches, const ElamOptions& options = {}, bool settle = true);

unsigned bounds_met(const ElamModel& model);  // ElamFit::at_bound of it

// Of the parameters that `fit` says the data leave open.
std::vector<std::string> undetermined_names(const ElamFit& fit);

// One target curve and the distinct samples on it.
struct CurveSamples {
  double x_turn = 0.0, y_turn = 0.0;
  std::vector<double> x, y, weight;  // x: ascending; y: mean of the samples at x; weight: their number
};

struct ElamSamples {
  std::vector<CurveSamples> ascending, descending;
  double ascending_constant = 0.0, descending_constant = 0.0;  // J that no parameter can remove
};

// The turning point of a branch for fitting [A9]: measured, but (x0, y0) and (xu, yu) for external branches.
struct TurningPoint {
  double x = 0.0, y = 0.0;
};
TurningPoint turning_point(const ElamModel& model, const TaxelBranch& branch);

// Each branch gives all its samples but the first, which is the turning point (and the last of the branch before).
ElamSamples collect_samples(const ElamModel& model, std::span<const TaxelBranch> branches);
// Leaves about `most` of the samples, evenly chosen, when there are more.
void thin(std::vector<CurveSamples>& curves, std::size_t most);
// A search looks at no more distinct samples than this in each direction; errors are over all samples.
inline constexpr std::size_t kSearchedSamples = 10000;
// Those that a search looks at. Throws as identify_elam does.
ElamSamples searched_samples(const ElamModel& model, std::span<const TaxelBranch> branches);
// The fit that `model` is, whoever found its parameters.
ElamFit scored(const ElamModel& model, std::span<const TaxelBranch> branches);

// One direction's parameters in a row, each in [0, 1]: alpha_d, beta_d; or phi(0), phi(length), beta_a, where `length`
// is that of the longest branch, psi.
std::array<double, 3> direction_of(const ElamParameters& parameters, bool ascending, double length);  // 2 or 3 of them
void set_direction(ElamParameters& parameters, bool ascending, double length, const double* at);

// Adds the sizes of the pieces for `splits` split points a branch to a model that was fitted with one, and moves its
// parameters with them: J over `samples` is at most what it was, but for rounding. Deterministic.
ElamPieces fit_pieces(ElamModel& model, const ElamSamples& samples, int splits);

// Looks at one direction of a model that was fitted to `curves`; `constant` as in ElamSamples. A parameter is left open
// when its standard error, from the residuals and Gauss-Newton's Hessian, is above that of a value drawn anywhere
// between its bounds (1 / sqrt 12), or when J changes by less than a sample's variance as the split runs so far along
// the pattern either way. Returns the open ones, bits as ElamFit::at_bound, and moves the model:
// - to the pattern's own split at the middle of the input range, where its J is above the best by chance alone (95 %)
//   and a parameter is open there: so with external branches alone, whose J is the same along the whole pattern;
// - else along the open directions as near to it as J stays the same within 1e-7.
// A model without open parameters stays as it is.
unsigned settle_undetermined(ElamModel& model, std::span<const CurveSamples> curves, double constant, bool ascending);

}  // namespace tactbench::analysis
