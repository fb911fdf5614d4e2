#include "bench/common/child_process.h"

#include <fcntl.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <string_view>
#include <system_error>
#include <thread>
#include <utility>

extern char** environ;

namespace tactbench::bench {

namespace {

constexpr int kUnreportedExit = 127 << 8;  // a wait status: exit code 127

std::vector<char*> pointers_to(std::vector<std::string>& arguments) {
  std::vector<char*> pointers;
  for (std::string& word : arguments) pointers.push_back(word.data());
  pointers.push_back(nullptr);
  return pointers;
}

struct ChildExec {
  pid_t parent;
  int output, complaint;  // complaint: a pipe that carries errno, and closes when the program starts
  bool ends_with_parent;
  char* const* arguments;
  char* const* environment;
};

// Between fork() and exec(): system calls only.
[[noreturn]] void become_child(const ChildExec& exec) {
  ::setpgid(0, 0);
  if (exec.ends_with_parent) {
    ::prctl(PR_SET_PDEATHSIG, SIGTERM);
    if (::getppid() != exec.parent) ::_exit(126);
  }
  for (const int number : {SIGINT, SIGTERM, SIGPIPE}) ::signal(number, SIG_DFL);
  sigset_t none;
  ::sigemptyset(&none);
  ::sigprocmask(SIG_SETMASK, &none, nullptr);
  bool ready = true;
  if (exec.output >= 0) {
    const int null = ::open("/dev/null", O_RDONLY | O_CLOEXEC);
    ready = null >= 0 && ::dup2(null, 0) >= 0 && ::dup2(exec.output, 1) >= 0 && ::dup2(exec.output, 2) >= 0;
  }
  if (ready) ::execve(exec.arguments[0], exec.arguments, exec.environment);
  const int why = errno;
  (void)!::write(exec.complaint, &why, sizeof why);
  ::_exit(127);
}

// Reads the pipe: errno when the program did not start, 0 when it did.
int complaint_in(int pipe_end) {
  int why = 0;
  ssize_t got = 0;
  while ((got = ::read(pipe_end, &why, sizeof why)) < 0 && errno == EINTR) {
  }
  return got == static_cast<ssize_t>(sizeof why) ? why : 0;
}

}  // namespace

std::vector<std::string> environment_with(std::vector<std::string> own) {
  const std::size_t count = own.size();
  for (char** entry = environ; *entry != nullptr; ++entry) {
    const std::string_view given(*entry);
    const auto replaces = [&](const std::string& one) { return given.starts_with(one.substr(0, one.find('=') + 1)); };
    if (std::none_of(own.begin(), own.begin() + static_cast<std::ptrdiff_t>(count), replaces)) own.emplace_back(given);
  }
  return own;
}

ChildProgram::ChildProgram(ChildStart start) {
  const std::vector<char*> arguments = pointers_to(start.arguments), environment = pointers_to(start.environment);
  int ends[2] = {-1, -1};
  int failed = ::pipe2(ends, O_CLOEXEC) == 0 ? 0 : errno;
  if (failed == 0) {
    const ChildExec exec{::getpid(),       start.output,      ends[1], start.ends_with_parent,
                         arguments.data(), environment.data()};
    process_ = ::fork();
    if (process_ == 0) become_child(exec);
    if (process_ < 0) failed = errno;
    ::close(ends[1]);
    if (failed == 0) failed = complaint_in(ends[0]);
    ::close(ends[0]);
  }
  if (start.output >= 0) ::close(start.output);
  if (failed == 0) return;
  if (process_ > 0) (void)wait();
  throw std::system_error(failed, std::generic_category(), start.arguments.front());
}

ChildProgram::~ChildProgram() {
  if (process_ < 0 || status_) return;
  kill_group();
  (void)wait();
}

ChildProgram::ChildProgram(ChildProgram&& other) noexcept
    : process_(std::exchange(other.process_, -1)), status_(other.status_) {}

ChildProgram& ChildProgram::operator=(ChildProgram&& other) noexcept {
  std::swap(process_, other.process_);
  std::swap(status_, other.status_);
  return *this;
}

std::optional<int> ChildProgram::ended() {
  if (status_ || process_ < 0) return status_;
  int status = 0;
  const pid_t got = ::waitpid(process_, &status, WNOHANG);
  if (got == process_) status_ = status;
  if (got < 0 && errno != EINTR) status_ = kUnreportedExit;
  return status_;
}

std::optional<int> ChildProgram::ended_by(std::chrono::steady_clock::time_point last) {
  while (!ended() && std::chrono::steady_clock::now() < last)
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  return status_;
}

int ChildProgram::wait() {
  while (!status_ && process_ > 0) {
    int status = 0;
    const pid_t got = ::waitpid(process_, &status, 0);
    if (got == process_) status_ = status;
    if (got < 0 && errno != EINTR) status_ = kUnreportedExit;
  }
  return status_.value_or(kUnreportedExit);
}

void ChildProgram::terminate() const {
  if (process_ > 0 && !status_) ::kill(process_, SIGTERM);
}

void ChildProgram::kill_group() const {
  if (process_ > 0) ::kill(-process_, SIGKILL);
}

}  // namespace tactbench::bench
