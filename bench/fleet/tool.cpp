#include "bench/fleet/tool.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <sstream>
#include <system_error>

#include "bench/common/child_process.h"
#include "bench/common/error.h"
#include "bench/common/file_text.h"
#include "bench/common/private_files.h"

namespace tactbench::bench {

std::optional<std::string> find_program(const std::string& name) {
  const char* const path = std::getenv("PATH");
  std::istringstream folders(path == nullptr ? "/usr/bin:/bin" : path);
  for (std::string folder; std::getline(folders, folder, ':');) {
    const std::string file = (std::filesystem::path(folder.empty() ? "." : folder) / name).string();
    if (::access(file.c_str(), X_OK) == 0 && std::filesystem::is_regular_file(file)) return file;
  }
  return std::nullopt;
}

ToolResult run_tool(const std::vector<std::string>& words, double limit_s) {
  const ScratchFolder scratch("tactbench-tool");
  const std::string output = scratch.path() + "/output";
  ChildStart start;
  start.words = words;
  start.environment = environment_with({});
  start.ends_with_us = true;
  start.output = ::open(output.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0600);
  try {
    ChildProgram program(std::move(start));
    const auto last =
        std::chrono::steady_clock::now() +
        std::chrono::duration_cast<std::chrono::steady_clock::duration>(std::chrono::duration<double>(limit_s));
    const std::optional<int> status = program.ended_by(last);
    if (!status) program.kill_group();
    const std::string said = file_text(output);
    if (!status) return {124, said};
    return {WIFSIGNALED(*status) ? 128 + WTERMSIG(*status) : WEXITSTATUS(*status), said};
  } catch (const std::system_error& error) {
    throw Error(ExitCode::kInternal, "TB-FLEET-TOOL",
                fmt::format("it could not be started: {}", error.code().message()), words.front(),
                "check the program, and the limits of processes and memory");
  }
}

std::string shell_word(const std::string& word) {
  std::string quoted = "'";
  for (const char c : word) quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return quoted + "'";
}

}  // namespace tactbench::bench
