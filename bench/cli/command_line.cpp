#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cctype>
#include <cstdio>
#include <string>
#include <utility>

#include "bench/cli/help.h"
#include "bench/cli/session.h"
#include "bench/common/build_info.h"
#include "bench/common/error_table.h"
#include "bench/common/standard_streams.h"
#include "db/run_store.h"
#include "db/store_file.h"
#include "sequences/toml/strict_toml.h"

namespace tactbench::bench {

namespace {

constexpr const char* kFooter =
    R"(Exit codes: 0 pass, 1 a criterion failed, 2 usage or configuration (nothing touched), 3 device or link, 4 stopped by operator, interlock or limit, 5 store, 6 inconclusive, 7 safe state not verified, 70 internal error, 128 + N ended by signal N after the safe state. Ctrl-C once: pause at the end of the branch; twice: stop now. However a run ends, it vents, retracts, proves the safe state and keeps all frames.
Defaults: --db and --bench from TACTBENCH_DB and TACTBENCH_BENCH, a fleet from TACTBENCH_FLEET; bench, db, operator, recipe, limits, lab, units and fleet from the file tactbench.toml in the working folder; bench.toml in that folder is the default bench. The command line has precedence over the environment, and that over the file.)";

constexpr const char* kGreeting =
    "tactbench controls a test bench for tactile arrays, keeps every sample and compensates hysteresis.\n\n"
    "  tactbench demo                 the paper's characterization on a simulated rig, in ten seconds\n"
    "  tactbench init --operator me   files of your own bench in this folder; then: tactbench calibrate SERIAL\n"
    "  tactbench --help               all verbs\n";

// For a misspelled verb CLI11 reports only "a subcommand is required".
void check_verb(const CLI::App& app, int argc, char** argv) {
  if (argc < 2 || argv[1][0] == '-') return;
  std::vector<std::string> verbs;
  const std::string given = argv[1];
  for (const CLI::App* verb : app.get_subcommands({})) {
    if (!verb->get_group().empty() || verb->get_name() == given) verbs.push_back(verb->get_name());
  }
  if (std::find(verbs.begin(), verbs.end(), given) != verbs.end()) return;
  const std::string near = sequences::nearest_word(given, verbs);
  throw Error(
      "TB-USAGE", fmt::format("there is no verb '{}'", given), "command line",
      near.empty() ? fmt::format("one of: {}", fmt::join(verbs, ", ")) : fmt::format("did you mean '{}'?", near));
}

// The verb that was typed, as far as it was understood, with its words.
std::pair<const CLI::App*, std::string> typed_verb(const CLI::App& app) {
  const CLI::App* verb = &app;
  std::string text = app.get_name();
  while (!verb->get_subcommands().empty()) {
    verb = verb->get_subcommands().back();
    text += " " + verb->get_name();
  }
  return {verb, text};
}

// CLI11 reports a missing required option or verb before a misspelled one, which usually is the cause.
Error usage_error(const CLI::App& app, const CLI::ParseError& error) {
  const std::vector<std::string> left = app.remaining(true);
  const auto [verb, text] = typed_verb(app);
  std::vector<std::string> verbs;
  for (const CLI::App* below : verb->get_subcommands({})) verbs.push_back(below->get_name());
  if (verb->get_require_subcommand_min() > 0 && verb != &app) {
    const bool typed = !left.empty() && left.front().size() > 1 && left.front().front() != '-';
    const std::string near = typed ? sequences::nearest_word(left.front(), verbs) : std::string();
    return {"TB-USAGE",
            typed ? fmt::format("there is no verb '{}' of '{}'", left.front(), text)
                  : fmt::format("'{}' needs a verb after it", text),
            "command line",
            near.empty() ? fmt::format("one of: {}", fmt::join(verbs, ", ")) : fmt::format("did you mean '{}'?", near)};
  }
  const auto unknown = std::find_if(left.begin(), left.end(), [](const std::string& word) {
    return word.size() > 1 && word.front() == '-' && std::isdigit(static_cast<unsigned char>(word[1])) == 0;
  });
  if (unknown == left.end()) {
    std::string what = error.what(), remedy;
    if (const std::size_t at = what.find(" = "); what.starts_with("Could not convert: ") && at != std::string::npos) {
      const std::string typed = what.substr(at + 3),
                        digits = typed.substr(std::min(typed.size(), typed.rfind('-') + 1));
      what = fmt::format("'{}' is not a number", typed);
      if (typed.starts_with("run-") && !digits.empty()) remedy = "write " + digits;
    }
    if (what.find("--operator is required") != std::string::npos)
      remedy = "--operator NAME; or once, in tactbench.toml: tactbench init --operator NAME";
    else if (text == "tactbench compare" && !left.empty())
      remedy =
          "this compares kinds of models; to compare two runs: tactbench runs diff A B, or tactbench report --compare "
          "A B";
    if (remedy.empty()) {
      remedy = text;
      for (const CLI::Option* option : verb->get_options())
        if (option->get_positional())
          remedy += option->get_required() ? " " + option->get_name(true) : " [" + option->get_name(true) + "]";
      for (const CLI::Option* option : verb->get_options())
        if (!option->get_positional() && option->get_required()) remedy += fmt::format(" {} ...", option->get_name());
      remedy += fmt::format("; {} --help", text);
    }
    return {"TB-USAGE", what, "command line", remedy};
  }
  std::vector<std::string> known;
  for (const CLI::Option* option : verb->get_options()) {
    for (const std::string& name : option->get_lnames()) known.push_back("--" + name);
  }
  const std::string name = unknown->substr(0, unknown->find('='));
  const std::string near = sequences::nearest_word(name, known);
  if (text == "tactbench fit" && (name == "--limits" || name == "--held-out" || name == "--lab"))
    return {"TB-USAGE", fmt::format("{} judges, and fit only makes the model", name), "command line",
            "then: tactbench judge MODEL RUN... --limits FILE"};
  return {"TB-USAGE", fmt::format("there is no option '{}' of '{}'", name, text), "command line",
          near.empty() ? fmt::format("{} --help lists the valid ones", text) : fmt::format("did you mean '{}'?", near)};
}

// The first word that is neither an option nor its value.
std::string verb_of(int argc, char** argv) {
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    if (word == "--db" || word == "--bench" || word == "--units")
      ++i;
    else if (!word.starts_with('-'))
      return word;
  }
  return {};
}

