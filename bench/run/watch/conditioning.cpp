#include "bench/run/watch/conditioning.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numeric>

#include "analysis/json_io.h"

namespace tactbench::bench {

bool ConditioningWatch::enough(int cycle) const {
  if (!wants_output() || cycle < rule_.least || changes_.empty()) return false;
  return changes_.back() < rule_.change_percent;
}

void ConditioningWatch::see(const sequences::Step& step, const std::vector<std::uint16_t>& counts) {
  const auto cycle = static_cast<std::size_t>(step.repeat);
  if (loops_.size() <= cycle) loops_.resize(cycle + 1);
  const double sum = std::accumulate(counts.begin(), counts.end(), 0.0);
  loops_[cycle].push_back(sum / static_cast<double>(std::max<std::size_t>(1, counts.size())));
  if (cycle == 0 || loops_[cycle].size() != loops_[cycle - 1].size()) return;
  const auto [low, high] = std::minmax_element(loops_[cycle].begin(), loops_[cycle].end());
  double change = 0.0;
  for (std::size_t i = 0; i < loops_[cycle].size(); ++i) {
    change = std::max(change, std::abs(loops_[cycle][i] - loops_[cycle - 1][i]));
  }
  // A cycle has two steps; after the first of them the loop's change is not known yet.
  if (loops_[cycle].size() < 2 || *high <= *low) return;
  changes_.push_back(100.0 * change / (*high - *low));
}

std::string ConditioningWatch::verdict() const {
  if (!wants_output()) return "pass";
  return !changes_.empty() && changes_.back() < rule_.change_percent ? "pass" : "warning";
}

std::string ConditioningWatch::detail_json() const {
  nlohmann::ordered_json json = {{"cycles_at_most", rule_.cycles}, {"change_limit_percent", rule_.change_percent}};
  if (wants_output()) json["cycles_done"] = loops_.size();
  if (!changes_.empty()) json["last_change_percent"] = changes_.back();
  return analysis::json_line(json);
}

}  // namespace tactbench::bench
