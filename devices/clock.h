// Process time: the one clock for dwell, settling, creep, watchdogs and time stamps. A rig uses SteadyClock. A
// simulated rig uses ManualClock: only the sequencer's thread advances it, and it does not advance while a request is
// open, so that the same seed gives the same store.
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
  // Call when no reply came within `nominal` of real time: advances process time by the same amount.
  virtual void reply_lost(Nanoseconds nominal) = 0;
};

class SteadyClock final : public Clock {
 public:
  // `rate`: speed of process time relative to real time (for a simulated rig in its own process).
  explicit SteadyClock(double rate = 1.0) : rate_(rate) {}
  [[nodiscard]] Nanoseconds now() const override;
  void wait_until(Nanoseconds time) override;
  void reply_lost(Nanoseconds) override {}  // the wait itself has advanced this clock

 private:
  double rate_;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

class ManualClock final : public Clock {
 public:
  [[nodiscard]] Nanoseconds now() const override { return Nanoseconds(now_.load(std::memory_order_acquire)); }
  void wait_until(Nanoseconds time) override;
  void reply_lost(Nanoseconds nominal) override { wait_until(now() + nominal); }

 private:
  std::atomic<Nanoseconds::rep> now_{0};
};

}  // namespace tactbench::devices
