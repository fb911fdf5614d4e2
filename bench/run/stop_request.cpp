#include "bench/run/stop_request.h"

#include <atomic>

namespace tactbench::bench {

namespace {

std::atomic<int> caught{0};  // the first
std::atomic<int> interrupted{0};
std::atomic<int> terminates{0};
static_assert(std::atomic<int>::is_always_lock_free, "a signal handler needs it");

void on_signal(int number) {
  int none = 0;
  caught.compare_exchange_strong(none, number);
  ++(number == SIGINT ? interrupted : terminates);
}

}  // namespace

StopRequest::StopRequest() {
  caught = 0;
  interrupted = 0;
  terminates = 0;
  struct sigaction action {};
  action.sa_handler = on_signal;
  sigemptyset(&action.sa_mask);
  action.sa_flags = SA_RESTART;
  sigaction(SIGINT, &action, &old_interrupt_);
  sigaction(SIGTERM, &action, &old_terminate_);
}

StopRequest::~StopRequest() {
  sigaction(SIGINT, &old_interrupt_, nullptr);
  sigaction(SIGTERM, &old_terminate_, nullptr);
}

int StopRequest::signal() const { return caught; }
int StopRequest::interrupts() const { return interrupted; }
bool StopRequest::terminate() const { return terminates > 0; }

}  // namespace tactbench::bench
