#include "bench/run/control/status_board.h"

namespace tactbench::bench {

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
