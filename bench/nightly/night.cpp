#include "bench/nightly/night.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>

#include <algorithm>
#include <chrono>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <optional>
#include <thread>

#include "bench/error.h"

extern char** environ;

namespace tactbench::bench {
namespace {

namespace fs = std::filesystem;
using NightClock = std::chrono::steady_clock;

struct Child {
  std::size_t scenario = 0;
  pid_t process = -1;
  NightClock::time_point begun;
  bool killed = false;
};

std::string whole_text(const fs::path& path) {
  std::ifstream file(path);
  return {std::istreambuf_iterator<char>(file), {}};
}

class Night {
 public:
  Night(const Suite& suite, const NightOptions& options)
      : suite_(suite), options_(options), results_(suite.scenarios.size()) {}

  std::vector<ScenarioResult> carry_out(const std::function<void(const std::vector<ScenarioResult>&)>& on_result) {
    bool red = false;
    for (std::size_t next = 0; next < suite_.scenarios.size() || !children_.empty();) {
      const bool more = next < suite_.scenarios.size() && !(red && options_.stop_on_red);
      if (more && children_.size() < static_cast<std::size_t>(options_.jobs)) {
        start(next++);
        continue;
      }
      if (!more && children_.empty()) break;
      if (const std::optional<std::size_t> done = wait()) {
        red = red || !results_[*done]->wrong.empty();
        on_result(in_order());
      }
    }
    return in_order();
  }

 private:
  [[nodiscard]] fs::path file(std::size_t scenario, const char* ending) const {
    return fs::path(options_.stores) / (suite_.scenarios[scenario].label + ending);
  }

  void start(std::size_t scenario) {
    for (const char* ending : {".db", ".db-wal", ".db-shm", ".json"}) fs::remove(file(scenario, ending));
    const Scenario& own = suite_.scenarios[scenario];
    std::vector<std::string> words = {
        options_.program.empty() ? fs::read_symlink("/proc/self/exe").string() : options_.program,
        "nightly",
        suite_.file,
        "--only",
        own.name,
        "--seed",
        std::to_string(own.seed),
        "--db",
        file(scenario, ".db").string(),
        "--result",
        file(scenario, ".json").string()};
    std::vector<char*> pointers;
    for (std::string& word : words) pointers.push_back(word.data());
    pointers.push_back(nullptr);
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_addopen(&actions, 0, "/dev/null", O_RDONLY, 0);
    posix_spawn_file_actions_addopen(&actions, 1, file(scenario, ".log").c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644);
    posix_spawn_file_actions_adddup2(&actions, 1, 2);
    Child child{scenario, -1, NightClock::now(), false};
    const int failed = posix_spawn(&child.process, words.front().c_str(), &actions, nullptr, pointers.data(), environ);
    posix_spawn_file_actions_destroy(&actions);
    if (failed != 0)
      throw Error(ExitCode::kInternal, "TB-NIGHTLY-SPAWN",
                  fmt::format("scenario {} could not be started: {}", own.label, std::strerror(failed)), words.front(),
                  "look at the limits of processes and memory");
    children_.push_back(child);
  }

  // The scenario that ended, if one did within a short while.
  std::optional<std::size_t> wait() {
    for (auto child = children_.begin(); child != children_.end(); ++child) {
      int status = 0;
      if (waitpid(child->process, &status, WNOHANG) == child->process) {
        const Child ended = *child;
        children_.erase(child);
        collect(ended, status);
        return ended.scenario;
      }
      if (!child->killed && NightClock::now() - child->begun > std::chrono::duration<double>(options_.limit_s)) {
        child->killed = true;
        ::kill(child->process, SIGKILL);
      }
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    return std::nullopt;
  }

  void collect(const Child& child, int status) {
    const Scenario& own = suite_.scenarios[child.scenario];
    const fs::path json = file(child.scenario, ".json");
    ScenarioResult result;
    try {
      result = result_from_json(whole_text(json));
      result.name = own.label;
    } catch (const std::invalid_argument&) {
      result.name = own.label;
      result.about = own.about;
      result.seconds = std::chrono::duration<double>(NightClock::now() - child.begun).count();
      const std::string how = WIFSIGNALED(status) ? fmt::format("signal {}", WTERMSIG(status))
                                                  : fmt::format("exit code {}", WEXITSTATUS(status));
      result.wrong = {child.killed ? fmt::format("it had not ended after {:.0f} s and was killed", options_.limit_s)
                                   : fmt::format("its process ended with {} and left no result", how),
                      whole_text(file(child.scenario, ".log"))};
    }
    fs::remove(json);
    results_[child.scenario] = std::move(result);
  }

  [[nodiscard]] std::vector<ScenarioResult> in_order() const {
    std::vector<ScenarioResult> results;
    for (const std::optional<ScenarioResult>& result : results_)
      if (result) results.push_back(*result);
    return results;
  }

  const Suite& suite_;
  const NightOptions& options_;
  std::vector<Child> children_;
  std::vector<std::optional<ScenarioResult>> results_;
};

}  // namespace

std::vector<ScenarioResult> carry_out_night(const Suite& suite, const NightOptions& options,
                                            const std::function<void(const std::vector<ScenarioResult>&)>& on_result) {
  fs::create_directories(options.stores);
  return Night(suite, options).carry_out(on_result);
}

}  // namespace tactbench::bench
