#include "analysis/statistics/numbers/student.h"

#include <boost/math/distributions/normal.hpp>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>
#include <limits>

namespace tactbench::analysis {

double student_quantile(double probability, double degrees_of_freedom) {
  if (!(probability > 0.0 && probability < 1.0 && degrees_of_freedom > 0.0))
    return std::numeric_limits<double>::quiet_NaN();
  if (std::isinf(degrees_of_freedom)) return boost::math::quantile(boost::math::normal(), probability);
  return boost::math::quantile(boost::math::students_t(degrees_of_freedom), probability);
}

double student_two_sided(double t, double degrees_of_freedom) {
  if (std::isnan(t) || !(degrees_of_freedom > 0.0)) return std::numeric_limits<double>::quiet_NaN();
  if (std::isinf(t)) return 0.0;
  if (std::isinf(degrees_of_freedom))
    return 2.0 * boost::math::cdf(boost::math::complement(boost::math::normal(), std::abs(t)));
  return 2.0 * boost::math::cdf(boost::math::complement(boost::math::students_t(degrees_of_freedom), std::abs(t)));
}

}  // namespace tactbench::analysis
