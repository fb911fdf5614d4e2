// Breakdown of a run's process time, printed and stored at its end.
#pragma once

#include <array>
#include <string>

#include "devices/clock.h"

namespace tactbench::bench {

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
