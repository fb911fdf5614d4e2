// A model's document (docs: A stored model) as frames of compensated outputs, without the program that wrote it.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "analysis/compensate/frame_compensator.h"
#include "analysis/models/pattern_curve.h"

namespace tactbench::analysis {

// Root mean square of what a model leaves, by 20 equal intervals of the loop's inputs rising, then falling: `scale`
// times mean slope over the branch's own there, at most 4 and at least 0.5. Empty where scale is 0.
std::vector<double> residual_by_level(const PatternCurve& ascending, const PatternCurve& descending, double scale);

struct DocumentFrames {
  std::vector<std::shared_ptr<const HysteresisModel>> models;  // the compensators point to them
  FrameCompensator frames;                                     // from any state
};
// `scans`: averaged into a frame that is given; 0: as many as in those that were fitted. Throws std::invalid_argument
// that says which member is missing or wrong, also when the model is not of a whole array.
DocumentFrames frames_from_document(const std::string& text, int scans);

}  // namespace tactbench::analysis
