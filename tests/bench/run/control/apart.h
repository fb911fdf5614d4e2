// Processes next to the test's own, of this user or of another.
#pragma once

#include <grp.h>
#include <sys/wait.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <csignal>
#include <functional>
#include <stdexcept>

namespace tactbench::tests {

inline constexpr uid_t kNobodyHere = 65534;
inline constexpr gid_t kGroupHere = 54321;

// A separate process, which lives until the object is destroyed; `stay`, called by its work, says that all is ready.
using Stay = std::function<void()>;

class Apart {
 public:
  explicit Apart(const std::function<void(const Stay&)>& work) {
    REQUIRE(pipe(ends_) == 0);
    child_ = fork();
    if (child_ == 0) {
      try {
        work([this] {
          (void)!write(ends_[1], "x", 1);
          for (;;) pause();
        });
      } catch (...) {
      }
      _exit(1);
    }
    close(ends_[1]);
    char byte = 0;
    ready_ = read(ends_[0], &byte, 1) == 1;
  }
  ~Apart() {
    kill(child_, SIGKILL);
    waitpid(child_, nullptr, 0);
    close(ends_[0]);
  }
  Apart(const Apart&) = delete;
  Apart& operator=(const Apart&) = delete;
  [[nodiscard]] bool ready() const { return ready_; }
  [[nodiscard]] pid_t process() const { return child_; }

 private:
  int ends_[2] = {-1, -1};
  pid_t child_ = -1;
  bool ready_ = false;
};

// Needs root's rights.
inline void become_nobody(gid_t group) {
  if (setgroups(1, &group) != 0 || setgid(kNobodyHere) != 0 || setuid(kNobodyHere) != 0)
    throw std::runtime_error("no rights");
}

}  // namespace tactbench::tests
