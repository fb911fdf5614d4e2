#include "bench/run/control/machine_name.h"

#include <fmt/format.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstddef>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <utility>

#include "bench/common/error.h"
#include "bench/common/private_files.h"
#include "bench/run/control/peer.h"
#include "db/run_store.h"

namespace tactbench::bench {

namespace {

constexpr int kMostWaiting = 64;  // connections that may wait to be taken

std::string scope_prefix() {
  const char* folder = std::getenv("TACTBENCH_RUNTIME_DIR");
  if (folder == nullptr || *folder == '\0') return "tactbench/";
  check_private_folder(folder);
  const std::string path = std::filesystem::canonical(folder).string();
  return "tactbench:" + db::sha256_hex(path).substr(0, 16) + "/";
}

struct AbstractAddress {
  sockaddr_un address{};
  socklen_t size = 0;
  [[nodiscard]] const sockaddr* get() const { return reinterpret_cast<const sockaddr*>(&address); }
};

AbstractAddress abstract_address(const std::string& text) {
  AbstractAddress made;
  made.address.sun_family = AF_UNIX;  // sun_path[0] stays 0: abstract
  if (text.size() >= sizeof(made.address.sun_path)) {
    throw Error("TB-BENCH-NAME", "the name is too long for the system", text);
  }
  std::memcpy(made.address.sun_path + 1, text.data(), text.size());
  made.size = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + 1 + text.size());
  return made;
}

int new_socket() { return ::socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC | SOCK_NONBLOCK, 0); }

}  // namespace

MachineName::MachineName(const std::string& what) : text_(what) {
  const AbstractAddress wanted = abstract_address(scope_prefix() + what);
  descriptor_ = new_socket();
  const bool bound = descriptor_ >= 0 && ::bind(descriptor_, wanted.get(), wanted.size) == 0;
  if (bound && ::listen(descriptor_, kMostWaiting) == 0) return;
  const int why = errno;
  if (descriptor_ >= 0) ::close(descriptor_);
  descriptor_ = -1;
  if (why == EADDRINUSE) return;
  throw Error("TB-BENCH-NAME", fmt::format("the system refuses a socket: {}", std::strerror(why)), shown_name(what),
              "check the limits of open files (ulimit -n) and memory");
}

MachineName::~MachineName() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

MachineName::MachineName(MachineName&& other) noexcept
    : text_(std::move(other.text_)), descriptor_(std::exchange(other.descriptor_, -1)) {}

std::string MachineName::owner() const {
  const int descriptor = connect_to_name(text_);
  if (descriptor < 0) return errno == ECONNREFUSED ? "a process that has just ended" : "a process that does not answer";
  const std::optional<Peer> peer = peer_of(descriptor);
  ::close(descriptor);
  return peer ? peer_text(*peer) : "unknown";
}

std::vector<std::string> held_names() {
  const std::string prefix = fmt::format("@{}", scope_prefix());
  std::vector<std::string> names;
  std::ifstream table("/proc/net/unix");  // "slot: RefCount Protocol Flags Type St Inode Path"
  for (std::string line; std::getline(table, line);) {
    std::istringstream words(line);
    std::string slot, references, protocol, flags, type, state, inode, path;
    if (!(words >> slot >> references >> protocol >> flags >> type >> state >> inode >> path)) continue;
    const bool listens = flags == "00010000";  // not the accepted ones, which have the name, too
    if (listens && path.starts_with(prefix)) names.push_back(path.substr(prefix.size()));
  }
  std::sort(names.begin(), names.end());
  names.erase(std::unique(names.begin(), names.end()), names.end());
  return names;
}

std::string shown_name(const std::string& what) { return fmt::format("@{}{}", scope_prefix(), what); }

int connect_to_name(const std::string& what) {
  const AbstractAddress wanted = abstract_address(scope_prefix() + what);
  const int descriptor = new_socket();
  if (descriptor < 0) return -1;
  if (::connect(descriptor, wanted.get(), wanted.size) == 0) return descriptor;
  const int why = errno;
  ::close(descriptor);
  errno = why;
  return -1;
}

}  // namespace tactbench::bench
