// A program that this one starts and watches, in a process group of its own: Ctrl-C in the terminal is not for it.
#pragma once

#include <sys/types.h>

#include <chrono>
#include <optional>
#include <string>
#include <vector>

namespace tactbench::bench {

struct ChildStart {
  std::vector<std::string> words;        // the program's path first
  std::vector<std::string> environment;  // all that it sees, NAME=value each
  // Open descriptor for its standard output and error, which is closed here, whatever comes; its input is /dev/null
  // then. -1: all three as ours.
  int output = -1;
  // SIGTERM reaches it when the thread that starts it ends, however that ends; and it is not begun then.
  bool ends_with_us = false;
};

// Our environment, with `own` instead of what had their names.
std::vector<std::string> environment_with(std::vector<std::string> own);

class ChildProgram {
 public:
  // No signal is blocked in it; SIGINT, SIGTERM and SIGPIPE are what they are by default. Returns once the program has
  // taken the process over. Throws std::system_error where no process can be made or the program cannot be started.
  explicit ChildProgram(ChildStart start);
  ~ChildProgram();  // kills it with its group and waits for its end, if it still lives
  ChildProgram(ChildProgram&& other) noexcept;
  ChildProgram& operator=(ChildProgram&& other) noexcept;

  // How it ended, as waitpid() says it (WIFEXITED ...); none: it lives. One whose end the system does not tell counts
  // as exit code 127.
  std::optional<int> ended();
  std::optional<int> ended_by(std::chrono::steady_clock::time_point last);  // looks every 20 ms
  int wait();                                                               // as long as it takes

  void terminate() const;   // SIGTERM to the program, if it lives
  void kill_group() const;  // SIGKILL to it and to what it has started or left behind in its group

 private:
  pid_t process_ = -1;  // and its group; -1: moved from
  std::optional<int> status_;
};

}  // namespace tactbench::bench
