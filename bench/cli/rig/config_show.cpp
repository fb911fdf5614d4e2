#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>

#include "analysis/json_fields.h"
#include "bench/cli/session.h"
#include "bench/common/overrides.h"
#include "bench/config/config.h"
#include "db/fleet/postgres.h"

namespace tactbench::bench {

namespace {

struct ConfigOptions {
  std::vector<std::string> set;
  bool origin = false;
};

// Defaults of the verbs' options, as settings "profile.KEY".
std::vector<sequences::Setting> profile_settings(const OperatorProfile& profile) {
  std::vector<sequences::Setting> settings;
  for (const auto& [key, given] : profile) {
    std::vector<std::string> values;
    for (const std::string& value : given.values)
      values.push_back(fmt::format("\"{}\"", db::fleet::without_passwords(value)));
    settings.push_back(
        {fmt::format("profile.{}", to_string(key)), fmt::format("{}", fmt::join(values, ", ")), given.origin});
  }
  return settings;
}

nlohmann::ordered_json settings_json(const std::vector<sequences::Setting>& settings) {
  auto list = nlohmann::ordered_json::array();
  for (const sequences::Setting& setting : settings) list.push_back({JSON_FIELDS(setting, key, value, origin)});
  return list;
}

void show(const ConfigOptions& options, Session& session) {
  std::vector<sequences::Setting> shown = profile_settings(session.profile.values());
  const BenchConfig config =
      read_bench(find_config(session.bench_file(kShippedBench)), split_overrides(options.set).bench);
  if (session.json) {
    print_json(
        "config",
        {{"bench", config.file}, {"profile", settings_json(shown)}, {"settings", settings_json(config.settings)}});
    return;
  }
  shown.insert(shown.end(), config.settings.begin(), config.settings.end());
  std::size_t widest = 0;
  std::vector<std::string> lines;
  for (const sequences::Setting& setting : shown) {
    lines.push_back(one_line(fmt::format("{} = {}", setting.key, setting.value), kMaxTextLength));
    widest = std::max(widest, display_width(lines.back()));
  }
  widest = std::min<std::size_t>(widest, 72);
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const std::string blanks(widest - std::min(widest, display_width(lines[i])), ' ');
    tty::print("{}{}\n", lines[i],
               options.origin ? fmt::format("{}  # {}", blanks, one_line(shown[i].origin)) : std::string());
  }
}

}  // namespace

void add_config(CLI::App& app, Session& session) {
  auto options = std::make_shared<ConfigOptions>();
  CLI::App* verb = app.add_subcommand("config", "show every value of a bench file, including defaults");
  verb->add_option("--set", options->set, "override table.key=value")->take_all();
  verb->add_flag("--origin", options->origin,
                 "show the source of each value: file and line, variable of the environment, --set, default");
  verb->footer("Also shows the values of tactbench.toml and the environment.");
  verb->callback([options, &session] { show(*options, session); });
}

}  // namespace tactbench::bench
