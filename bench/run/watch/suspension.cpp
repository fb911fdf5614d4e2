#include "bench/run/watch/suspension.h"

#include <fmt/format.h>

#include <algorithm>

#include "bench/common/process_time.h"

namespace tactbench::bench {

namespace {

const EnvironmentReading* find(const std::vector<EnvironmentReading>& readings, const std::string& quantity) {
  const auto found = std::find_if(readings.begin(), readings.end(),
                                  [&](const EnvironmentReading& reading) { return reading.quantity == quantity; });
  return found == readings.end() ? nullptr : &*found;
}

}  // namespace

void SuspensionWatch::follow(const std::vector<sequences::Suspension>& rules) {
  rules_ = rules;
  good_since_.reset();
}

std::optional<Suspended> SuspensionWatch::tripped(const std::vector<EnvironmentReading>& readings) const {
  for (const sequences::Suspension& rule : rules_) {
    const EnvironmentReading* reading = find(readings, rule.quantity);
    if (reading == nullptr) continue;
    if (rule.below ? reading->value < rule.trip : reading->value > rule.trip) {
      return Suspended{fmt::format("{} is {:.2f}, {} {:g}", rule.quantity, reading->value,
                                   rule.below ? "below" : "above", rule.trip),
                       rule.timeout_s};
    }
  }
  return std::nullopt;
}

bool SuspensionWatch::may_resume(const std::vector<EnvironmentReading>& readings, devices::Nanoseconds now) {
  double hold_s = 0.0;
  for (const sequences::Suspension& rule : rules_) {
    const EnvironmentReading* reading = find(readings, rule.quantity);
    if (reading == nullptr) continue;
    if (rule.below ? reading->value < rule.resume : reading->value > rule.resume) {
      good_since_.reset();
      return false;
    }
    hold_s = std::max(hold_s, rule.hold_s);
  }
  if (!good_since_) good_since_ = now;
  if (now - *good_since_ < seconds(hold_s)) return false;
  good_since_.reset();
  return true;
}

}  // namespace tactbench::bench
