#include "bench/cli/help.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "bench/cli/session.h"

namespace tactbench::bench {

namespace {

constexpr std::size_t kColumns = 90, kNames = 16, kOptions = 30;

// Words in lines of at most `width`; a line break of the text stays.
std::string wrapped(const std::string& text, std::size_t width) {
  std::string out;
  std::size_t line = 0;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find_first_of(" \n", at), text.size());
    if (line > 0 && line + 1 + (end - at) > width) {
      out += '\n';
      line = 0;
    } else if (line > 0) {
      out += ' ';
      ++line;
    }
    out.append(text, at, end - at);
    line += end - at;
    if (end < text.size() && text[end] == '\n') {
      out += '\n';
      line = 0;
    }
    at = end + 1;
  }
  return out;
}

class HelpFormatter : public CLI::Formatter {
 public:
  // A list of verbs shows only their first lines.
  std::string make_subcommand(const CLI::App* sub) const override {
    const std::string about = sub->get_description();
    const std::size_t width = std::max(kNames, sub->get_name().size() + 2);
    return fmt::format("  {:<{}}{}\n", sub->get_name(), width, about.substr(0, about.find('\n')));
  }
  std::string make_description(const CLI::App* app) const override {
    return wrapped(app->get_description(), kColumns) + "\n";
  }
  std::string make_option_desc(const CLI::Option* option) const override {
    return wrapped(option->get_description(), kColumns - kOptions);
  }
  std::string make_footer(const CLI::App* app) const override {
    const std::string own = wrapped(app->get_footer(), kColumns);
    if (app->get_parent() == nullptr) return own + "\n";
    const std::vector<std::string> groups = app->get_groups();
    const bool rare = std::ranges::find(groups, kRareOptions) != groups.end();
    return fmt::format("{}{}{}For every verb: --db --bench --units --json -q (tactbench --help).\n", own,
                       own.empty() ? "" : "\n\n", rare ? "Rarely needed options: --help-all.\n" : "");
  }
  std::string make_group(std::string group, bool positional, std::vector<const CLI::Option*> options) const override {
    if (group == kRareOptions && !all_) return {};
    std::erase_if(options,
                  [&](const CLI::Option* option) { return !root_ && option->get_name().starts_with("--help"); });
    return options.empty() ? std::string()
                           : CLI::Formatter::make_group(std::move(group), positional, std::move(options));
  }
  // Verbs first.
  std::string make_help(const CLI::App* app, std::string name, CLI::AppFormatMode mode) const override {
    all_ = mode == CLI::AppFormatMode::All;
    root_ = app->get_parent() == nullptr;
    const std::string text = make_description(app) + make_usage(app, std::move(name)) +
                             make_subcommands(app, CLI::AppFormatMode::Normal) + make_positionals(app) +
                             make_groups(app, CLI::AppFormatMode::Normal) + "\n" + make_footer(app);
    return CLI::detail::find_and_replace(text, "\n\n\n", "\n\n");
  }

 private:
  mutable bool all_ = false, root_ = false;
};

}  // namespace

void set_help(CLI::App& app) {
  app.formatter(std::make_shared<HelpFormatter>());
  app.set_help_all_flag("--help-all", "for a verb: also the options that are rarely needed");
}

}  // namespace tactbench::bench
