#include "bench/run/control/status_board.h"

#include <algorithm>

namespace tactbench::bench {

void StatusBoard::publish() {
  const double by_pace = pace_.left_s(Pace::Clock::now(), now_.step, now_.steps);
  if (now_.left_high_s <= 0.0) now_.left_s = std::max(by_pace, 0.0) * (now_.rate > 0.0 ? now_.rate : 1.0);
  control_.publish(now_);
}

void StatusBoard::phase(const std::string& words) {
  now_.phase = words;
  publish();
  refresh();
}

void StatusBoard::refresh() {
  if (progress_.due(now_)) progress_.show(control_.status());
}

void StatusBoard::step_done() {
  if (now_.step == now_.steps || progress_.due(now_)) progress_.show(control_.status());
}

}  // namespace tactbench::bench
