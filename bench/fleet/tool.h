// Short programs of others (sbatch, squeue): run to their end, what they print read.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace tactbench::bench {

// The file of a program in PATH; none: it is not there.
std::optional<std::string> find_program(const std::string& name);

struct ToolResult {
  int code = 0;      // 128 + n: ended by signal n; 124: it had not ended in time and was killed
  std::string said;  // on standard output and error, in the order written
};
// words[0]: its file. Throws Error TB-FLEET-TOOL when no process can be started.
ToolResult run_tool(const std::vector<std::string>& words, double limit_s);

std::string shell_word(const std::string& word);  // quoted for sh

}  // namespace tactbench::bench
