#include "bench/run/control/peer.h"

#include <fmt/format.h>
#include <grp.h>
#include <pwd.h>
#include <sys/socket.h>

#include <algorithm>
#include <cstdio>
#include <memory>
#include <vector>

namespace tactbench::bench {

namespace {
constexpr std::size_t kEntry = 1 << 16;  // bytes of a line of a database
}

std::optional<gid_t> commanding_group() {
  std::vector<char> text(kEntry);
  group entry{};
  group* found = nullptr;
  if (::getgrnam_r(kGroupName, &entry, text.data(), text.size(), &found) != 0 || found == nullptr) return std::nullopt;
  return found->gr_gid;
}

std::optional<Peer> peer_of(int descriptor, std::optional<gid_t> group) {
  ucred told{};
  socklen_t size = sizeof(told);
  if (::getsockopt(descriptor, SOL_SOCKET, SO_PEERCRED, &told, &size) != 0 || told.pid < 0) return std::nullopt;
  Peer peer{told.pid, told.uid, group && told.gid == *group};
  if (!group || peer.in_group) return peer;
  // The groups of the process itself, not those of its user in the user database: the process may have dropped them, or
  // may have logged in before it was added.
  std::vector<gid_t> groups(64);
  for (int turn = 0; turn < 2; ++turn) {
    size = static_cast<socklen_t>(groups.size() * sizeof(gid_t));
    const bool got_all = ::getsockopt(descriptor, SOL_SOCKET, SO_PEERGROUPS, groups.data(), &size) == 0;
    groups.resize(size / sizeof(gid_t));
    if (!got_all) continue;  // too many: `size` holds their number
    peer.in_group = std::find(groups.begin(), groups.end(), *group) != groups.end();
    break;
  }
  return peer;
}

bool is_trusted(const Peer& peer, uid_t own) { return peer.user == 0 || peer.user == own || peer.in_group; }

std::string peer_text(const Peer& peer) {
  std::string name = fmt::format("user {}", peer.user);
  std::vector<char> text(kEntry);
  if (const std::unique_ptr<FILE, int (*)(FILE*)> users(std::fopen("/etc/passwd", "re"), std::fclose); users) {
    passwd entry{};
    passwd* found = nullptr;
    while (::fgetpwent_r(users.get(), &entry, text.data(), text.size(), &found) == 0) {
      if (entry.pw_uid != peer.user) continue;
      name = entry.pw_name;
      break;
    }
  }
  return fmt::format("{} (pid {})", name, peer.process);
}

}  // namespace tactbench::bench
