#include "bench/common/stop_request.h"

#include <fmt/format.h>

#include <array>
#include <atomic>

namespace tactbench::bench {

namespace {

// Including signals for a shutdown of the machine (power) and for limits (processor time).
constexpr std::array kSignals{SIGINT, SIGTERM, SIGHUP, SIGQUIT, SIGUSR1, SIGUSR2, SIGPWR, SIGXCPU};
// Signals that are not sent on purpose would also end the process; a profiler or a fuzzer uses some of them.
constexpr std::array kUnexpected{SIGALRM, SIGVTALRM, SIGPROF, SIGIO, SIGSTKFLT};

std::vector<int> unexpected_signals() {
  std::vector<int> all(kUnexpected.begin(), kUnexpected.end());
  for (int number = SIGRTMIN; number <= SIGRTMAX; ++number) all.push_back(number);
  return all;
}

std::atomic<int> caught{0};        // the first
std::atomic<int> first_to_end{0};  // the first except SIGINT
std::atomic<int> interrupted{0};
int depth = 0;      // number of existing objects
bool kept = false;  // until a further one
static_assert(std::atomic<int>::is_always_lock_free, "a signal handler needs it");

void on_signal(int number) {
  int none = 0;
  caught.compare_exchange_strong(none, number);
  none = 0;
  if (number == SIGINT) {
    ++interrupted;
  } else {
    first_to_end.compare_exchange_strong(none, number);
  }
}

}  // namespace

StopRequest::StopRequest() {
  if (depth++ == 0) {
    caught = 0;
    first_to_end = 0;
    interrupted = 0;
    kept = false;
  }
  struct sigaction action {};
  action.sa_handler = on_signal;
  sigemptyset(&action.sa_mask);
  action.sa_flags = SA_RESTART;
  const auto take = [&](int number, bool only_unused) {
    Old old;
    old.number = number;
    sigaction(number, nullptr, &old.action);
    if (only_unused && old.action.sa_handler != SIG_DFL) return;
    if (number == SIGHUP && old.action.sa_handler == SIG_IGN) return;
    sigaction(number, &action, nullptr);
    old_.push_back(old);
  };
  for (const int number : kSignals) take(number, false);
  for (const int number : unexpected_signals()) take(number, true);
}

StopRequest::~StopRequest() {
  --depth;
  if (kept) return;
  for (const Old& old : old_) sigaction(old.number, &old.action, nullptr);
}

void StopRequest::keep() { kept = true; }
int StopRequest::signal() const { return caught; }
int StopRequest::interrupts() const { return interrupted; }
int StopRequest::ending() const { return first_to_end; }

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
