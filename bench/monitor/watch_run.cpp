#include "bench/monitor/watch_run.h"

#include <fmt/format.h>
#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <utility>

#include "bench/common/terminal_safe.h"
#include "bench/run/control/locks.h"

namespace tactbench::bench {

namespace {

using WatchClock = std::chrono::steady_clock;

constexpr std::size_t kLeastMap = 5;  // lines

class Watching {
 public:
  Watching(const LiveRun& first, const WatchRunOptions& options)
      : name_(first.name), options_(options), last_{first, {}, {}} {}

  std::optional<StoredRun> until_end(const StopRequest& stop) {
    for (std::optional<LiveRun> answer = last_.live; stop.signal() == 0;
         answer = send_command(name_, Command::kStatus, last_.live.server)) {
      const bool ours =
          answer && !answer->denied && answer->status.run == run() && answer->status.store == last_.live.status.store;
      if (ours) {
        last_ = view_of(*answer);
        show({});
      } else if (auto ended = end_of_run()) {
        return ended;
      } else {
        show("it does not answer: its process is stopped, or is ending");
      }
      (void)::poll(nullptr, 0, static_cast<int>(options_.every.count()));  // a signal ends it early
    }
    return std::nullopt;
  }

 private:
  [[nodiscard]] std::int64_t run() const { return last_.live.status.run; }

  // None: a process still carries it out.
  std::optional<StoredRun> end_of_run() {
    const db::RunStore store = db::RunStore::open_read_only(last_.live.status.store);
    StoredRun stored = stored_run(store, run());
    const bool open = stored.record.outcome == db::Outcome::kIncomplete;
    const std::optional<bool> carried_out = open ? is_carried_out(store.path(), run()) : false;
    if (carried_out == true) return std::nullopt;
    const std::vector<std::string> lines = stored_lines(stored, carried_out);
    if (options_.terminal) {
      paint(lines, newest_array(store, stored.record, options_.unit));
    } else {
      for (const std::string& line : lines) tty::print("{}\n", line);
    }
    return stored;
  }

  void show(const std::string& notice) {
    if (options_.terminal) {
      std::vector<std::string> lines = view_lines(last_, options_.unit);
      if (!notice.empty()) lines.front() += "; " + notice;
      return paint(lines, array());
    }
    const std::string phase = stage_of(last_.live.status.phase) + notice;
    const auto now = WatchClock::now();
    if (phase == shown_phase_ && now - shown_ < options_.line_every) return;
    shown_phase_ = phase;
    shown_ = now;
    tty::print("{}{}{}\n", view_line(last_, options_.unit), notice.empty() ? "" : "; ", notice);
    (void)std::fflush(stdout);
  }

  // Read again only when there is a new frame.
  const std::optional<ArrayView>& array() {
    if (!last_.stored || (array_ && array_frames_ == last_.stored->frames)) return array_;
    try {
      array_ = newest_array(db::RunStore::open_read_only(last_.live.status.store), last_.stored->record, options_.unit);
      array_frames_ = last_.stored->frames;
    } catch (const db::StoreError&) {  // the next poll tries again
    }
    return array_;
  }

  void paint(const std::vector<std::string>& lines, const std::optional<ArrayView>& array) {
    const ScreenSize size = screen_size(STDOUT_FILENO);
    screen_.paint(watch_block(lines, array, options_.shades, size), size);
  }

  std::string name_;
  const WatchRunOptions& options_;
  RunView last_;
  ScreenBlock screen_;
  std::optional<ArrayView> array_;
  std::int64_t array_frames_ = 0;
  std::string shown_phase_;
  WatchClock::time_point shown_{};
};

}  // namespace

std::vector<PaintedLine> watch_block(const std::vector<std::string>& lines, const std::optional<ArrayView>& array,
                                     Shades shades, ScreenSize size) {
  const std::size_t room = std::max<std::size_t>(size.rows, 2) - 1;
  std::size_t texts = std::min(lines.size(), room);
  std::vector<PaintedLine> map;
  if (array) {
    const auto whole = static_cast<std::size_t>(array->rows) + 1;
    if (texts + whole > room) texts = std::min(texts, std::max(kNeeded, room - std::min(room, whole)));
    texts = std::min(texts, room);
    if (room - texts >= std::min(kLeastMap, whole)) map = heat_map(*array, shades, size.columns, room - texts);
    if (map.empty()) texts = std::min(lines.size(), room);
  }
  std::vector<PaintedLine> block;
  for (std::size_t i = 0; i < texts; ++i) block.push_back({{lines[i]}});
  block.insert(block.end(), map.begin(), map.end());
  return block;
}

std::optional<StoredRun> watch_run(const LiveRun& first, const WatchRunOptions& options, const StopRequest& stop) {
  return Watching(first, options).until_end(stop);
}

}  // namespace tactbench::bench
