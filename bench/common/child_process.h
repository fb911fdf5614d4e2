// A program that this one starts and watches, in a separate process group, which Ctrl-C in the terminal does not reach.
#pragma once

#include <sys/types.h>

#include <chrono>
#include <optional>
#include <string>
#include <vector>

namespace tactbench::bench {

struct ChildStart {
  std::vector<std::string> arguments;    // the program's path first
  std::vector<std::string> environment;  // its complete environment, each NAME=value
  // Open descriptor for its standard output and error; closed in this process in any case; its input is then /dev/null.
  // -1: inherits all three.
  int output = -1;
  // SIGTERM is sent to it when the starting thread ends for any reason; if that has already ended, the program is not
  // started.
  bool ends_with_parent = false;
};

// This process's environment, with the variables in `own` added or replaced.
std::vector<std::string> environment_with(std::vector<std::string> own);

class ChildProgram {
 public:
  // Starts with no signal blocked and default handling of SIGINT, SIGTERM and SIGPIPE. Returns once exec() has
  // succeeded. Throws std::system_error when no process can be made or the program cannot be started.
  explicit ChildProgram(ChildStart start);
  ~ChildProgram();  // if it still runs: kills it with its group and waits for its end
  ChildProgram(ChildProgram&& other) noexcept;
  ChildProgram& operator=(ChildProgram&& other) noexcept;

  // The program's wait status as waitpid() reports it (WIFEXITED ...); none: it still runs. Exit code 127 when the
  // system does not report its end.
  std::optional<int> ended();
  std::optional<int> ended_by(std::chrono::steady_clock::time_point last);  // polls every 20 ms
  int wait();                                                               // without a time limit

  void terminate() const;   // SIGTERM to the program, if it still runs
  void kill_group() const;  // SIGKILL to it and to all processes of its group
  [[nodiscard]] pid_t process() const { return process_; }
  void let_go() { process_ = -1; }  // the program continues without this object

 private:
  pid_t process_ = -1;  // also the number of its group; -1: moved from
  std::optional<int> status_;
};

}  // namespace tactbench::bench
