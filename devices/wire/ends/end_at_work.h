// State of the simulated ends of this process: whether one still owes an answer. An end answers from a thread of its
// own, which a busy machine may hold up for longer than a timeout. A wait on a wire (wait.h) therefore continues until
// every end has dealt with its requests, so that in a simulated bench only what an end leaves unanswered on purpose is
// lost. On a rig there are no ends in this process, and none is ever at work.
#pragma once

#include <poll.h>
#include <sys/types.h>

#include <mutex>
#include <optional>
#include <span>
#include <thread>
#include <vector>

#include "devices/clock.h"

namespace tactbench::devices {

class EndAtWork {
 public:
  EndAtWork();  // at work until its first wait: its thread has yet to start
  ~EndAtWork();
  EndAtWork(const EndAtWork&) = delete;
  EndAtWork& operator=(const EndAtWork&) = delete;

  // The end's thread. Once `serve` returns there are no further answers.
  template <class Serve>
  [[nodiscard]] std::thread thread(Serve serve) {
    return std::thread([this, serve] {
      serve();
      leave();
    });
  }
  // poll() for that thread, which works between two of these calls. No time: without limit.
  int wait(std::span<pollfd> descriptors, std::optional<Nanoseconds> longest = std::nullopt);
  void leave();  // is never at work again

  // True while an end of this process works or has something to read.
  [[nodiscard]] static bool any();

 private:
  [[nodiscard]] bool works();
  std::mutex mutex_;
  std::vector<pollfd> watched_;  // while it waits
  bool waits_ = false, left_ = false;
  const pid_t process_;  // a forked child has no threads of its parent
};

}  // namespace tactbench::devices
