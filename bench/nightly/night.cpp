#include "bench/nightly/night.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <filesystem>
#include <optional>
#include <system_error>
#include <thread>
#include <utility>

#include "analysis/counted.h"
#include "bench/common/child_process.h"
#include "bench/common/error.h"
#include "bench/common/output_file.h"
#include "bench/common/private_files.h"
#include "bench/common/stop_request.h"

namespace tactbench::bench {
namespace {

namespace fs = std::filesystem;
using NightClock = std::chrono::steady_clock;

constexpr std::chrono::seconds kWayOut{10};  // time that a scenario gets to end on request

struct Child {
  std::size_t scenario = 0;
  ChildProgram program;
  NightClock::time_point begun;
  bool killed = false;
};

// A scenario's output without the heading that the night wrote.
std::string scenario_log_text(const fs::path& log) {
  const std::string text = file_text(log);
  return text.starts_with(kScenarioLogHead) ? text.substr(text.find('\n') + 1) : text;
}

void refuse_store_of_others(const std::string& path) {
  std::error_code missing;
  if (fs::file_size(path, missing) == 0 || missing || is_scenario_store(path)) return;
  throw Error("TB-FILE-STORE", "a file of this name exists that is not a store of a night; it is never removed", path,
              "name another folder with --stores");
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
      if (options_.signals != nullptr && options_.signals->signal() != 0) stop(options_.signals->signal());
    }
    return in_order();
  }

 private:
  // If no process can monitor them, all scenarios and the night are ended.
  [[noreturn]] void stop(int signal) {
    for (const Child& child : children_) child.program.terminate();
    const auto last = NightClock::now() + kWayOut;
    for (Child& child : children_)
      if (!child.program.ended_by(last)) child.program.kill_group();
    children_.clear();
    const auto done = std::ranges::count_if(results_, [](const auto& result) { return result.has_value(); });
    throw Error("TB-NIGHTLY-STOPPED",
                fmt::format("the night was ended by {} after {} of {}", signal_text(signal), done,
                            analysis::counted(results_.size(), "scenario")),
                suite_.file)
        .by_signal(signal);
  }

  [[nodiscard]] fs::path file(std::size_t scenario, const char* ending) const {
    return fs::path(options_.stores) / (suite_.scenarios[scenario].label + ending);
  }

  // A private folder of the night.
  [[nodiscard]] fs::path result_file(std::size_t scenario) const {
    return fs::path(scope_.path()) / (suite_.scenarios[scenario].label + ".json");
  }

  void start(std::size_t scenario) {
    for (const char* ending : {".db", ".db-wal", ".db-shm", ".db-lock"}) fs::remove(file(scenario, ending));
    const Scenario& own = suite_.scenarios[scenario];
    ChildStart child;
    child.arguments = {options_.program.empty() ? fs::read_symlink("/proc/self/exe").string() : options_.program,
                       "nightly",
                       suite_.file,
                       "--only",
                       own.name,
                       "--seed",
                       std::to_string(own.seed),
                       "--db",
                       file(scenario, ".db").string(),
                       "--result",
                       result_file(scenario).string()};
    // Scenarios use separate names: commands to live runs do not reach them.
    child.environment = environment_with({"TACTBENCH_RUNTIME_DIR=" + scope_.path()});
    child.ends_with_parent = true;
    const std::string program = child.arguments.front(), log = file(scenario, ".log").string();
    child.output = ::open(log.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_NOFOLLOW | O_CLOEXEC, 0644);
    if (child.output < 0)
      throw Error("TB-FILE-WRITE", fmt::format("cannot write the file: {}", std::strerror(errno)), log,
                  "check folder, space and permissions; a link is not followed");
    const std::string head =
        fmt::format("{}{}\n", kScenarioLogHead, own.label);  // by which the next night recognises it
    (void)!::write(child.output, head.data(), head.size());
    try {
      children_.push_back({scenario, ChildProgram(std::move(child)), NightClock::now(), false});
    } catch (const std::system_error& error) {
      throw Error("TB-NIGHTLY-SPAWN",
                  fmt::format("scenario {} could not be started: {}", own.label, error.code().message()), program);
    }
  }

