// Checks that a branch is monotone. An overshoot within a rising branch starts a minor loop that no frame shows; this
// detects it if it lasts until a poll and is larger than the tolerance.
#pragma once

#include <optional>
#include <string>

namespace tactbench::bench {

// Thrown from a branch that must be repeated.
struct PathBroken {
  std::string what;
};

class BranchGuard {
 public:
  // The branch rises if `to` > `from`; if they are equal, any change beyond the tolerance breaks it.
  BranchGuard(double from, double to, double tolerance) : from_(from), to_(to), tolerance_(tolerance) {}
  // To be called with each measured value; returns what broke the branch, or nothing.
  [[nodiscard]] std::optional<std::string> see(double value);

 private:
  double from_, to_, tolerance_;
  std::optional<double> highest_, lowest_;
};

}  // namespace tactbench::bench
