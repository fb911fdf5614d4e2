#include "bench/cli/rig/init.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <regex>
#include <set>
#include <sstream>

#include "bench/cli/session.h"
#include "bench/common/output_file.h"
#include "bench/config/config.h"
#include "bench/config/config_laboratory.h"
#include "bench/config/config_profile.h"
#include "bench/config/operator_profile.h"
#include "bench/nightly/suite.h"
#include "db/remarks.h"
#include "sequences/recipe.h"

namespace tactbench::bench {

namespace {

struct InitOptions {
  std::string folder = ".", operator_name;
  bool rig = false;
};

// For --operator. JSON's escapes are also TOML's.
std::string profile_text(const std::string& operator_name) {
  return fmt::format(
      "# Defaults of command-line options, for the folder in which tactbench is started. Precedence: the command\n"
      "# line, the environment (TACTBENCH_BENCH, TACTBENCH_DB, TACTBENCH_FLEET), this file: tactbench config "
      "--origin.\n"
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
    write_output(target, with_key_comments(text, keys), session.replace);
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
                   "also write tactbench.toml, with this name: defaults for bench, store, operator, recipe and limits")
      ->check([](const std::string& name) { return std::string(db::is_blank(name) ? "the name is empty" : ""); });
  verb->add_flag("--rig", options->rig, "bench.toml describes the paper's rig (hardware) instead of the simulated one");
  verb->add_flag("--replace,--force", session.replace, "overwrite existing files");
  verb->callback([options, &session] { init(*options, session); });
}

namespace {

using sequences::KeyFacts;

constexpr std::size_t kWidest = 120;

// `|` would end a cell.
std::string table_cell(std::string text) {
  for (std::size_t at = 0; (at = text.find('|', at)) != std::string::npos; at += 2) text.insert(at, "\\");
  return text;
}

// "sensor[]" of "[[sensor]]", "stage.x" of "[stage.x]", also behind "# "; empty of any other line.
std::string table_of_line(const std::string& line) {
  static const std::regex header(R"(^(?:# )?(\[\[?)([a-z_.]+)\]\]?(?: .*)?$)");
  std::smatch parts;
  if (!std::regex_match(line, parts, header)) return {};
  return parts[2].str() + (parts[1].length() == 2 ? "[]" : "");
}

std::string key_of_line(const std::string& line) {
  static const std::regex assignment(R"(^(?:# )?([a-z_0-9]+) = .*)");
  std::smatch parts;
  return std::regex_match(line, parts, assignment) ? parts[1].str() : std::string();
}

// "Longest time to wait for an answer (ms; 10 to 10000)" as lines that begin with "# ".
std::string comment_of(const KeyFacts& key) {
  const std::string unit = key.unit == "-" || key.unit == "1" ? "" : key.unit;
  const std::string facts = unit + (unit.empty() || key.range.empty() ? "" : "; ") + key.range;
  std::istringstream words(key.meaning + (facts.empty() ? "" : fmt::format(" ({})", facts)));
  std::string text, line = "#";
  for (std::string word; words >> word;) {
    if (line.size() + 1 + word.size() > kWidest) {
      text += line + "\n";
      line = "#";
    }
    line += " " + word;
  }
  return text + line + "\n";
}

}  // namespace

const std::vector<FileKind>& file_kinds() {
  static const std::vector<FileKind> kinds = {
      {"Bench file",
       "bench.toml: a rig, its instruments and its limits. `tactbench init` and `tactbench init --rig` write commented "
       "ones to start from. `--set KEY=VALUE` changes a value for a run.",
       bench_keys},
      {"Recipe",
       "What a run does. How-to: [write a recipe](how-to-write-a-recipe.md). `--set recipe.KEY=VALUE` changes a value "
       "for a run.",
       sequences::recipe_keys},
      {"Sensor type", "sensor.toml: the kind of array, for `tactbench sensors add --type`.", sensor_type_keys},
      {"Limits",
       "limits.toml: the requirements for a pass. How-to: [judge by your limits](how-to-judge-by-your-limits.md).",
       limits_keys},
      {"Laboratory", "lab.toml: facts for reports that no instrument can supply, for `tactbench report --lab`.",
       laboratory_keys},
      {"Operator's profile", "tactbench.toml in the working folder: defaults of command-line options.",
       operator_profile_keys},
      {"Nightly suite",
       "What `tactbench nightly FILE` carries out. How-to: [a night in CI](how-to-run-a-night-in-ci.md).", suite_keys},
      {"Module profile", "An analog module behind Modbus; `[module] profile` names a shipped one, or a file.",
       module_profile_keys},
  };
  return kinds;
}

std::string with_key_comments(const std::string& toml, const std::vector<KeyFacts>& keys) {
  std::istringstream lines(toml);
  std::string text, table;
  std::set<std::string> written;
  for (std::string line; std::getline(lines, line);) {
    const std::string header = table_of_line(line);
    if (!header.empty()) table = header;
    const std::string name = (table.empty() ? "" : table + ".") + key_of_line(line);
    const auto key = std::ranges::find(keys, name, &KeyFacts::key);
    if (key != keys.end() && written.insert(name).second) text += comment_of(*key);
    text += line + "\n";
  }
  return text;
}

namespace {

// docs/reference-keys.md, in Markdown.
std::string key_reference() {
  std::string text =
      "# Keys of the TOML files\n\n"
      "The program writes this page (`tactbench reference-keys`), from the tables by which it reads the files. An "
      "unknown key is an\n"
      "error, which names the line and the nearest known key. A value is a number alone; its unit is in the key; a "
      "pressure (`_psi`) may\n"
      "be a text with its unit, too: `\"100 kPa\"`. `[]` stands for each element of a list of tables, `NAME` for a "
      "name "
      "of yours.\n"
      "Unit `1`: a pure number or a count; `-`: no number.\n"
      "*required*: there is no default; in a table that may be left out, or with certain values of other keys, only "
      "there. A key with\n"
      "neither may be left out, and nothing stands in for it. Several ranges or defaults: it depends on other keys "
      "which one counts.\n";
  for (const FileKind& kind : file_kinds()) {
    text += fmt::format("\n## {}\n{}\n\n| key | meaning | type | unit | range | default |\n|---|---|---|---|---|---|\n",
                        kind.title, kind.about);
    for (const KeyFacts& key : kind.keys())
      text += fmt::format("| `{}` | {} | {} | {} | {} | {} |\n", key.key, table_cell(key.meaning), key.type, key.unit,
                          table_cell(key.range), table_cell(key.standard));
  }
  return text;
}

}  // namespace

// For tests/docs/reference.py.
void add_key_reference(CLI::App& app, Session& /*session*/) {
  app.add_subcommand("reference-keys", "docs/reference-keys.md, for the documents")->group("")->callback([] {
    tty::print("{}", key_reference());
  });
}

}  // namespace tactbench::bench
