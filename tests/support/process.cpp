#include "tests/support/process.h"

#include <fcntl.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <utility>

#include "tests/support/paths.h"

namespace tactbench::tests {

Finished run_program(const std::string& program, const std::vector<std::string>& arguments, const std::string& folder,
                     const Signal& signal) {
  const TemporaryFolder captured;
  const std::string out = captured.path("out");
  const std::string err = captured.path("err");
  std::vector<std::string> words = {program};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  const pid_t child = fork();
  if (child < 0) throw std::runtime_error("fork failed");
  if (child == 0) {
    const int null = open("/dev/null", O_RDONLY);
    const int out_fd = open(out.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
    const int err_fd = open(err.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
    if (chdir(folder.c_str()) != 0 || dup2(null, 0) < 0 || dup2(out_fd, 1) < 0 || dup2(err_fd, 2) < 0) _exit(126);
    execv(program.c_str(), argv.data());
    _exit(127);
  }
  if (signal.number != 0) {
    constexpr int kMostLooks = 30000;  // ends what hangs; a busy machine is no failure
    int looks = 0;
    while (!signal.when() && ++looks < kMostLooks) usleep(10000);
    if (looks == kMostLooks) {
      kill(child, SIGKILL);
      waitpid(child, nullptr, 0);
      throw std::runtime_error("the moment for the signal did not come; " + read_file(err));
    }
    kill(child, signal.number);
  }
  int status = 0;
  if (waitpid(child, &status, 0) != child) throw std::runtime_error("waitpid failed");
  Finished finished;
  finished.code = WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
  finished.out = read_file(out);
  finished.err = read_file(err);
  return finished;
}

TemporaryFolder::TemporaryFolder() {
  std::string pattern = (std::filesystem::temp_directory_path() / "tactbench-test-XXXXXX").string();
  if (mkdtemp(pattern.data()) == nullptr) throw std::runtime_error("cannot make " + pattern);
  folder_ = pattern;
}

TemporaryFolder::~TemporaryFolder() {
  std::error_code ignored;
  std::filesystem::remove_all(folder_, ignored);
}

std::string TemporaryFolder::path(const std::string& name) const {
  return name.empty() ? folder_.string() : (folder_ / name).string();
}

namespace {

// Trips, records, locks and control sockets of tests, and of the programs that they start, stay out of the user's own
// folders.
struct PrivateState {
  PrivateState() {
    setenv("XDG_STATE_HOME", folder.path().c_str(), 1);
    unsetenv("TACTBENCH_BENCH");  // the developer's
    unsetenv("TACTBENCH_DB");
    unsetenv("TACTBENCH_FLEET");
    setenv("TACTBENCH_RUNTIME_DIR", folder.path().c_str(), 1);  // tests that run beside each other share bench ids
  }
  TemporaryFolder folder;
};
const PrivateState kPrivateState;

}  // namespace

Finished call(const TemporaryFolder& folder, const std::vector<std::string>& words) {
  return run_program(program_path(), words, folder.path());
}

Finished call(const TemporaryFolder& folder, const std::vector<std::string>& first,
              const std::vector<std::string>& second) {
  const Finished done = call(folder, first);
  return done.code == 0 ? call(folder, second) : done;
}

std::string read_file(const std::string& path) {
  std::ifstream stream(path, std::ios::binary);
  if (!stream) throw std::runtime_error("cannot read " + path);
  std::ostringstream text;  // tests that wait for a line read again and again: the library's loop is optimized
  text << stream.rdbuf();
  return std::move(text).str();
}

void write_file(const std::string& path, const std::string& text) {
  std::ofstream stream(path, std::ios::binary);
  stream << text;
  if (!stream.flush()) throw std::runtime_error("cannot write " + path);
}

}  // namespace tactbench::tests
