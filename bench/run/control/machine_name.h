// Names that one process at a time can hold on this machine, whoever it belongs to and however it logged in: abstract
// sockets of the kernel. Such a name needs no folder and no file, so that nobody can remove, replace or link it, and it
// goes with the process that holds it. Any user can take a free one and so keep a bench from being used; who did is
// told. One network namespace is one machine: a container needs the host's (docker run --network host).
//
// TACTBENCH_RUNTIME_DIR names a folder of this user, closed to all others, whose programs stand apart from the
// machine's: for tests and simulated rigs beside each other, never for a rig that is real.
#pragma once

#include <string>
#include <vector>

namespace tactbench::bench {

class MachineName {
 public:
  MachineName() = default;
  // Takes "BENCH", "BENCH/dead-man" or the like, if nobody has it, and listens there for connections. Throws Error
  // TB-BENCH-NAME where the system gives none, TB-FOLDER-UNSAFE for TACTBENCH_RUNTIME_DIR.
  explicit MachineName(const std::string& what);
  ~MachineName();
  MachineName(MachineName&& other) noexcept;
  MachineName& operator=(MachineName&&) = delete;
  [[nodiscard]] bool held() const { return descriptor_ >= 0; }
  [[nodiscard]] int descriptor() const { return descriptor_; }  // of the listening socket; it does not block
  [[nodiscard]] const std::string& text() const { return text_; }
  [[nodiscard]] std::string owner() const;  // who has it: "alice (pid 812)"

 private:
  std::string text_;
  int descriptor_ = -1;
};

// All that is held within this scope, sorted, without the part that all share: "BENCH", "BENCH/dead-man".
std::vector<std::string> held_names();
// As the system lists it: "@tactbench/BENCH".
std::string shown_name(const std::string& what);

// A socket that connects to `what` without waiting, -1 and errno: ECONNREFUSED nobody has it, EAGAIN its holder does
// not take connections and no more can wait.
int connect_to_name(const std::string& what);

}  // namespace tactbench::bench
