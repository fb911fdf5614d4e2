// Estimates a run's working time and the time left: from completed runs of the same recipes on the same bench or, if
// there are none, from the model of sequences/estimate.h. Always a band. Waiting for people and conditions is not
// included (watches.h); prompts are counted separately.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "bench/config/config.h"
#include "db/run_store.h"
#include "devices/clock.h"
#include "sequences/estimate.h"

namespace tactbench::bench {

// The bench's parameters of the model.
sequences::TimeModel time_model(const BenchConfig& bench);

struct TimeBand {  // 10 % of the runs are expected to be shorter than p10, 10 % longer than p90
  double p10_s = 0.0, p50_s = 0.0, p90_s = 0.0;
  int runs = 0;     // number of past runs used, the smallest over the recipes; 0: at least one recipe uses the model
  int prompts = 0;  // to the operator, not included
};

// For a run with so many valid frames: the step at which its first incomplete branch begins.
std::size_t steps_done(const std::vector<sequences::Step>& steps, std::int64_t frames);

class TimeEstimate {
 public:
  TimeEstimate(const std::vector<sequences::Recipe>& recipes, const std::vector<sequences::Step>& steps,
               const sequences::TimeModel& model);

  // Replaces the model by the data of `store`: completed runs of bench `bench_id` with the same recipe text and the
  // same recipe overrides. `remaining_too`: also learns how time passed within the runs, which takes some milliseconds
  // more; without it remaining() follows the model. Throws StoreError.
  void learn(const db::RunReader& store, const std::string& bench_id, const std::vector<sequences::Override>& overrides,
             bool remaining_too);

  [[nodiscard]] TimeBand total() const { return remaining(0); }
  // After `steps_done` of the steps.
  [[nodiscard]] TimeBand remaining(std::size_t steps_done) const;
  [[nodiscard]] TimeBand total_of(std::size_t recipe) const;

 private:
  struct Past {  // one stored sequence: frames done -> seconds since the sequence began; first (0, 0), last the total
    std::vector<std::pair<double, double>> elapsed;
  };
  struct Part {  // one recipe
    std::string sha256;
    int repeats = 0, frames_per_repeat = 0;
    std::size_t first_step = 0, steps = 0;
    int prompts = 0;
    std::vector<Past> past;
  };
  [[nodiscard]] TimeBand of_part(const Part& part, std::size_t steps_done) const;
  [[nodiscard]] TimeBand sum(std::size_t first_part, std::size_t last_part, std::size_t steps_done) const;
  std::vector<Part> parts_;
  std::vector<double>
      frames_done_;  // number of frames before each step, within its recipe; fractions between two frames
  std::vector<sequences::StepTime> left_;  // by the model, from each step to its recipe's end
};

// Breakdown of a run's process time, printed and stored at the end of the run.
enum class Spent { kSetup, kConditioning, kMoving, kSettling, kDwelling, kReading, kRedoing, kWaiting, kTeardown };
inline constexpr std::size_t kSpentKinds = 9;
const char* to_string(Spent spent);

class TimeSpent {
 public:
  explicit TimeSpent(const devices::Clock& clock) : clock_(clock), since_(clock.now()) {}
  // From now on time counts as `spent`; returns the previous category.
  Spent start(Spent spent);
  // While this object lives all time counts as this category (conditioning, redoing).
  class Stretch {
   public:
    Stretch(TimeSpent& times, Spent spent);
    ~Stretch();
    Stretch(const Stretch&) = delete;
    Stretch& operator=(const Stretch&) = delete;

   private:
    TimeSpent& times_;
  };
  [[nodiscard]] double seconds(Spent spent) const;  // up to the last start()
  [[nodiscard]] double total() const;
  // "dwelling 71.0 %, settling 18.4 %, ...": only shares of 0.1 % and more.
  [[nodiscard]] std::string text() const;

 private:
  const devices::Clock& clock_;
  devices::Nanoseconds since_;
  Spent current_ = Spent::kSetup;
  bool stretch_ = false;
  std::array<double, kSpentKinds> seconds_{};
};

}  // namespace tactbench::bench
