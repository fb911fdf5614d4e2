// Vectors, bounds and normal equations of GPI's unknowns, for its local searches.
#pragma once

#include <Eigen/Core>

#include "analysis/identify/rivals/gpi_lanes.h"

namespace tactbench::analysis {

using GpiVector = Eigen::Matrix<double, kGpiUnknowns, 1>;
using GpiMatrix = Eigen::Matrix<double, kGpiUnknowns, kGpiUnknowns>;

// The unknowns stay where exponentials are harmless.
GpiPoint gpi_within(const GpiVector& to);

inline GpiVector vector_of(const GpiPoint& p) { return Eigen::Map<const GpiVector>(p.data()); }

// The normal equations in one lane: Gauss-Newton's matrix and half of J's gradient.
struct GpiNormal {
  GpiMatrix matrix;
  GpiVector slope;
  GpiNormal() = default;
  GpiNormal(const GpiLanes& lanes, std::size_t lane);
};

}  // namespace tactbench::analysis
