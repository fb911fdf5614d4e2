#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>
#include <set>

#include "bench/cli/words/command_tree.h"
#include "bench/cli/words/key_manual.h"
#include "bench/cli/words/roff.h"

namespace tactbench::bench {

namespace {

std::string placeholder(const CommandArgument& argument) {
  std::string name = argument.names.back();
  name.erase(0, name.find_first_not_of('-'));
  std::ranges::transform(name, name.begin(),
                         [](char c) { return c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c; });
  return name;
}

std::string synopsis_of(const CommandNode& node) {
  std::string text = fmt::format("\\fBtactbench {}\\fR", roff(node.path));
  if (!node.verbs.empty()) text += " \\fIVERB\\fR";
  for (const CommandArgument& argument : node.arguments) {
    if (!argument.positional && !argument.required) continue;
    std::string part = fmt::format("\\fI{}\\fR", roff(placeholder(argument)));
    if (!argument.positional) part = fmt::format("\\fB{}\\fR {}", roff(argument.names.back()), part);
    if (argument.repeated) part += "...";
    text += argument.required ? fmt::format(" {}", part) : fmt::format(" [{}]", part);
  }
  return text + " [\\fIoptions\\fR]";
}

std::string option_entry(const CommandArgument& argument) {
  std::vector<std::string> names;
  for (const std::string& name : argument.names) names.push_back(fmt::format("\\fB{}\\fR", roff(name)));
  if (argument.positional) names = {fmt::format("\\fI{}\\fR", roff(placeholder(argument)))};
  std::string head = fmt::format("{}", fmt::join(names, ", "));
  if (!argument.positional && argument.kind != ArgumentKind::kFlag)
    head += fmt::format(" \\fI{}\\fR", roff(placeholder(argument)));
  std::string text = fmt::format(".TP\n{}\n{}", head, roff_paragraph(argument.about));
  if (argument.kind == ArgumentKind::kChoice)
    text += fmt::format("; one of {}", roff(fmt::format("{}", fmt::join(argument.choices, ", "))));
  if (!argument.default_value.empty()) text += fmt::format(" (default: {})", roff(argument.default_value));
  return text + "\n";
}

constexpr int kCommon = 5;  // options that so many verbs take alike stand once, in a section of their own

// Entries of options by how many verbs have them, in the same words.
std::map<std::string, int> option_counts(const CommandNode& root) {
  std::map<std::string, int> counts;
  for (const CommandNode* node : all_nodes(root))
    for (const CommandArgument& argument : node->arguments)
      if (!argument.positional) ++counts[option_entry(argument)];
  return counts;
}

// Without what other verbs have as well: the footer of the whole command line, and the common options, which are named.
std::string verb_section(const CommandNode& node, const CommandNode& root, const std::map<std::string, int>& counts) {
  std::string text =
      fmt::format(".SS {}\n{}\n.PP\n{}.\n", roff(node.path), synopsis_of(node), roff_paragraph(node.about));
  std::vector<std::string> common;
  for (const CommandArgument& argument : node.arguments) {
    if (argument.names.back() == "--help") continue;
    const std::string entry = option_entry(argument);
    if (argument.positional || counts.at(entry) < kCommon)
      text += entry;
    else
      common.push_back(fmt::format("\\fB{}\\fR", roff(argument.names.back())));
  }
  if (!common.empty()) text += fmt::format(".PP\nCommon options: {}.\n", fmt::join(common, ", "));
  if (!node.footer.empty() && node.footer != root.footer) text += fmt::format(".PP\n{}\n", roff_paragraph(node.footer));
  return text;
}

std::string common_options(const CommandNode& root, const std::map<std::string, int>& counts) {
  std::string text = ".SH COMMON OPTIONS\nOf the verbs that name them.\nEvery verb takes \\fB\\-\\-help\\fR.\n";
  std::set<std::string> written;
  for (const CommandNode* node : all_nodes(root)) {
    for (const CommandArgument& argument : node->arguments) {
      const std::string entry = option_entry(argument);
      if (argument.positional || argument.names.back() == "--help" || counts.at(entry) < kCommon) continue;
      if (written.insert(entry).second) text += entry;
    }
  }
  return text;
}

struct ManualEntry {
  const char* name;
  const char* about;
};

std::string manual_entries(const std::vector<ManualEntry>& list) {
  std::string text;
  for (const ManualEntry& entry : list)
    text += fmt::format(".TP\n\\fB{}\\fR\n{}\n", roff(entry.name), roff_paragraph(entry.about));
  return text;
}

const std::vector<ManualEntry> manual_codes = {
    {"0", "Done; all requirements are met. A conditional pass counts as 0, with a warning."},
    {"1", "Done; at least one requirement is not met."},
    {"2", "Usage or configuration; no device was touched."},
    {"3", "Device or link."},
    {"4", "Stopped or aborted by the operator, an interlock or a limit."},
    {"5", "Store: locked, full, damaged, wrong schema."},
    {"6", "Inconclusive: a value in the guard band, or too little data."},
    {"7", "The safe state could not be verified. It outranks all others."},
    {"70", "Internal error."},
    {"129, 130, 131, 138, 140, 143 ...",
     "Ended by a signal, after the safe state: 128 and the number of SIGHUP (the terminal or the connection was "
     "closed), SIGINT, SIGQUIT, SIGUSR1, SIGUSR2, SIGTERM or another that would end a program. A closed standard "
     "output or error does not end a run."}};

const std::vector<ManualEntry> manual_environment = {
    {"TACTBENCH_BENCH, TACTBENCH_DB",
     "Bench file and store where a verb is given no --bench and no --db. They precede tactbench.toml. demo and nightly "
     "do not take the store from them; pause, stop, abort and panic take neither."},
    {"TACTBENCH_FLEET",
     "How to connect to the fleet's PostgreSQL where a verb of the fleet is given no --to or --from. It precedes "
     "tactbench.toml. libpq's own variables and files (PGPASSWORD, ~/.pgpass, PGSSLROOTCERT ...) hold as for psql."},
    {"TACTBENCH_SHARE",
     "Folder of the shipped recipes, configurations and module profiles. Without it the folder share/tactbench beside "
     "the program's bin folder is taken, and without that the source tree that the program was built from."},
    {"TACTBENCH_RUNTIME_DIR",
     "A folder of yours that no other user can enter. Programs with this setting are separate from the machine's other "
     "programs: their runs do not lock its benches, and its commands do not reach them. For tests and parallel "
     "simulated rigs, never for a real rig."},
    {"XDG_STATE_HOME",
     "Its folder tactbench holds trips that stay until a person resets them. Without it trips are kept in "
     "/var/lib/tactbench, which the packages make for the group tactbench, or, without that folder, in "
     "~/.local/state/tactbench."},
    {"TACTBENCH_LANES", "Vector level of identification: base, avx2 or avx512, instead of the best one."},
    {"TACTBENCH_EVENT", "Set for the command that --on-event names: what happened."},
    {"CI, TERM", "With CI set, with TERM=dumb or without a terminal, progress is printed as plain lines."}};

const std::vector<ManualEntry> manual_files = {
    {"bench.toml, sensor.toml, limits.toml",
     "Rig and its limits, type of sensor, acceptance limits; tactbench init writes commented ones to start from. "
     "[reference], [force] and [stage] take certificate, calibrated, due (dates as 2026-01-31) and an expanded "
     "uncertainty; the first two say what the certificate covers (certificate_covers). A bench that drives hardware is "
     "refused without that word, and while a value is FILL-IN."},
    {"tactbench.toml",
     "In the working folder: what need not be typed with every verb. Keys: bench, db, operator, recipe (several with "
     "commas between), limits, which calibrate judges by, and fit where it has held-out runs, and units, those of the "
     "pressures printed (kPa, bar or psi). The command line and "
     "the environment precede it; an unknown key is an error. config show prints what is in force."},
    {"lab.toml",
     "Facts for reports that no instrument knows. The run's own certificates take precedence; this file fills the "
     "gaps."},
    {"runs.db",
     "The store when --db is not given: one SQLite file a bench, with runs.db-wal and runs.db-shm while it is open, "
     "and runs.db-lock, an empty file that stays and carries the locks of live runs."},
    {"@tactbench/BENCH",
     "Not a file: the name in /proc/net/unix under which the run on a bench of this machine listens. Its holder has "
     "the bench."},
    {"reports/run-N.html", "Calibration and test reports, in the store's folder; a signed one is named by its number."},
    {"share/tactbench/sequences", "Shipped recipes, named without folder and ending."},
    {"share/tactbench/bench/config", "Shipped bench, sensor type and limits files."},
    {"share/tactbench/devices/profiles", "Profiles of analog modules."}};

}  // namespace

std::string manual_page(const CommandNode& root, const std::string& version, const std::string& date) {
  std::string text = fmt::format(
      ".TH TACTBENCH 1 \"{}\" \"tactbench {}\" \"User Commands\"\n.SH NAME\ntactbench \\- control a test bench for "
      "tactile arrays and compensate their hysteresis\n.SH SYNOPSIS\n\\fBtactbench\\fR \\fIVERB\\fR "
      "[\\fIarguments\\fR] "
      "[\\fIoptions\\fR]\n.br\n\\fBtactbench\\fR \\fIVERB\\fR \\fB\\-\\-help\\fR\n.br\n\\fBtactbench\\fR "
      "\\fB\\-\\-version\\fR\n.SH DESCRIPTION\n",
      date, roff(version));
  text += roff_paragraph(
      "tactbench drives a test bench that characterizes tactile sensor arrays, keeps every sample in SQLite, "
      "identifies hysteresis models for each taxel, scores how well they compensate, and writes a calibration report. "
      "The same program runs against the rig and against a simulated rig at the other end of the same wires. Results "
      "go to standard output, messages to standard error. An error states what is wrong, where, and how to correct it, "
      "with an identifier TB-...");
  text += "\n.SH VERBS\n";
  const std::map<std::string, int> counts = option_counts(root);
  for (const CommandNode* node : all_nodes(root)) {
    if (!node->path.empty()) text += verb_section(*node, root, counts);
  }
  text += common_options(root, counts);
  text += ".SH WHO MAY COMMAND\n";
  text += roff_paragraph(
      "One run at a time uses a bench, whichever user and login started it. Root, the user of the run and members of "
      "the group tactbench may pause, resume, stop, abort and panic it; all others get TB-RUN-DENIED. Answers are "
      "trusted by the same rule: root trusts any run, other users their own, root's, and those of members.");
  text += fmt::format("\n.SH EXIT STATUS\n{}.SH ENVIRONMENT\n{}.SH FILES\n{}", manual_entries(manual_codes),
                      manual_entries(manual_environment), manual_entries(manual_files));
  text +=
      ".SH EXAMPLES\n.nf\ntactbench demo\ntactbench init\ntactbench plan descending ascending\n"
      "tactbench sensors add MY\\-1 \\-\\-type sensor.toml\n"
      "tactbench run descending ascending \\-\\-bench bench.toml \\-\\-sensor MY\\-1 \\-\\-operator me\n"
      "tactbench fit 1 \\-\\-limits limits.toml\ntactbench report 1\ntactbench verify 1\n"
      "tactbench init \\-\\-operator me\ntactbench calibrate MY\\-1\n.fi\n.SH SEE ALSO\n";
  std::vector<std::string> pages;
  for (const std::string& page : key_manual_names()) pages.push_back(fmt::format("\\fB{}\\fR(5)", roff(page)));
  return text + fmt::format("{}\n", fmt::join(pages, ", "));
}

}  // namespace tactbench::bench
