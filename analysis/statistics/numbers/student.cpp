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

}  // namespace tactbench::analysis
