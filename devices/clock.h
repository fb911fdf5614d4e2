// Process time: dwell, settling, creep, watchdogs and time stamps all read this one clock. A rig uses SteadyClock;
// a simulated rig uses TurnedClock, which the sequencer's thread alone turns and which stands still while a request
// is open, so that the same seed gives the same store.
#pragma once

#include <atomic>
#include <chrono>

namespace tactbench::devices {

using Nanoseconds = std::chrono::nanoseconds;

inline double in_seconds(Nanoseconds time) { return static_cast<double>(time.count()) * 1e-9; }
inline double in_milliseconds(Nanoseconds time) { return std::chrono::duration<double, std::milli>(time).count(); }

class Clock {
 public:
  virtual ~Clock() = default;
  // Time since the clock was made. Callable from any thread.
  [[nodiscard]] virtual Nanoseconds now() const = 0;
  // Returns once now() >= time. Sequencer's thread only.
  virtual void wait_until(Nanoseconds time) = 0;
  // A reply did not come within `nominal` of real time: process time advances by as much.
  virtual void reply_lost(Nanoseconds nominal) = 0;
};

class SteadyClock final : public Clock {
 public:
  // `rate`: process time runs that many times as fast as real time (a simulated rig in a process of its own).
  explicit SteadyClock(double rate = 1.0) : rate_(rate) {}
  [[nodiscard]] Nanoseconds now() const override;
  void wait_until(Nanoseconds time) override;
  void reply_lost(Nanoseconds) override {}  // the waiting itself has moved this clock

 private:
  double rate_;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

class TurnedClock final : public Clock {
 public:
  [[nodiscard]] Nanoseconds now() const override { return Nanoseconds(now_.load(std::memory_order_acquire)); }
  void wait_until(Nanoseconds time) override;
  void reply_lost(Nanoseconds nominal) override { wait_until(now() + nominal); }

 private:
  std::atomic<Nanoseconds::rep> now_{0};
};

}  // namespace tactbench::devices
