#include "bench/common/standard_streams.h"

#include <fcntl.h>
#include <poll.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstdio>

namespace tactbench::bench {

namespace {

constexpr int kPatienceMs = 200;  // wait for a reader of stderr, once; much less than a dead-man's timeout

std::atomic<bool> output_lost{false}, error_stalls{false};

// A pager or a stopped terminal (Ctrl-S) must not delay a process that drives devices.
bool stderr_is_writable() {
  pollfd stream{STDERR_FILENO, POLLOUT, 0};
  const bool ready = ::poll(&stream, 1, error_stalls ? 0 : kPatienceMs) > 0;
  error_stalls = !ready;
  return ready;
}

// The cookie points to the descriptor. Always reports that all was written.
ssize_t write_or_drop(void* cookie, const char* bytes, std::size_t size) {
  const int descriptor = *static_cast<const int*>(cookie);
  const int before = errno;
  for (std::size_t done = 0; done < size;) {
    if (descriptor == STDERR_FILENO && !stderr_is_writable()) break;
    const ssize_t wrote = ::write(descriptor, bytes + done, size - done);
    if (wrote < 0 && errno == EINTR) continue;
    if (wrote <= 0) {
      output_lost = output_lost || descriptor == STDOUT_FILENO;
      break;
    }
    done += static_cast<std::size_t>(wrote);
  }
  errno = before;
  return static_cast<ssize_t>(size);
}

std::FILE* stream_on(int& descriptor, int buffering) {
  cookie_io_functions_t functions{};
  functions.write = write_or_drop;
  std::FILE* stream = ::fopencookie(&descriptor, "w", functions);
  if (stream != nullptr) (void)std::setvbuf(stream, nullptr, buffering, BUFSIZ);
  return stream;
}

}  // namespace

void open_standard_descriptors() {
  for (const int descriptor : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
    if (::fcntl(descriptor, F_GETFD) < 0 && errno == EBADF)
      (void)::open("/dev/null", O_RDWR);  // the lowest that is free
  }
}

void drop_unwritable_output() {
  (void)std::signal(SIGPIPE, SIG_IGN);
  (void)std::signal(SIGXFSZ, SIG_IGN);  // a file that may not grow is an error of its writer, not a signal
  (void)std::fflush(stdout);
  static int output = STDOUT_FILENO, errors = STDERR_FILENO;
  if (std::FILE* out = stream_on(output, ::isatty(output) != 0 ? _IOLBF : _IOFBF)) stdout = out;
  if (std::FILE* error = stream_on(errors, _IONBF)) stderr = error;
}

bool output_is_lost() { return output_lost; }

}  // namespace tactbench::bench
