// Runs a verb within the test's process: fast, and a fault in it is the test's own. `call` of tests/support/process.h
// starts the program instead.
#pragma once

#include <fcntl.h>
#include <unistd.h>

#include <cstdio>
#include <string>
#include <vector>

#include "bench/cli/session.h"
#include "tests/bench/cli/check_refusal.h"
#include "tests/support/process.h"

namespace tactbench::tests {

// Text written to a stream of the process within the object's scope.
class Captured {
 public:
  explicit Captured(std::FILE* stream) : stream_(stream) {
    std::fflush(stream_);
    kept_ = ::dup(::fileno(stream_));
    const int file = ::open(folder_.path("text").c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
    ::dup2(file, ::fileno(stream_));
    ::close(file);
  }
  ~Captured() { end(); }
  Captured(const Captured&) = delete;
  Captured& operator=(const Captured&) = delete;
  std::string text() {
    end();
    return read_file(folder_.path("text"));
  }

 private:
  void end() {
    if (kept_ < 0) return;
    std::fflush(stream_);
    ::dup2(kept_, ::fileno(stream_));
    ::close(kept_);
    kept_ = -1;
  }
  TemporaryFolder folder_;
  std::FILE* stream_;
  int kept_ = -1;
};

// Text that `print` prints on standard output. `print` must not contain assertions.
template <class Print>
std::string printed_by(const Print& print) {
  Captured out(stdout);
  print();
  return out.text();
}

using bench::AddVerb;

// The verb that `add` adds, with its name first. An error is in `err` as the program prints it.
Finished verb_here(AddVerb add, std::vector<std::string> words);

}  // namespace tactbench::tests
