#include "devices/clock.h"

#include <thread>

namespace tactbench::devices {

Nanoseconds SteadyClock::now() const {
  const Nanoseconds real = std::chrono::steady_clock::now() - start_;
  return rate_ == 1.0 ? real : std::chrono::duration_cast<Nanoseconds>(real * rate_);
}

void SteadyClock::wait_until(Nanoseconds time) {
  const std::chrono::duration<double, std::nano> real = std::chrono::duration<double, std::nano>(time) / rate_;
  std::this_thread::sleep_until(start_ + (rate_ == 1.0 ? time : std::chrono::ceil<Nanoseconds>(real)));
}

void ManualClock::wait_until(Nanoseconds time) {
  // Only one thread turns the clock, so load and store need not be one atomic operation; it never goes back.
  if (time > now()) now_.store(time.count(), std::memory_order_release);
}

}  // namespace tactbench::devices
