// Makes a FrameCompensator from a stored model document (docs: A stored model), without the program that wrote it.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "analysis/compensate/frame_compensator.h"
#include "analysis/models/pattern_curve.h"

namespace tactbench::analysis {

// Root mean square residual of a model in 20 equal intervals of the loop's inputs, rising, then falling: `scale` times
// the mean slope over the branch's own there, at most 4 and at least 0.5. Empty where scale is 0.
std::vector<double> residual_by_level(const PatternCurve& ascending, const PatternCurve& descending, double scale);

struct DocumentFrames {
  std::vector<std::shared_ptr<const HysteresisModel>> models;  // the compensators point to them
  FrameCompensator frames;                                     // from any state
};
// `scans`: number averaged into each frame that is passed in; 0: as many as in the fitted frames. Throws
// std::invalid_argument that names the missing or wrong member, also when the model is not of a whole array.
DocumentFrames frames_from_document(const std::string& text, int scans);

}  // namespace tactbench::analysis
