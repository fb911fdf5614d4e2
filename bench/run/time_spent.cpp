#include "bench/run/time_spent.h"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>
#include <utility>
#include <vector>

namespace tactbench::bench {

const char* to_string(Spent spent) {
  constexpr std::array<const char*, kSpentKinds> kWords = {
      "setting up", "conditioning", "moving", "settling", "dwelling", "reading", "redoing", "waiting", "tearing down"};
  return kWords.at(static_cast<std::size_t>(spent));
}

Spent TimeSpent::start(Spent spent) {
  const devices::Nanoseconds now = clock_.now();
  seconds_[static_cast<std::size_t>(current_)] += devices::in_seconds(now - since_);
  since_ = now;
  return stretch_ ? current_ : std::exchange(current_, spent);
}

TimeSpent::Stretch::Stretch(TimeSpent& times, Spent spent) : times_(times) {
  (void)times_.start(spent);
  times_.stretch_ = true;
}

TimeSpent::Stretch::~Stretch() {
  times_.stretch_ = false;
  (void)times_.start(times_.current_);
}

double TimeSpent::seconds(Spent spent) const { return seconds_[static_cast<std::size_t>(spent)]; }

double TimeSpent::total() const { return std::accumulate(seconds_.begin(), seconds_.end(), 0.0); }

std::string TimeSpent::text() const {
  std::vector<std::pair<double, Spent>> parts;
  for (std::size_t i = 0; i < kSpentKinds; ++i) parts.emplace_back(seconds_[i], static_cast<Spent>(i));
  std::stable_sort(parts.begin(), parts.end(), [](const auto& a, const auto& b) { return a.first > b.first; });
  std::string text;
  for (const auto& [spent_s, spent] : parts) {
    if (spent_s < 0.001 * total()) continue;
    text += fmt::format("{}{} {:.1f} %", text.empty() ? "" : ", ", to_string(spent), 100.0 * spent_s / total());
  }
  return text;
}

}  // namespace tactbench::bench
