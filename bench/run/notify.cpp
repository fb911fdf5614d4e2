#include "bench/run/notify.h"

#include <fmt/format.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>

#include <cstdio>
#include <cstring>
#include <thread>
#include <vector>

extern char** environ;

namespace tactbench::bench {

void Notify::tell(const std::string& event, std::int64_t run, const std::string& reason) const {
  if (command_.empty()) return;
  std::vector<std::string> environment = {"TACTBENCH_EVENT=" + event, fmt::format("TACTBENCH_RUN={}", run),
                                          "TACTBENCH_REASON=" + reason};
  for (char** entry = environ; *entry != nullptr; ++entry) environment.emplace_back(*entry);
  std::vector<char*> pointers;
  for (std::string& entry : environment) pointers.push_back(entry.data());
  pointers.push_back(nullptr);
  // In the background of a shell of its own, which ends at once: the command may take as long as it likes and is
  // nobody's child afterwards.
  std::string shell = "sh", option = "-c", line = "(" + command_ + "\n) </dev/null >&2 &";
  std::vector<char*> words = {shell.data(), option.data(), line.data(), nullptr};
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  sigset_t none, all;
  sigemptyset(&none);
  sigemptyset(&all);
  for (const int number : {SIGINT, SIGTERM, SIGPIPE}) sigaddset(&all, number);
  posix_spawnattr_setsigmask(&attributes, &none);
  posix_spawnattr_setsigdefault(&attributes, &all);
  posix_spawnattr_setpgroup(&attributes, 0);  // Ctrl-C in the terminal is not for it
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF | POSIX_SPAWN_SETPGROUP);
  pid_t child = -1;
  const int failed = posix_spawn(&child, "/bin/sh", nullptr, &attributes, words.data(), pointers.data());
  posix_spawnattr_destroy(&attributes);
  if (failed != 0) {
    fmt::print(stderr, "warning: --on-event could not be started: {}\n", std::strerror(failed));
    return;
  }
  while (waitpid(child, nullptr, 0) < 0 && errno == EINTR) {
  }
}

}  // namespace tactbench::bench
