// Frames of an array compensated by any model: ELAM as in the paper and the dynamic model by their frame compensators,
// every other model taxel by taxel with its own inverse.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "analysis/compensate/dynamic_frame_compensator.h"
#include "analysis/compensate/frame_compensator.h"
#include "analysis/identify/streams/recording_stream.h"

namespace tactbench::analysis {

class ArrayStream {
 public:
  using Output = FrameCompensator<float>::Output;
  // Keeps a pointer to `model`. `noisier`: by how much more noise a sample has than those that were fitted. Starts
  // from any state. Throws AnalysisError TB-MODEL-COMPENSATOR when the model is not of a whole array,
  // std::invalid_argument when its numbers make no compensator.
  ArrayStream(const SensorModel& model, double volts_per_count, double noisier, int longest_gap);

  [[nodiscard]] std::size_t taxels() const { return model_->array().size(); }
  // Seconds from the frame before to the next one: lag and creep of a model that has them go on by these. Throws
  // std::invalid_argument when they are negative or not finite.
  void set_interval(double seconds);
  // One frame, as FrameCompensator's; volts as measured.
  void frame(std::span<const float> volts, const Output& output);
  void lost_frame(const Output& output);
  void set_outside_validity(bool outside);

 private:
  void frame_of_streams(std::span<const float> volts, const Output& output);
  std::uint16_t step(std::size_t taxel, float volts, float& pressure, float& uncertainty);

  const SensorModel* model_;
  std::optional<FrameCompensator<float>> elam_;
  std::optional<DynamicFrameCompensator<float>> dynamic_;
  std::vector<std::optional<RecordingStream>> streams_;  // none: the taxel was not fitted
  std::vector<float> last_psi_, last_uncertainty_psi_;
  bool outside_ = false;
  int gap_ = 0, longest_gap_ = 0;  // of streams_: frames lost in a row
};

}  // namespace tactbench::analysis
