// The process at the other end of a local socket, as reported by the kernel. A run may be commanded by root, the run's
// own user, and members of the group `tactbench`. The same users are trusted when they answer as a run; root trusts any
// other process only if it carries out a run of the store that it names (locks.h).
#pragma once

#include <sys/types.h>

#include <optional>
#include <string>

namespace tactbench::bench {

inline constexpr const char* kGroupName = "tactbench";

// The group's number; none: the machine has no such group.
std::optional<gid_t> commanding_group();

struct Peer {
  pid_t process = 0;
  uid_t user = 0;
  bool in_group = false;
};

// The peer of a connected socket: the client at the time it connected, or the server at the time it began to listen.
// None: not known.
std::optional<Peer> peer_of(int descriptor, std::optional<gid_t> group = commanding_group());

// Whether a process of user `own` may accept commands from the peer, or trust its answers.
bool is_trusted(const Peer& peer, uid_t own);

// "alice (pid 812)"; "user 1003 (pid 812)" if /etc/passwd does not have the user: name servers may be slow and are not
// queried.
std::string peer_text(const Peer& peer);

}  // namespace tactbench::bench