  // A scenario that ended within a short wait, if any.
  std::optional<std::size_t> wait() {
    for (auto child = children_.begin(); child != children_.end(); ++child) {
      if (const std::optional<int> status = child->program.ended()) {
        const std::size_t scenario = child->scenario;
        collect(*child, *status);
        children_.erase(child);
        return scenario;
      }
      if (!child->killed && NightClock::now() - child->begun > std::chrono::duration<double>(options_.limit_s)) {
        child->killed = true;
        child->program.kill_group();
      }
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    return std::nullopt;
  }

  void collect(const Child& child, int status) {
    const Scenario& own = suite_.scenarios[child.scenario];
    const fs::path json = result_file(child.scenario);
    ScenarioResult result;
    try {
      result = result_from_json(file_text(json));
      result.name = own.label;
    } catch (const std::invalid_argument&) {
      result.name = own.label;
      result.about = own.about;
      result.seconds = std::chrono::duration<double>(NightClock::now() - child.begun).count();
      const std::string how = WIFSIGNALED(status) ? fmt::format("signal {}", WTERMSIG(status))
                                                  : fmt::format("exit code {}", WEXITSTATUS(status));
      result.wrong = {child.killed ? fmt::format("it had not ended after {:.0f} s and was killed", options_.limit_s)
                                   : fmt::format("its process ended with {} and without a result", how),
                      scenario_log_text(file(child.scenario, ".log"))};
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
  const ScratchFolder scope_{"tactbench-night"};
  std::vector<Child> children_;
  std::vector<std::optional<ScenarioResult>> results_;
};

}  // namespace

std::vector<ScenarioResult> carry_out_night(const Suite& suite, const NightOptions& options,
                                            const std::function<void(const std::vector<ScenarioResult>&)>& on_result) {
  fs::create_directories(options.stores);
  for (const Scenario& scenario : suite.scenarios) {
    const std::string name = (fs::path(options.stores) / scenario.label).string();
    check_output(name + ".log", kScenarioLogFile, options.replace);
    refuse_store_of_others(name + ".db");
  }
  return Night(suite, options).carry_out(on_result);
}

namespace {

// Escapes text for XML 1.0, which cannot represent most control characters.
std::string xml_text(const std::string& text) {
  std::string escaped;
  for (const char c : text) {
    if (c == '&')
      escaped += "&amp;";
    else if (c == '<')
      escaped += "&lt;";
    else if (c == '>')
      escaped += "&gt;";
    else if (c == '"')
      escaped += "&quot;";
    else if (static_cast<unsigned char>(c) < 0x20 && c != '\n' && c != '\t')
      escaped += '?';
    else
      escaped += c;
  }
  return escaped;
}

const ScenarioResult* result_of(const std::vector<ScenarioResult>& results, const Scenario& scenario) {
  const auto found = std::ranges::find(results, scenario.label, &ScenarioResult::name);
  return found == results.end() ? nullptr : &*found;
}

}  // namespace

std::string junit_xml(const Suite& suite, const std::vector<ScenarioResult>& results) {
  const auto red = std::ranges::count_if(results, [](const ScenarioResult& r) { return !r.wrong.empty(); });
  double seconds = 0.0;
  for (const ScenarioResult& result : results) seconds += result.seconds;
  std::string cases;
  for (const Scenario& scenario : suite.scenarios) {
    const ScenarioResult* result = result_of(results, scenario);
    cases += fmt::format("  <testcase classname=\"{}\" name=\"{}\" time=\"{:.3f}\"", xml_text(suite.name),
                         scenario.label, result == nullptr ? 0.0 : result->seconds);
    if (result == nullptr) {
      cases += "><error message=\"it did not run\"/></testcase>\n";
    } else if (result->wrong.empty() && result->remarks.empty()) {
      cases += "/>\n";
    } else if (result->wrong.empty()) {
      cases += fmt::format("><system-out>{}</system-out></testcase>\n",
                           xml_text(fmt::format("{}", fmt::join(result->remarks, "\n"))));
    } else {
      cases += fmt::format(">\n    <failure message=\"{}\">{}\n{}</failure>\n  </testcase>\n",
                           xml_text(result->wrong.front()), xml_text(scenario.about),
                           xml_text(fmt::format("{}", fmt::join(result->wrong, "\n"))));
    }
  }
  return fmt::format(
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuite name=\"{}\" tests=\"{}\" failures=\"{}\" errors=\"{}\" "
      "time=\"{:.3f}\">\n{}</testsuite>\n",
      xml_text(suite.name), suite.scenarios.size(), red, suite.scenarios.size() - results.size(), seconds, cases);
}

std::string metrics_text(const Suite& suite, const std::vector<ScenarioResult>& results) {
  std::string green =
      "# HELP tactbench_nightly_green 1 when a scenario gave the expected result.\n# TYPE tactbench_nightly_green "
      "gauge\n";
  std::string figures =
      "# HELP tactbench_nightly_figure Figure measured by a scenario; its name includes the unit.\n# TYPE "
      "tactbench_nightly_figure gauge\n";
  for (const Scenario& scenario : suite.scenarios) {
    const ScenarioResult* result = result_of(results, scenario);
    green += fmt::format("tactbench_nightly_green{{scenario=\"{}\"}} {}\n", scenario.label,
                         result != nullptr && result->wrong.empty() ? 1 : 0);
    if (result == nullptr) continue;
    for (const auto& [figure, value] : result->figures)
      figures +=
          fmt::format("tactbench_nightly_figure{{scenario=\"{}\",figure=\"{}\"}} {}\n", scenario.label, figure, value);
  }
  return green + figures;
}

}  // namespace tactbench::bench
