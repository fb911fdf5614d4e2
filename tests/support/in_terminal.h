// The program under test in a separate terminal (a pseudo-terminal), as a user sees it.
#pragma once

#include <fcntl.h>
#include <pty.h>
#include <sys/ioctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <csignal>
#include <cstdlib>
#include <string>
#include <vector>

#include "tests/support/endless_run.h"
#include "tests/support/paths.h"

namespace tactbench::tests {

class InTerminal {
 public:
  InTerminal(const std::string& folder, const std::vector<std::string>& arguments, unsigned short columns,
             unsigned short rows, const char* no_color = "") {
    winsize size{rows, columns, 0, 0};
    std::vector<std::string> words = {program_path()};
    words.insert(words.end(), arguments.begin(), arguments.end());
    std::vector<char*> argv;
    for (std::string& word : words) argv.push_back(word.data());
    argv.push_back(nullptr);
    child_ = forkpty(&terminal_, nullptr, nullptr, &size);
    if (child_ == 0) {
      setenv("TERM", "xterm-256color", 1);
      setenv("NO_COLOR", no_color, 1);
      unsetenv("CI");
      if (chdir(folder.c_str()) == 0) execv(argv[0], argv.data());
      _exit(127);
    }
    REQUIRE(child_ > 0);
    fcntl(terminal_, F_SETFL, O_NONBLOCK);
  }
  ~InTerminal() {
    if (child_ > 0) {
      kill(child_, SIGKILL);
      waitpid(child_, nullptr, 0);
    }
    close(terminal_);
  }
  InTerminal(const InTerminal&) = delete;
  InTerminal& operator=(const InTerminal&) = delete;
  // All that it has shown so far.
  const std::string& shown() {
    char bytes[4096];
    for (ssize_t size = 0; (size = ::read(terminal_, bytes, sizeof(bytes))) > 0;)
      shown_.append(bytes, static_cast<std::size_t>(size));
    return shown_;
  }
  bool shows(const std::string& text) {
    return comes_true([&] { return shown().find(text) != std::string::npos; });
  }
  void type(const std::string& keys) const { REQUIRE(::write(terminal_, keys.data(), keys.size()) > 0); }
  // Its exit code; -1: it does not end.
  int wait() {
    int status = 0;
    const bool ended = comes_true([&] {
      (void)shown();
      return waitpid(child_, &status, WNOHANG) == child_;
    });
    if (!ended) return -1;
    child_ = -1;
    (void)shown();
    return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
  }

 private:
  pid_t child_ = -1;
  int terminal_ = -1;
  std::string shown_;
};

}  // namespace tactbench::tests
