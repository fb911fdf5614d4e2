#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>

#include "bench/cli/session.h"
#include "bench/common/output_file.h"
#include "bench/config/config.h"
#include "bench/config/operator_profile.h"
#include "db/utf8.h"

namespace tactbench::bench {

namespace {

struct InitOptions {
  std::string folder = ".", operator_name;
  bool rig = false;
};

// For --operator. JSON's escapes are also TOML's.
std::string profile_text(const std::string& operator_name) {
  return fmt::format(
      "# What need not be typed with every verb, for the folder in which tactbench is started. The command line "
      "precedes\n"
      "# the environment (TACTBENCH_BENCH, TACTBENCH_DB, TACTBENCH_FLEET), and that precedes this file: tactbench "
      "config show "
      "--origin.\n"
      "bench = \"bench.toml\"        # --bench\n"
      "db = \"runs.db\"              # --db\n"
      "operator = {}               # --operator\n"
      "recipe = \"production\"       # of run and calibrate\n"
      "limits = \"limits.toml\"      # by which calibrate judges, and fit its held-out runs\n"
      "# units = \"kPa\"              # --units of what is printed: kPa, bar or psi\n",
      nlohmann::json(operator_name).dump());
}

void init(const InitOptions& options, const Session& session) {
  namespace fs = std::filesystem;
  const std::vector<std::pair<std::string, std::string>> files = {
      {options.rig ? "paper-rig.example.toml" : "simulated.toml", "bench.toml"},
      {"sensor.toml", "sensor.toml"},
      {"limits.toml", "limits.toml"},
      {"lab.toml", "lab.toml"}};
  std::vector<std::string> names;
  for (const auto& [shipped, name] : files) names.push_back(name);
  if (!options.operator_name.empty()) names.emplace_back(kProfileFile);
  for (const std::string& name : names) {
    const fs::path target = fs::path(options.folder) / name;
    if (fs::exists(target) && !session.replace) {
      throw Error(ExitCode::kUsage, "TB-FILE-EXISTS", fmt::format("'{}' exists already", target.string()),
                  target.string(), "give another folder, or --replace to overwrite it");
    }
    check_output(target.string(), "a file of tactbench init", session.replace);  // never over a store
  }
  nlohmann::ordered_json written = nlohmann::ordered_json::array();
  std::error_code failed;
  fs::create_directories(options.folder, failed);
  for (const auto& [shipped, name] : files) {
    const fs::path target = fs::path(options.folder) / name;
    // Not find_config(), which prefers a file of that name in the current folder: that may be the target.
    const fs::path source = fs::path(share_folder()) / "bench/config" / shipped;
    fs::copy_file(source, target, fs::copy_options::overwrite_existing, failed);
    if (failed) {
      throw Error(ExitCode::kUsage, "TB-FILE-WRITE", fmt::format("cannot write: {}", failed.message()), target.string(),
                  "check folder, space and permissions");
    }
    written.push_back(target.string());
  }
  if (!options.operator_name.empty()) {
    const std::string target = (fs::path(options.folder) / kProfileFile).string();
    write_output(target, profile_text(options.operator_name), session.replace);
    written.push_back(target);
  }
  if (session.json) {
    print_json("init", {{"files", written}});
    return;
  }
  for (const auto& file : written) tty::print("{}\n", file.get<std::string>());
  if (options.rig) {
    tty::print(
        "\nNext:  fill in bench.toml (serials, ports, certificates), then\n"
        "       tactbench devices check --bench {}/bench.toml\n",
        options.folder);
    return;
  }
  if (!options.operator_name.empty()) {
    tty::print("\nNext:  {}tactbench calibrate SERIAL\n",
               options.folder == "." ? std::string() : fmt::format("cd {}, then ", options.folder));
    return;
  }
  tty::print(
      "\nNext:  tactbench sensors add MY-SENSOR --type {0}/sensor.toml\n"
      "       tactbench run descending ascending --bench {0}/bench.toml --sensor MY-SENSOR --operator NAME\n",
      options.folder);
}

}  // namespace

void add_init(CLI::App& app, Session& session) {
  auto options = std::make_shared<InitOptions>();
  CLI::App* verb =
      app.add_subcommand("init", "write a commented bench.toml, sensor.toml, limits.toml and lab.toml to start from");
  verb->add_option("folder", options->folder, "where to")->capture_default_str();
  verb->add_option("--operator", options->operator_name,
                   "also write tactbench.toml, with this name: bench, store, operator, recipe and limits then need not "
                   "be typed")
      ->check([](const std::string& name) { return std::string(db::is_blank(name) ? "the name is empty" : ""); });
  verb->add_flag("--rig", options->rig, "bench.toml describes the paper's rig (hardware) instead of the simulated one");
  verb->add_flag("--replace,--force", session.replace, "overwrite existing files");
  verb->add_flag("--json", session.json, "one JSON document on standard output");
  verb->callback([options, &session] { init(*options, session); });
}

}  // namespace tactbench::bench
