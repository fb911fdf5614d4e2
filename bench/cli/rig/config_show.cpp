#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>

#include "bench/cli/session.h"
#include "bench/common/overrides.h"
#include "bench/config/config.h"

namespace tactbench::bench {

namespace {

struct ConfigOptions {
  std::string bench = "simulated.toml";
  std::vector<std::string> set;
  bool origin = false;
};

void show(const ConfigOptions& options, const Session& session) {
  const BenchConfig config = read_bench(find_config(options.bench), split_overrides(options.set).bench);
  if (session.json) {
    nlohmann::ordered_json list = nlohmann::ordered_json::array();
    for (const sequences::Setting& setting : config.settings) {
      list.push_back({{"key", setting.key}, {"value", setting.value}, {"origin", setting.origin}});
    }
    print_json("config.show", {{"bench", config.file}, {"settings", list}});
    return;
  }
  std::size_t widest = 0;
  std::vector<std::string> lines;
  for (const sequences::Setting& setting : config.settings) {
    lines.push_back(one_line(fmt::format("{} = {}", setting.key, setting.value), kLongestText));
    widest = std::max(widest, display_width(lines.back()));
  }
  widest = std::min<std::size_t>(widest, 72);
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const std::string blanks(widest - std::min(widest, display_width(lines[i])), ' ');
    tty::print("{}{}\n", lines[i],
               options.origin ? fmt::format("{}  # {}", blanks, one_line(config.settings[i].origin)) : std::string());
  }
}

}  // namespace

void add_config(CLI::App& app, Session& session) {
  auto options = std::make_shared<ConfigOptions>();
  CLI::App* verb = app.add_subcommand("config", "show every value of a bench file, defaults included");
  verb->require_subcommand(1);
  CLI::App* show_verb = verb->add_subcommand("show", "all keys with the values in force");
  show_verb->add_option("--bench", options->bench, "bench file")->capture_default_str();
  show_verb->add_option("--set", options->set, "override table.key=value")->take_all();
  show_verb->add_flag("--origin", options->origin, "show the source of each value: file and line, --set, default");
  show_verb->add_flag("--json", session.json, "one JSON document on standard output");
  show_verb->callback([options, &session] { show(*options, session); });
}

}  // namespace tactbench::bench
