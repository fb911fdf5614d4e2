#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>

#include "bench/cli/rig/key_pages.h"
#include "bench/cli/session.h"
#include "bench/common/output_file.h"
#include "bench/config/config.h"
#include "bench/config/config_laboratory.h"
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
      "config --origin.\n"
      "bench = \"bench.toml\"\ndb = \"runs.db\"\noperator = {}\nrecipe = \"production\"\n"
      "limits = \"limits.toml\"\nlab = \"lab.toml\"\n# units = \"kPa\"\n",
      nlohmann::json(operator_name).dump());
}

struct StarterFile {
  const char *shipped, *name;
  std::vector<sequences::KeyFacts> (*keys)();
};

void init(const InitOptions& options, const Session& session) {
  namespace fs = std::filesystem;
  const std::vector<StarterFile> files = {
      {options.rig ? "paper-rig.example.toml" : "simulated.toml", "bench.toml", bench_keys},
      {"sensor.toml", "sensor.toml", sensor_type_keys},
      {"limits.toml", "limits.toml", limits_keys},
      {"lab.toml", "lab.toml", laboratory_keys}};
  std::vector<std::string> names;
  for (const StarterFile& file : files) names.emplace_back(file.name);
  if (!options.operator_name.empty()) names.emplace_back(kProfileFile);
  for (const std::string& name : names) {
    const fs::path target = fs::path(options.folder) / name;
    if (fs::exists(target) && !session.replace) {
      throw Error("TB-FILE-EXISTS", fmt::format("'{}' exists already", target.string()), target.string(),
                  "give another folder, or --replace to overwrite it");
    }
    check_output(target.string(), "a file of tactbench init", session.replace);  // never over a store
  }
  nlohmann::ordered_json written = nlohmann::ordered_json::array();
  std::error_code failed;  // then writing fails, too
  fs::create_directories(options.folder, failed);
  const auto write = [&](const std::string& name, const std::string& text,
                         const std::vector<sequences::KeyFacts>& keys) {
    const std::string target = (fs::path(options.folder) / name).string();
    write_output(target, with_meanings(text, keys), session.replace);
    written.push_back(target);
  };
  for (const StarterFile& file : files) {
    // Not find_config(), which prefers a file of that name in the current folder: that may be the target.
    const fs::path shipped = fs::path(share_folder()) / "bench/config" / file.shipped;
    write(file.name, sequences::TomlDocument::from_file(shipped.string()).text(), file.keys());
  }
  if (!options.operator_name.empty()) write(kProfileFile, profile_text(options.operator_name), operator_profile_keys());
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
  CLI::App* verb = app.add_subcommand("init", "write commented bench, sensor, limits and lab files to start from");
  verb->add_option("folder", options->folder, "where to")->capture_default_str();
  verb->add_option("--operator", options->operator_name,
                   "also write tactbench.toml, with this name: bench, store, operator, recipe and limits then need not "
                   "be typed")
      ->check([](const std::string& name) { return std::string(db::is_blank(name) ? "the name is empty" : ""); });
  verb->add_flag("--rig", options->rig, "bench.toml describes the paper's rig (hardware) instead of the simulated one");
  verb->add_flag("--replace,--force", session.replace, "overwrite existing files");
  verb->callback([options, &session] { init(*options, session); });
}

}  // namespace tactbench::bench
