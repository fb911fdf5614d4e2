// A program that runs during a test, its standard output read line by line; killed by its id when the test ends, and
// by the kernel when the test dies.
#pragma once

#include <poll.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

namespace tactbench::tests {

// SIGSTOP, and waits until no thread of the process runs on: one whose turn the busy machine puts off delays the stop
// of all.
inline void stop_process(pid_t process) {
  kill(process, SIGSTOP);
  const auto runs = [](const std::filesystem::path& stat) {
    std::string line;
    std::getline(std::ifstream(stat), line);  // "ID (name) STATE ..."; nothing when the thread has ended meanwhile
    const std::size_t at = line.rfind(')');
    return at != std::string::npos && std::string("TtZX").find(line.at(at + 2)) == std::string::npos;
  };
  for (bool any = true; any; usleep(1000)) {
    any = false;
    std::error_code gone;
    for (const auto& thread : std::filesystem::directory_iterator("/proc/" + std::to_string(process) + "/task", gone))
      any = any || runs(thread.path() / "stat");
  }
}

class ChildProcess {
 public:
  explicit ChildProcess(std::vector<std::string> words) {
    int ends[2];
    if (pipe(ends) != 0) throw std::runtime_error("pipe failed");
    std::vector<char*> argv;
    for (std::string& word : words) argv.push_back(word.data());
    argv.push_back(nullptr);
    child_ = fork();
    if (child_ == 0) {
      prctl(PR_SET_PDEATHSIG, SIGKILL);
      dup2(ends[1], 1);
      close(ends[0]);
      close(ends[1]);
      execv(argv[0], argv.data());
      _exit(127);
    }
    close(ends[1]);
    output_ = ends[0];
    if (child_ < 0) throw std::runtime_error("fork failed");
  }
  ~ChildProcess() {
    if (child_ > 0) {
      kill(child_, SIGKILL);
      waitpid(child_, nullptr, 0);
    }
    close(output_);
  }
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;

  [[nodiscard]] pid_t pid() const { return child_; }
  void signal(int number) const {
    if (child_ <= 0) return;
    if (number == SIGSTOP)
      stop_process(child_);
    else
      kill(child_, number);
  }
  // Its exit code, -signal when one ended it; none when it lives on for `timeout`.
  std::optional<int> ended_within(std::chrono::milliseconds timeout) {
    const auto end = std::chrono::steady_clock::now() + timeout;
    for (int status = 0;; usleep(2000)) {
      if (child_ < 0) return code_;
      if (waitpid(child_, &status, WNOHANG) == child_) {
        child_ = -1;
        code_ = WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
        return code_;
      }
      if (std::chrono::steady_clock::now() >= end) return std::nullopt;
    }
  }
  // The same; throws when it does not end within `timeout`.
  int wait(std::chrono::milliseconds timeout = std::chrono::seconds(60)) {
    if (const std::optional<int> code = ended_within(timeout)) return *code;
    throw std::runtime_error("the child does not end");
  }
  // The next line without its end. Throws when it does not come within `timeout`.
  std::string line(std::chrono::milliseconds timeout = std::chrono::seconds(60)) {
    const auto end = std::chrono::steady_clock::now() + timeout;
    std::string text;
    for (char c = 0;;) {
      const auto left =
          std::chrono::duration_cast<std::chrono::milliseconds>(end - std::chrono::steady_clock::now()).count();
      pollfd descriptor{output_, POLLIN, 0};
      if (left <= 0 || ::poll(&descriptor, 1, static_cast<int>(left)) != 1 || ::read(output_, &c, 1) != 1) {
        throw std::runtime_error("the child's line did not come; so far: '" + text + "'");
      }
      if (c == '\n') return text;
      text += c;
    }
  }

 private:
  pid_t child_ = -1;
  int output_ = -1, code_ = -1;
};

}  // namespace tactbench::tests
