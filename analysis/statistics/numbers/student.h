// Quantiles of Student's t distribution, for prediction intervals and coverage factors (JCGM 100 annex G.3).
#pragma once

namespace tactbench::analysis {

// t with P(T <= t) = probability, 0 < probability < 1; degrees of freedom > 0, infinite ones are the normal
// distribution's. NaN otherwise.
double student_quantile(double probability, double degrees_of_freedom);
// P(|T| >= |t|), degrees of freedom > 0. NaN otherwise.
double student_two_sided(double t, double degrees_of_freedom);

}  // namespace tactbench::analysis
