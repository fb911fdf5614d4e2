// Names that only one process at a time can hold on this machine, for all users and logins: abstract sockets of the
// kernel. Such a name needs no folder and no file, so no user can remove, replace or link it, and it disappears with
// its process. Any user can take a free name and so block a bench; the error then names that user. One network
// namespace is one machine: a container needs the host's (docker run --network host). TACTBENCH_RUNTIME_DIR names a
// folder of this user, closed to all others; programs with this setting use separate names: for tests and parallel
// simulated rigs, never for a real rig.
#pragma once

#include <string>
#include <vector>

namespace tactbench::bench {

class MachineName {
 public:
  MachineName() = default;
  // Takes a name such as "BENCH" or "BENCH/dead-man", if it is free, and listens there for connections. Throws Error
  // TB-BENCH-NAME if the system refuses, TB-FOLDER-UNSAFE for TACTBENCH_RUNTIME_DIR.
  explicit MachineName(const std::string& what);
  ~MachineName();
  MachineName(MachineName&& other) noexcept;
  MachineName& operator=(MachineName&&) = delete;
  [[nodiscard]] bool held() const { return descriptor_ >= 0; }
  [[nodiscard]] int descriptor() const { return descriptor_; }  // of the listening socket; it does not block
  [[nodiscard]] const std::string& text() const { return text_; }
  [[nodiscard]] std::string owner() const;  // the holder: "alice (pid 812)"

 private:
  std::string text_;
  int descriptor_ = -1;
};

// All names held within this scope, sorted, without their common prefix: "BENCH", "BENCH/dead-man".
std::vector<std::string> held_names();
// The name as the system lists it: "@tactbench/BENCH".
std::string shown_name(const std::string& what);

// A socket that connects to `what` without waiting, -1 and errno: ECONNREFUSED the name is free, EAGAIN the queue of
// its holder is full.
int connect_to_name(const std::string& what);

}  // namespace tactbench::bench
