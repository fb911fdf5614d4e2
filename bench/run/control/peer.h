// Who is at the other end of a local socket, as the kernel tells it, and who may command a run: root, the run's own
// user, and members of the group `tactbench`. The same may be believed when they say that they carry one out.
#pragma once

#include <sys/types.h>

#include <optional>
#include <string>

namespace tactbench::bench {

inline constexpr const char* kGroupName = "tactbench";

// Its number; none: the machine has no such group.
std::optional<gid_t> commanding_group();

struct Peer {
  pid_t process = 0;
  uid_t user = 0;
  bool in_group = false;
};

// Of a connected socket: of a client when it connected, of a server when it began to listen. None: not told.
std::optional<Peer> peer_of(int descriptor, std::optional<gid_t> group = commanding_group());

// Whether a process of user `own` may take words from that one, or believe its answers.
bool is_trusted(const Peer& peer, uid_t own);

// "alice (pid 812)"; "user 1003 (pid 812)" where /etc/passwd does not name the user: a server of names may take its
// time.
std::string peer_text(const Peer& peer);

}  // namespace tactbench::bench
