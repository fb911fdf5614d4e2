// Makes a FrameCompensator from a stored model document (docs: A stored model), without the program that wrote it.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "analysis/compensate/compensator.h"
#include "analysis/models/pattern_curve.h"

namespace tactbench::analysis {

// Root mean square residual of a model in 20 equal intervals of the loop's inputs, rising, then falling: `scale` times
// the ratio of the mean slope to the branch's slope in the interval, limited to 0.5 to 4. Empty if scale is 0.
std::vector<double> residual_by_level(const PatternCurve& ascending, const PatternCurve& descending, double scale);

struct DocumentFrames {
  std::vector<std::shared_ptr<const HysteresisModel>> models;  // the compensators point to them
  FrameCompensator frames;                                     // starts from an unknown state
};
// `scans`: number of scans averaged in each frame passed in; 0: as in the fitted frames. Throws
// std::invalid_argument that names the missing or wrong member, also if the model is not of a whole array.
DocumentFrames frames_from_document(const std::string& text, int scans);

}  // namespace tactbench::analysis
