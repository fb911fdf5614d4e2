// The samples that J of Eq. (1) sums over, merged once: samples on the same target curve at the same pressure have the
// same model value, so a search needs only their weighted mean and a constant.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "analysis/identify/elam/identify.h"
#include "analysis/models/elam.h"

namespace tactbench::analysis {

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

// The minimum of J's descending half over alpha_d, beta_d in [0, 1] and of its ascending half over the unit cube in
// (phi(x = 0 long), phi(full length), beta_a); the model's other parameters are left alone. Return J without constant.
double fit_descending(ElamModel& model, std::span<const CurveSamples> curves);
double fit_ascending(ElamModel& model, std::span<const CurveSamples> curves);

// Adds the sizes of the pieces for `splits` split points a branch to a model that was fitted with one, and moves its
// parameters with them: J over `samples` is at most what it was, except for rounding. Deterministic.
ElamPieces fit_pieces(ElamModel& model, const ElamSamples& samples, int splits);

}  // namespace tactbench::analysis
