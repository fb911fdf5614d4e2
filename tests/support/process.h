// Runs a program and keeps what it printed; a private folder that goes when the test ends.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace tactbench::tests {

struct Finished {
  int code = -1;  // exit code; -signal when a signal ended it
  std::string out, err;
};

// Runs `program` with `arguments` in `folder`, standard input empty. With a signal, sends it `after_ms` after
// `when_file` has come to exist.
struct Signal {
  int number = 0;
  std::string when_file;
  int after_ms = 0;
};
Finished run_program(const std::string& program, const std::vector<std::string>& arguments, const std::string& folder,
                     const Signal& signal = {});

class TemporaryFolder {
 public:
  TemporaryFolder();
  ~TemporaryFolder();
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  [[nodiscard]] std::string path(const std::string& name = {}) const;

 private:
  std::filesystem::path folder_;
};

std::string read_file(const std::string& path);
void write_file(const std::string& path, const std::string& text);

}  // namespace tactbench::tests
