#include "bench/common/stop_request.h"

#include <fmt/format.h>

#include <atomic>

namespace tactbench::bench {

namespace {

// Also those by which the machine says that it is going down (power, processor time).
constexpr std::array<int, 8> kSignals{SIGINT, SIGTERM, SIGHUP, SIGQUIT, SIGUSR1, SIGUSR2, SIGPWR, SIGXCPU};

std::atomic<int> caught{0};  // the first
std::atomic<int> ends{0};    // the first but SIGINT
std::atomic<int> interrupted{0};
static_assert(std::atomic<int>::is_always_lock_free, "a signal handler needs it");

void on_signal(int number) {
  int none = 0;
  caught.compare_exchange_strong(none, number);
  none = 0;
  if (number == SIGINT) {
    ++interrupted;
  } else {
    ends.compare_exchange_strong(none, number);
  }
}

}  // namespace

StopRequest::StopRequest() {
  caught = 0;
  ends = 0;
  interrupted = 0;
  struct sigaction action {};
  action.sa_handler = on_signal;
  sigemptyset(&action.sa_mask);
  action.sa_flags = SA_RESTART;
  for (std::size_t i = 0; i < kSignals.size(); ++i) {
    sigaction(kSignals[i], nullptr, &old_[i].action);
    if (kSignals[i] == SIGHUP && old_[i].action.sa_handler == SIG_IGN) continue;
    old_[i].number = kSignals[i];
    sigaction(kSignals[i], &action, nullptr);
  }
}

StopRequest::~StopRequest() {
  for (const Old& old : old_) {
    if (old.number != 0) sigaction(old.number, &old.action, nullptr);
  }
}

int StopRequest::signal() const { return caught; }
int StopRequest::interrupts() const { return interrupted; }
int StopRequest::ending() const { return ends; }

std::string signal_text(int number) {
  switch (number) {
    case SIGINT:
      return "Ctrl-C";
    case SIGTERM:
      return "a request to terminate";
    case SIGHUP:
      return "a hang-up: the terminal or the connection was closed";
    case SIGQUIT:
      return "a request to quit (SIGQUIT, Ctrl-\\)";
    default:
      return fmt::format("signal {}", number);
  }
}

}  // namespace tactbench::bench
