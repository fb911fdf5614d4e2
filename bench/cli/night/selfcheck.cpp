// selfcheck: a software-validation record made by the installed program on the user's machine.
#include "bench/cli/night/selfcheck.h"

#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <system_error>

#include "analysis/compensate/frame_compensator.h"
#include "analysis/identify/elam/lanes.h"
#include "analysis/json_io.h"
#include "bench/cli/session.h"
#include "bench/common/build_info.h"
#include "bench/common/output_file.h"
#include "bench/common/utc.h"
#include "bench/config/config.h"
#include "bench/selfcheck/selfcheck.h"
#include "db/run_store.h"

namespace tactbench::bench {

namespace {

// In the store's folder, where the program will write.
class SelfcheckFolder {
 public:
  explicit SelfcheckFolder(const std::string& store)
      : path_((std::filesystem::absolute(store).parent_path() / fmt::format(".tactbench-selfcheck-{}", ::getpid()))
                  .string()) {
    std::error_code failed;
    if (!std::filesystem::create_directory(path_, failed) || failed) {
      throw Error(ExitCode::kUsage, "TB-FILE-WRITE",
                  fmt::format("cannot make the folder {}: {}", path_, failed.message()), "--db " + store,
                  "name a store in a writable folder");
    }
  }
  ~SelfcheckFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  SelfcheckFolder(const SelfcheckFolder&) = delete;
  SelfcheckFolder& operator=(const SelfcheckFolder&) = delete;
  [[nodiscard]] const std::string& path() const { return path_; }

 private:
  std::string path_;
};

nlohmann::ordered_json selfcheck_facts() {
  nlohmann::ordered_json libraries;
  for (const auto& [name, version] : library_versions()) libraries[name] = version;
  return {{"program_version", build_info().version},
          {"git_commit", build_info().commit},
          {"modified", build_info().modified},
          {"build", build_info().build},
          {"identification_lanes", analysis::to_string(analysis::lane_dispatch())},
          {"compensator_dispatch", analysis::to_string(analysis::best_dispatch())},
          {"shipped_files", share_folder()},
          {"libraries", libraries}};
}

nlohmann::ordered_json selfcheck_record(const std::string& store) {
  const std::string date = utc_now();
  const auto start = std::chrono::steady_clock::now();
  const SelfcheckFolder folder(store);
  SelfcheckLines lines;
  const auto take = [&](const SelfcheckLines& more) { lines.insert(lines.end(), more.begin(), more.end()); };
  take(check_clocks());
  take(check_store(folder.path()));  // before any thread is started: it forks
  take(check_known_fits());
  take(check_round_trips());
  take(check_dispatch_levels());
  take(check_compensator());
  take(check_simulated_run(folder.path()));
  nlohmann::ordered_json record = {{"schema", "tactbench.selfcheck"}, {"version", 1}, {"date_utc", date}};
  record.update(selfcheck_facts());
  auto list = nlohmann::ordered_json::array();
  for (const SelfcheckLine& line : lines) {
    list.push_back({{"area", line.area},
                    {"checked", line.what},
                    {"expected", line.expected},
                    {"found", line.found},
                    {"pass", line.pass}});
  }
  record["checks"] = list;
  record["failed"] = std::ranges::count_if(lines, [](const SelfcheckLine& line) { return !line.pass; });
  record["seconds"] = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  record["sha256"] = db::sha256_hex(analysis::printable_json(record));
  return record;
}

void selfcheck(const std::string& output, Session& session) {
  const bool as_json = output.ends_with(".json");
  if (!output.empty())
    check_output(output, as_json ? "a tactbench.selfcheck document (JSON)" : "a record of tactbench selfcheck",
                 session.replace);
  const nlohmann::ordered_json record = selfcheck_record(session.db);
  const std::string json = analysis::printable_json(record, 2) + "\n";
  if (!output.empty()) write_output(output, as_json ? json : selfcheck_text(record), session.replace);
  tty::print("{}", session.json ? json : selfcheck_text(record));
  if (record["failed"].get<int>() > 0) session.code = ExitCode::kCriterionFailed;
}

}  // namespace

std::string selfcheck_text(const nlohmann::ordered_json& record) {
  const auto word = [&](const char* key) { return record[key].get<std::string>(); };
  std::string text = fmt::format(
      "tactbench selfcheck, {}\nversion {}, commit {}{}; {}\nidentification on {}, compensator on {}\nshipped files: "
      "{}\nlibraries:",
      word("date_utc"), word("program_version"), word("git_commit"), record["modified"].get<bool>() ? ", modified" : "",
      word("build"), word("identification_lanes"), word("compensator_dispatch"), word("shipped_files"));
  for (const auto& [name, version] : record["libraries"].items())
    text += fmt::format(" {} {}", name, version.get<std::string>());
  text += "\n\n";
  for (const auto& line : record["checks"]) {
    text +=
        fmt::format("{}  {}: {}\n      expected: {}\n      found:    {}\n", line["pass"].get<bool>() ? "pass" : "FAIL",
                    line["area"].get<std::string>(), line["checked"].get<std::string>(),
                    line["expected"].get<std::string>(), line["found"].get<std::string>());
  }
  return text + fmt::format("\n{} checks, {} failed, {:.1f} s\nsha256 {}\n", record["checks"].size(),
                            record["failed"].get<int>(), record["seconds"].get<double>(), word("sha256"));
}

void add_selfcheck(CLI::App& app, Session& session) {
  auto output = std::make_shared<std::string>();
  CLI::App* verb = app.add_subcommand(
      "selfcheck", "a software-validation record of this program on this machine: known answers recomputed");
  verb->add_option("-o,--output", *output, "also write the record here: JSON if it ends in .json, text otherwise");
  add_replace(*verb, session);
  verb->footer(
      "Exit codes: 0 all checks pass, 1 one failed. sha256 is that of the JSON document without it, without line "
      "breaks "
      "and blanks.");
  add_common(*verb, session);
  verb->callback([output, &session] { selfcheck(*output, session); });
}

}  // namespace tactbench::bench
