// Frames of the run that the page displays: the most recent image, also as pressures if the sensor has models.
#pragma once

#include <cstdint>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "analysis/identify/sensor_model.h"
#include "bench/monitor/heat_map.h"
#include "db/run_reader.h"

namespace tactbench::bench {

// Compensates the frames of this run by the models of the same sensor from its newest earlier run that has models.
class CompensatedRun {
 public:
  // None: no earlier run of the sensor has models that can compensate frames. Throws StoreError.
  static std::unique_ptr<CompensatedRun> of(const db::RunStore& store, const db::RunRecord& run);
  void see(const db::StoredFrame& frame, const std::vector<double>& volts);
  [[nodiscard]] const std::vector<float>& pressure_psi() const { return pressure_; }
  [[nodiscard]] const std::vector<std::uint16_t>& status() const { return status_; }  // TaxelBits
  [[nodiscard]] const std::string& model_text() const { return words_; }              // "elam of run 3"

 private:
  CompensatedRun(analysis::SensorModel model, std::string words);
  std::unique_ptr<analysis::SensorModel> model_;  // the stream keeps a pointer to it
  std::optional<analysis::FrameCompensator> stream_;
  std::string words_;
  std::vector<float> volts_, pressure_, uncertainty_;
  std::vector<std::uint16_t> status_;
  std::optional<std::int64_t> last_ns_;
};

class RunFrames {
 public:
  // Throws StoreError.
  RunFrames(const db::RunStore& store, const db::RunRecord& run);
  // True: there is a newer picture than at the last call. Reads a bounded number of frames per call.
  bool advance();
  [[nodiscard]] std::int64_t position() const { return position_; }
  // The picture for the page, the newest or the one at the highest load: `volts` row-major, and `psi` if there are
  // models. Null before the first frame and the seating check.
  [[nodiscard]] nlohmann::json picture(bool at_peak = false) const;

 private:
  const db::RunStore& store_;
  db::RunRecord run_;
  db::RunFrameReader look_;
  std::optional<ArrayBasis> basis_;
  std::unique_ptr<CompensatedRun> compensated_;
  bool models_sought_ = false;
  std::int64_t position_ = 0;
  struct Seen {
    db::StoredFrame frame;
    ArrayView view;
    std::vector<float> pressure_psi;  // empty: without models
    std::vector<std::uint16_t> status;
  };
  std::optional<Seen> newest_, peak_;
  std::optional<ArrayView> seated_;  // image of the seating check, before the first frame
};

// Samples for a loop: of one taxel, or the array's mean for taxel -1, after frame `after`, without void branches; x in
// psi, or in N for frames measured under an object; `set`: set-point; y in volts; t in s. Only frames with the same
// quantity as the newest; at most the newest few thousand. A `taxel` outside the array gives no points.
nlohmann::json loop_points(const db::RunStore& store, std::int64_t run, int taxel, std::int64_t after);

}  // namespace tactbench::bench
