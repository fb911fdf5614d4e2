// Tracks whether a simulated instrument of this process (an "end" of a wire) still owes an answer. Each end answers
// from its own thread, which a busy machine may delay for longer than a timeout. A wait on a wire (wait.h) therefore
// continues until every end has processed its requests, so that on a simulated bench only intentionally omitted answers
// are lost. On a real rig there are no ends in this process, so none is ever busy.
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

class EndActivity {
 public:
  EndActivity();  // busy until its first wait, because its thread has not started yet
  ~EndActivity();
  EndActivity(const EndActivity&) = delete;
  EndActivity& operator=(const EndActivity&) = delete;

  // Starts the end's thread. After `serve` returns there are no further answers.
  template <class Serve>
  [[nodiscard]] std::thread thread(Serve serve) {
    return std::thread([this, serve] {
      serve();
      leave();
    });
  }
  // poll() for that thread, which counts as busy between two of these calls. Without a time: no limit.
  int wait(std::span<pollfd> descriptors, std::optional<Nanoseconds> longest = std::nullopt);
  void leave();  // from now on never busy

  // True while an end of this process is busy or has data to read.
  [[nodiscard]] static bool any();

 private:
  [[nodiscard]] bool works();
  std::mutex mutex_;
  std::vector<pollfd> watched_;  // while it waits
  bool waits_ = false, left_ = false;
  const pid_t process_;  // a forked child does not have its parent's threads
};

}  // namespace tactbench::devices
