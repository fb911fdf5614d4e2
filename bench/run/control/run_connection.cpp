#include "bench/run/control/run_connection.h"

#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <utility>

#include "bench/run/control/locks.h"

namespace tactbench::bench {

RunConnection::RunConnection(std::string name, const std::string& words, const std::string& db)
    : name_(std::move(name)) {
  descriptor_ = connect_to_name(name_);
  if (descriptor_ < 0) return;
  const std::optional<Peer> server = peer_of(descriptor_);
  if (!server || (!is_trusted(*server, ::geteuid()) && !carries_out_run_of(*server, db))) {
    close();
    return;
  }
  server_ = *server;
  // A run that closes the connection immediately may have sent data before.
  (void)::send(descriptor_, words.data(), words.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
}

RunConnection::~RunConnection() { close(); }

void RunConnection::close() {
  if (descriptor_ >= 0) ::close(descriptor_);
  descriptor_ = -1;
}

std::optional<LiveRun> RunConnection::newest() {
  std::optional<LiveRun> newest;
  std::string last;
  std::array<char, 32768> bytes{};
  while (descriptor_ >= 0) {
    const ssize_t size = ::recv(descriptor_, bytes.data(), bytes.size(), MSG_DONTWAIT);
    if (size > 0) {
      last.assign(bytes.data(), static_cast<std::size_t>(size));
    } else if (size < 0 && errno == EINTR) {
      continue;
    } else if (size < 0 && errno == EAGAIN) {
      break;
    } else {
      close();
    }
  }
  if (!last.empty()) newest = read_answer(name_, server_, last);
  return newest;
}

}  // namespace tactbench::bench
