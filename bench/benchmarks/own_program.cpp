#include "bench/benchmarks/own_program.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <filesystem>
#include <stdexcept>

#include "bench/benchmarks/figure.h"
#include "bench/fleet/tool.h"

namespace tactbench::bench {

void OwnProgram::run(const std::vector<std::string>& words) const {
  const std::string program = program_.empty() ? std::filesystem::read_symlink("/proc/self/exe").string() : program_;
  std::string command = "cd " + shell_word(folder_) + " && exec " + shell_word(program);
  for (const std::string& word : words) command += fmt::format(" {}", shell_word(word));
  const ToolResult done = run_tool({"/bin/sh", "-c", command}, 3600.0);
  if (done.code != 0 && done.code != 1 && done.code != 6)
    throw std::runtime_error(
        fmt::format("tactbench {} ended with {}: {}", fmt::join(words, " "), done.code, done.said));
}

double OwnProgram::best_seconds(int rounds, const std::vector<std::string>& words) const {
  return tactbench::bench::best_seconds(rounds, [&] { run(words); });
}

}  // namespace tactbench::bench
