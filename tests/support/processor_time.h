// What this thread has computed, whatever else the machine did meanwhile.
#pragma once

#include <ctime>

namespace tactbench::tests {

inline double processor_seconds() {
  timespec time{};
  ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

}  // namespace tactbench::tests
