// Wall-clock time as it is stored: 2026-01-31T12:00:00Z. Process time is devices/clock.h.
#pragma once

#include <string>

namespace tactbench::bench {

std::string utc_now();
std::string utc_days_ago(int days);
// Seconds from one stored time to another; 0 when either cannot be read or time went backwards.
double seconds_between(const std::string& earlier_utc, const std::string& later_utc);

}  // namespace tactbench::bench
