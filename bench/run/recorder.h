// Typed readings -> rows: opens branches as steps enter them, appends one frame a step, and is the only writer of a
// run's state while it runs.
#pragma once

#include <cstdint>
#include <string>

#include "bench/run/run_state.h"
#include "db/run_store.h"
#include "devices/pressure/pressure_source.h"
#include "devices/tactile/tactile_array.h"
#include "sequences/recipe.h"

namespace tactbench::bench {

struct StepReadings {
  std::uint16_t setpoint_counts = 0;
  devices::PressureReading feedback, reference;
  devices::ScanSet scans;
  devices::Nanoseconds commanded_at{0}, in_band_since{0};
  int exchanges = 0;
};

class Recorder {
 public:
  Recorder(db::RunStore& store, std::int64_t run, const devices::Clock& clock)
      : store_(store), run_(run), clock_(clock) {}
  void frame(const sequences::Step& step, const StepReadings& readings);
  void event(const std::string& kind, const std::string& id, const std::string& detail);
  // Throws std::logic_error on a change that the table does not allow.
  void state(RunState next, const std::string& reason);
  [[nodiscard]] int frames() const { return frames_; }
  [[nodiscard]] int most_exchanges() const { return most_exchanges_; }

 private:
  db::RunStore& store_;
  std::int64_t run_;
  const devices::Clock& clock_;
  RunState state_ = RunState::kPrepared;
  std::int64_t branch_ = 0;
  int sequence_ = -1, repeat_ = -1, ordinal_ = -1;
  int frames_ = 0, most_exchanges_ = 0;
};

}  // namespace tactbench::bench
