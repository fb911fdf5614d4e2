#include "bench/run/watch/lost_time.h"

#include <algorithm>
#include <array>
#include <limits>
#include <optional>
#include <string>

namespace tactbench::bench {

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
  Frames(const db::RunStore& store, std::int64_t run, std::int64_t last) : store_(store), run_(run), last_(last) {}
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
  const db::RunStore& store_;
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

std::vector<LostTime> lost_times(const db::RunStore& store, std::int64_t run, std::int64_t last) {
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