int report(const Error& error, const Session& session, bool devices) {
  if (session.json) tty::print("{}", error_json(error));
  tty::print(stderr, "{}", error_text(error, devices));
  std::fflush(stdout);
  return static_cast<int>(error.code());
}

void add_verbs(CLI::App& app, Session& session) {
  for (const auto& [group, verbs] : kVerbs) {
    const std::size_t before = app.get_subcommands({}).size();
    for (AddVerb* const add : verbs) add(app, session);
    const std::vector<CLI::App*> all = app.get_subcommands({});
    for (std::size_t i = before; i < all.size(); ++i)
      if (!all[i]->get_group().empty()) all[i]->group(group);
  }
}

}  // namespace

void add_subverbs(CLI::App& verb, Session& session) {
  for (AddVerb* const add : kSubverbs.at(verb.get_name())) add(verb, session);
}

int run_command_line(int argc, char** argv) {
  open_standard_descriptors();
  const std::string verb = verb_of(argc, argv);
  const bool devices = std::ranges::find(kDeviceVerbs, verb) != kDeviceVerbs.end();
  if (devices) drop_unwritable_output();
  db::set_warning_handler(
      [](const std::string& text) { tty::print(stderr, "warning: {}\n", one_line(text, kMaxTextLength)); });
  Session session;
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    session.json = session.json || word == "--json";
    if (word.starts_with("--help") || word == "-h" || word == "--version") session.profile.tolerate_unreadable();
  }
  if (verb == "pause" || verb == "stop" || verb == "panic")
    session.profile.tolerate_unreadable();  // must not be prevented by an unreadable file
  CLI::App app("tactbench: controls a test bench for tactile arrays, keeps every sample, compensates hysteresis",
               "tactbench");
  app.set_version_flag("--version", fmt::format("tactbench {} (commit {}; {})", build_info().version, commit_text(),
                                                build_info().build));
  app.require_subcommand(1);
  set_help(app);
  add_global_options(app, session);
  add_verbs(app, session);
  app.footer(kFooter);  // which verbs would inherit
  if (argc == 1) {
    tty::print("{}", kGreeting);
    return 0;
  }
  try {
    check_verb(app, argc, argv);
    app.parse(argc, argv);
    std::fflush(stdout);
    return static_cast<int>(session.code);
  } catch (const CLI::CallForHelp& help) {
    return app.exit(help);
  } catch (const CLI::CallForAllHelp& help) {
    return app.exit(help);
  } catch (const CLI::CallForVersion& version) {
    return app.exit(version);
  } catch (const CLI::ParseError& error) {
    return report(usage_error(app, error), session, devices);
  } catch (...) {
    return report(as_error(std::current_exception()), session, devices);
  }
}

// `reference-errors`: docs/reference-errors.md, the table of errors as a page.

namespace {

std::string sentence(std::string_view clause) {
  std::string text(clause);
  text[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(text[0])));
  return text + ".";
}

}  // namespace

void add_error_reference(CLI::App& app, Session& /*session*/) {
  CLI::App* verb = app.add_subcommand("reference-errors", "docs/reference-errors.md, for the documents")->group("");
  verb->callback([] {
    tty::print("{}",
               "# Errors\n\nPrinted by `tactbench reference-errors`. An error states what happened, where, what to try "
               "(the remedy below,\nor a more specific one) and in what state it left the rig; `--json` adds "
               "identifier, exit code and cause. Instead of the error's code\nthe program exits with 7 if the safe "
               "state was not verified, and with 128 plus the signal's number if a signal ended it\n([all exit "
               "codes](rules.md#exit-codes)). 0: a warning, which does not end the program.\n\n"
               "| id | exit code | cause | remedy |\n|---|---|---|---|\n");
    for (const ErrorRow& row : kErrorTable) {
      tty::print("| `{}` | {} | {} | {} |\n", row.id, static_cast<int>(row.exit_code), sentence(row.cause),
                 sentence(row.remedy));
    }
  });
}

}  // namespace tactbench::bench
