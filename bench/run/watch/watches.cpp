#include "bench/run/watch/watches.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <nlohmann/json.hpp>
#include <numeric>
#include <optional>
#include <string>

#include "analysis/json_io.h"
#include "bench/common/process_time.h"

namespace tactbench::bench {

std::optional<std::string> BranchGuard::see(double value) {
  if (!std::isfinite(value)) return "a reading is not a number";
  highest_ = std::max(highest_.value_or(value), value);
  lowest_ = std::min(lowest_.value_or(value), value);
  if (to_ >= from_ && *highest_ - value > tolerance_) {
    return fmt::format("rose to {:.2f} and fell back to {:.2f} in the branch from {:g} to {:g} (tolerance {:g})",
                       *highest_, value, from_, to_, tolerance_);
  }
  if (to_ <= from_ && value - *lowest_ > tolerance_) {
    return fmt::format("fell to {:.2f} and rose again to {:.2f} in the branch from {:g} to {:g} (tolerance {:g})",
                       *lowest_, value, from_, to_, tolerance_);
  }
  return std::nullopt;
}

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

StuckRows StuckRowWatch::see(const devices::ScanSet& scans, double load, double least) {
  const auto rows = static_cast<std::size_t>(scans.rows);
  const auto columns = static_cast<std::size_t>(scans.columns);
  StuckRows stuck;
  if (scans.counts.size() != last_.counts.size() || changed_at_.size() != rows) {
    last_ = scans;
    changed_at_.assign(rows, load);
    return stuck;
  }
  std::size_t judged = 0;
  for (std::size_t row = 0; row < rows; ++row) {
    bool same = true, inside = false;
    for (std::size_t i = row * columns; i < scans.counts.size(); i += rows * columns) {
      for (std::size_t k = i; k < i + columns; ++k) {
        same = same && scans.counts[k] == last_.counts[k];
        inside = inside || (scans.counts[k] != 0 && scans.counts[k] != UINT16_MAX);
      }
    }
    judged += inside ? 1U : 0U;
    if (!same) changed_at_[row] = load;
    if (inside && std::abs(load - changed_at_[row]) >= least) stuck.rows.push_back(static_cast<int>(row));
  }
  stuck.all = judged > 0 && stuck.rows.size() == judged;
  last_ = scans;
  return stuck;
}

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

namespace {

// From the end of the work until it continues.
struct Interruption {
  std::int64_t from_ns = 0, to_ns = 0;
  bool resumed = false;  // the run was ended in between: incomplete work before it is repeated
  std::int64_t way_back_ns = std::numeric_limits<std::int64_t>::max();  // start of the path back after it
};

// "paused" of "pausing -> paused: asked by Ctrl-C".
std::string state_entered(const std::string& detail) {
  const std::size_t arrow = detail.find(" -> ");
  if (arrow == std::string::npos) return {};
  const std::size_t begin = arrow + 4;
  return detail.substr(begin, detail.find(':', begin) - begin);
}

std::vector<Interruption> interruptions(const std::vector<db::TimedEvent>& events) {
  constexpr std::array kNotAtWork{"paused", "suspended", "stopping", "ended", "prepared"};
  std::vector<Interruption> found;
  std::optional<Interruption> open;
  for (const db::TimedEvent& event : events) {
    if (event.kind == "way-back") {
      if (!open && !found.empty()) found.back().way_back_ns = std::min(found.back().way_back_ns, event.time_ns);
      continue;
    }
    const std::string state = state_entered(event.detail);
    if (state == "running" && open) {
      open->to_ns = event.time_ns;
      found.push_back(*open);
      open.reset();
    } else if (std::find(kNotAtWork.begin(), kNotAtWork.end(), state) != kNotAtWork.end()) {
      if (!open) open = Interruption{event.time_ns};
      open->resumed = open->resumed || state == "prepared";
    }
  }
  return found;
}

class Frames {
 public:
  Frames(const db::RunReader& store, std::int64_t run, std::int64_t last) : store_(store), run_(run), last_(last) {}
  // None below the first and above the last.
  [[nodiscard]] std::optional<db::FrameTime> at(std::int64_t position) const {
    return position < 1 || position > last_ ? std::nullopt : store_.frame_time(run_, position);
  }
  // The first position of a frame later than `ns`; last + 1: none. Times rise with the position.
  [[nodiscard]] std::int64_t after(std::int64_t ns) const {
    std::int64_t low = 1, high = last_ + 1;
    while (low < high) {
      const std::int64_t middle = low + (high - low) / 2;
      const std::optional<db::FrameTime> frame = at(middle);
      if (frame && frame->time_ns > ns) {
        high = middle;
      } else {
        low = middle + 1;
      }
    }
    return low;
  }
  // The first frame that counts from there on (`step` 1 or -1); 0 or last + 1: none.
  [[nodiscard]] std::int64_t kept(std::int64_t position, int step) const {
    for (std::optional<db::FrameTime> frame = at(position); frame && frame->is_void; frame = at(position)) {
      position += step;
    }
    return position;
  }
  // Time between two successive frames of that branch; none if there are fewer than two.
  [[nodiscard]] std::optional<std::int64_t> pace(std::int64_t position) const {
    std::optional<std::int64_t> least;
    for (std::int64_t i = position; i < position + 2; ++i) {
      const std::optional<db::FrameTime> one = at(i), next = at(i + 1);
      if (!one || !next || next->is_void || next->sequence != one->sequence) break;
      least = std::min(least.value_or(next->time_ns - one->time_ns), next->time_ns - one->time_ns);
    }
    return least;
  }

 private:
  const db::RunReader& store_;
  std::int64_t run_, last_;
};

// All interruptions between two frames that count.
std::int64_t lost_between(const Frames& frames, std::int64_t before, std::int64_t next,
                          const std::vector<Interruption>& all) {
  const std::optional<db::FrameTime> first = frames.at(before), second = frames.at(next);
  const std::int64_t began_ns = first ? first->time_ns : 0;
  const std::int64_t gap_ns = second->time_ns - began_ns;
  const bool same_sequence = first && first->sequence == second->sequence;
  const bool path_to_branch = all.back().way_back_ns <= second->time_ns;
  const std::optional<std::int64_t> pace_ns = frames.pace(next);
  // An uninterrupted run continues with the next frame.
  if (path_to_branch && same_sequence && pace_ns) return gap_ns - std::min(gap_ns, *pace_ns);
  std::int64_t lost_ns = 0;
  for (const Interruption& one : all) {
    const bool again = one.resumed || path_to_branch;  // all work since the previous frame was lost
    lost_ns = again ? one.to_ns - began_ns : lost_ns + one.to_ns - one.from_ns;
  }
  return std::clamp<std::int64_t>(lost_ns, 0, gap_ns);
}

}  // namespace

std::vector<LostTime> lost_times(const db::RunReader& store, std::int64_t run, std::int64_t last) {
  const std::vector<Interruption> all = interruptions(store.timed_events(run));
  const Frames frames(store, run, last);
  std::vector<LostTime> lost;
  for (std::size_t i = 0; i < all.size();) {
    const std::int64_t next = frames.kept(frames.after(all[i].to_ns), 1);
    if (next > last) break;
    const std::int64_t before = frames.kept(frames.after(all[i].from_ns) - 1, -1);
    std::vector<Interruption> here;
    while (i < all.size() && frames.kept(frames.after(all[i].to_ns), 1) == next) here.push_back(all[i++]);
    lost.push_back({next, lost_between(frames, before, next, here)});
  }
  return lost;
}

}  // namespace tactbench::bench
