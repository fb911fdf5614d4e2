#include "bench/common/utc.h"

#include <fmt/chrono.h>
#include <time.h>

#include <algorithm>
#include <ctime>

namespace tactbench::bench {

std::string utc_now() { return utc_days_ago(0); }

std::string utc_days_ago(int days) {
  return fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(std::time(nullptr) - std::time_t{86400} * days));
}

double seconds_between(const std::string& earlier_utc, const std::string& later_utc) {
  const auto parse = [](const std::string& text) -> std::time_t {
    std::tm time{};
    return strptime(text.c_str(), "%Y-%m-%dT%H:%M:%SZ", &time) == nullptr ? -1 : timegm(&time);
  };
  const std::time_t earlier = parse(earlier_utc), later = parse(later_utc);
  return earlier < 0 || later < 0 ? 0.0 : std::max(0.0, std::difftime(later, earlier));
}

}  // namespace tactbench::bench
