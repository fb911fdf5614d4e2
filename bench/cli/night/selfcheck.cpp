// selfcheck: a software-validation record made by the installed program on the user's machine.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <memory>
#include <nlohmann/json.hpp>

#include "analysis/json_fields.h"
#include "analysis/json_io.h"
#include "bench/cli/session.h"
#include "bench/common/build_info.h"
#include "bench/common/output_file.h"
#include "bench/common/private_files.h"
#include "bench/common/utc.h"
#include "bench/config/config.h"
#include "bench/selfcheck/selfcheck.h"

namespace tactbench::bench {

namespace {

using nlohmann::ordered_json;

ordered_json selfcheck_record() {
  const auto start = std::chrono::steady_clock::now();
  ordered_json record = {{"schema", "tactbench.selfcheck"},
                         {"version", 1},
                         {"date_utc", utc_now()},
                         {"program_version", build_info().version},
                         {"git_commit", build_info().commit},
                         {"modified", build_info().modified},
                         {"build", build_info().build},
                         {"identification_lanes", processor_class()},
                         {"shipped_files", share_folder()}};
  for (const auto& [name, version] : library_versions()) record["libraries"][name] = version;
  const ScratchFolder folder("tactbench-selfcheck");
  SelfcheckLines lines = check_models();
  std::ranges::move(check_run(folder.path()), std::back_inserter(lines));
  for (const SelfcheckLine& line : lines)
    record["checks"].push_back({{"area", line.area}, {"checked", line.what}, JSON_FIELDS(line, expected, found, pass)});
  record["failed"] = std::ranges::count(lines, false, &SelfcheckLine::pass);
  record["seconds"] = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return record;
}

std::string text_of(const ordered_json& record) {
  const auto word = [](const ordered_json& value) { return value.get<std::string>(); };
  std::string text = fmt::format(
      "tactbench selfcheck, {}\nversion {}, commit {}{}; {}\nidentification on {}\nshipped files: "
      "{}\nlibraries:",
      word(record["date_utc"]), word(record["program_version"]), word(record["git_commit"]),
      record["modified"].get<bool>() ? ", modified" : "", word(record["build"]), word(record["identification_lanes"]),
      word(record["shipped_files"]));
  for (const auto& [name, version] : record["libraries"].items()) text += fmt::format(" {} {}", name, word(version));
  text += "\n\n";
  for (const ordered_json& line : record["checks"])
    text += fmt::format("{}  {}: {}\n      expected {}; found {}\n", line["pass"].get<bool>() ? "pass" : "FAIL",
                        word(line["area"]), word(line["checked"]), word(line["expected"]), word(line["found"]));
  return text + fmt::format("\n{} checks, {} failed, {:.1f} s\n", record["checks"].size(), record["failed"].get<int>(),
                            record["seconds"].get<double>());
}

void selfcheck(const std::string& output, Session& session) {
  const bool as_json = output.ends_with(".json");
  if (!output.empty())
    check_output(output, as_json ? "a tactbench.selfcheck document (JSON)" : "a record of tactbench selfcheck",
                 session.replace);
  const ordered_json record = selfcheck_record();
  const std::string json = analysis::printable_json(record, 2) + "\n", text = text_of(record);
  if (!output.empty()) write_output(output, as_json ? json : text, session.replace);
  tty::print("{}", session.json ? json : text);
  if (record["failed"].get<int>() > 0) session.code = ExitCode::kCriterionFailed;
}

}  // namespace

void add_selfcheck(CLI::App& app, Session& session) {
  auto output = std::make_shared<std::string>();
  CLI::App* verb = app.add_subcommand(
      "selfcheck", "recompute problems with known answers: a validation record of this program on this machine");
  verb->add_option("-o,--output", *output,
                   "also write the record to this file: JSON if its name ends in .json, text otherwise");
  add_replace(*verb, session);
  verb->footer("Exit codes: 0 all checks pass, 1 one failed.");
  verb->callback([output, &session] { selfcheck(*output, session); });
}

}  // namespace tactbench::bench
