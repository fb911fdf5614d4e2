#include "devices/clock.h"

#include <thread>

namespace tactbench::devices {

Nanoseconds SteadyClock::now() const {
  return std::chrono::duration_cast<Nanoseconds>(std::chrono::steady_clock::now() - start_);
}

void SteadyClock::wait_until(Nanoseconds time) { std::this_thread::sleep_until(start_ + time); }

void TurnedClock::wait_until(Nanoseconds time) {
  // One thread turns the clock, so load and store need not be one step; it never goes back.
  if (time > now()) now_.store(time.count(), std::memory_order_release);
}

}  // namespace tactbench::devices
