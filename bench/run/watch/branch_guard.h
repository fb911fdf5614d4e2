// Watches that a branch goes one way. An overshoot that comes back inside a rising branch starts a minor loop that no
// frame shows; this sees it where it lasts for a poll and is larger than the tolerance.
#pragma once

#include <optional>
#include <string>

namespace tactbench::bench {

// Thrown out of a branch that has to be redone.
struct PathBroken {
  std::string what;
};

class BranchGuard {
 public:
  // Rising where `to` > `from`; where they are equal, any change beyond the tolerance breaks it.
  BranchGuard(double from, double to, double tolerance) : from_(from), to_(to), tolerance_(tolerance) {}
  // Each measured value in turn; what broke the branch, or nothing.
  [[nodiscard]] std::optional<std::string> see(double value);

 private:
  double from_, to_, tolerance_;
  std::optional<double> highest_, lowest_;
};

}  // namespace tactbench::bench
