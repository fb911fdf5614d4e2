// A verb carried out in the process of the test: quick, and a fault in it is the test's own. `call` of
// tests/support/process.h starts the program instead.
#pragma once

#include <fcntl.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <string>
#include <vector>

#include "bench/cli/session.h"
#include "tests/support/process.h"

namespace tactbench::tests {

// What is written to a stream of the process within its scope.
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

// What `print` prints on standard output. No assertion belongs into it.
template <class Print>
std::string printed_by(const Print& print) {
  Captured out(stdout);
  print();
  return out.text();
}

using AddVerb = void (*)(CLI::App&, bench::Session&);

// The verb that `add` adds, with its name first. An error stands in `err` as the program prints it.
inline Finished verb_here(AddVerb add, std::vector<std::string> words) {
  bench::Session session;
  CLI::App app("of a test", "tactbench");
  app.require_subcommand(1);
  add(app, session);
  std::ranges::reverse(words);
  Finished finished;
  Captured out(stdout), err(stderr);
  std::string error;
  try {
    app.parse(words);
    finished.code = static_cast<int>(session.code);
  } catch (const CLI::ParseError& refused) {
    finished.code = static_cast<int>(bench::ExitCode::kUsage);
    error = std::string("parse: ") + refused.what() + "\n";
  } catch (...) {
    const bench::Error thrown = bench::as_error(std::current_exception());
    finished.code = static_cast<int>(thrown.code());
    error = bench::error_text(thrown, false);
  }
  finished.out = out.text();
  finished.err = err.text() + error;
  return finished;
}

}  // namespace tactbench::tests
