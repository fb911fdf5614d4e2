// This program in a process of its own, for benchmarks of verbs.
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace tactbench::bench {

class OwnProgram {
 public:
  // `folder`: where it works. `program`: its file; empty: that of this process.
  explicit OwnProgram(std::string folder, std::string program = {})
      : folder_(std::move(folder)), program_(std::move(program)) {}
  // Throws std::runtime_error when it ends with another exit code than 0, 1 or 6, with what it said.
  void run(const std::vector<std::string>& words) const;
  [[nodiscard]] double best_seconds(int rounds, const std::vector<std::string>& words) const;  // wall clock

 private:
  std::string folder_, program_;
};

}  // namespace tactbench::bench
