// Runs a program and captures its output; a temporary folder that is removed when the test ends.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace tactbench::tests {

struct Finished {
  int code = -1;  // exit code; -signal when a signal ended it
  std::string out, err;
};

// Runs `program` with `arguments` in `folder`, standard input empty. Sends the signal, if any, as soon as `when`
// returns true; throws when it never does.
struct Signal {
  int number = 0;
  std::function<bool()> when;
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

// Runs the program under test (tests/support/paths.h) with these arguments in that folder.
Finished call(const TemporaryFolder& folder, const std::vector<std::string>& words);
// Two of them: `first` has to succeed, else its end is returned.
Finished call(const TemporaryFolder& folder, const std::vector<std::string>& first,
              const std::vector<std::string>& second);

std::string read_file(const std::string& path);
void write_file(const std::string& path, const std::string& text);

}  // namespace tactbench::tests
