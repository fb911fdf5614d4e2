#include <algorithm>

#include "analysis/counted.h"
#include "analysis/report/parts.h"
#include "analysis/report/sections/sections.h"

namespace tactbench::analysis {

using html::markup;
using html::Markup;
using html::stated;
using html::Text;

namespace {

constexpr std::size_t kMostEventsListed = 40;  // the rest is counted; all are in the store

// Title as its file says it; the recipe is TOML, of which one line is wanted.
std::string recipe_title(const std::string& toml) {
  const std::string key = "\ntitle = \"";
  const std::size_t at = toml.find(key);
  if (at == std::string::npos) return {};
  const std::size_t from = at + key.size(), end = toml.find('"', from);
  return end == std::string::npos ? std::string() : toml.substr(from, end - from);
}

Markup sequences_table(const ReportInput& input) {
  const db::RunRecord& run = input.run;
  Markup out = markup(
      "<table><caption>Method: sequences run</caption><thead><tr><th scope=\"col\">sequence</th>"
      "<th scope=\"col\" class=\"n\">repeats</th><th scope=\"col\" class=\"n\">frames a repeat</th>"
      "<th scope=\"col\">SHA-256 of the recipe</th></tr></thead><tbody>\n");
  for (std::size_t i = 0; i < run.sequences.size(); ++i) {
    const db::SequenceRecord& sequence = run.sequences[i];
    const std::string title = recipe_title(sequence.recipe_toml);
    Markup name = markup("{}", stated(sequence.name));
    if (!title.empty()) name += markup("<br/><span class=\"plain\">{}</span>", Text(title));
    if (i < input.method.size() && !input.method[i].empty())
      name += markup("<br/><span class=\"plain\">{}</span>", Text(input.method[i]));
    out += markup("<tr><th scope=\"row\">{}</th><td class=\"n\">{}</td><td class=\"n\">{}</td><td>{}</td></tr>\n", name,
                  sequence.repeats, sequence.frames_per_repeat, code(sequence.recipe_sha256));
  }
  if (run.sequences.empty()) out += markup("<tr><td colspan=\"4\">not stated</td></tr>\n");
  out += markup("</tbody></table>\n");
  return out;
}

std::string surroundings_words(const SurroundingsRange& range) {
  const bool celsius = range.quantity == "temperature_c", bar = range.quantity == "supply_bar";
  const std::string unit = celsius ? " °C" : bar ? " bar" : "";
  return fmt::format("{}: {:.1f} to {:.1f}{}, {}",
                     celsius ? "temperature measured"
                     : bar   ? "air supply measured"
                             : range.quantity,
                     range.low, range.high, unit, counted(range.readings, "reading"));
}

Markup surroundings(const ReportInput& input) {
  Markup out;
  for (const SurroundingsRange& range : input.history.surroundings)
    out += markup("{}<br/>", Text(surroundings_words(range)));
  out += markup("{}", stated(input.laboratory.environment));
  return out;
}

Markup checks_words(const std::vector<db::CheckRecord>& checks) {
  Markup out;
  for (const db::CheckRecord& check : checks) {
    if (!out.value.empty()) out += markup("; ");
    out += markup("{}: {}", Text(check.kind), Text(check.verdict));
  }
  return out.value.empty() ? markup("none recorded") : out;
}

Markup voids_table(const RunHistory& history, PressureUnit unit) {
  Markup out = markup(
      "<table><caption>Void branches: kept in the store, left out of every figure, done again</caption><thead><tr>"
      "<th scope=\"col\">sequence</th><th scope=\"col\" class=\"n\">repeat</th><th scope=\"col\" "
      "class=\"n\">branch</th>"
      "<th scope=\"col\" class=\"n\">attempt</th><th scope=\"col\">reason</th></tr></thead><tbody>\n");
  for (std::size_t i = 0; i < history.voids.size() && i < kMostEventsListed; ++i) {
    const VoidBranch& branch = history.voids[i];
    out += markup(
        "<tr><th scope=\"row\">{}</th><td class=\"n\">{}</td><td class=\"n\">{}</td><td class=\"n\">{}</td>"
        "<td>{}</td></tr>\n",
        stated(branch.sequence), branch.repeat + 1, branch.branch + 1, branch.attempt + 1, stated(branch.reason));
  }
  out += markup("</tbody></table>\n");
  return out;
}

Markup events_table(const RunHistory& history, PressureUnit unit) {
  Markup out = markup(
      "<table><caption>Pauses, retries and warnings</caption><thead><tr><th scope=\"col\" class=\"n\">time, s</th>"
      "<th scope=\"col\">kind</th><th scope=\"col\">what</th></tr></thead><tbody>\n");
  for (std::size_t i = 0; i < history.events.size() && i < kMostEventsListed; ++i) {
    const HistoryEvent& event = history.events[i];
    out += markup("<tr><td class=\"n\">{}</td><td>{}</td><td>{}</td></tr>\n", html::fixed(event.time_s, 0),
                  Text(event.kind), stated(event.text));
  }
  out += markup("</tbody></table>\n");
  return out;
}

// Also reports 0: otherwise a clean run would look like an unchecked one.
Markup deviations_table(const ReportInput& input) {
  const RunHistory& history = input.history;
  const auto count = [&](const char* kind) {
    return std::ranges::count(history.events, std::string(kind), &HistoryEvent::kind);
  };
  std::string flags;
  for (const auto& [word, frames] : history.flags)
    flags += fmt::format("{}{} {}", flags.empty() ? "" : ", ", frames, word);
  std::vector<Pair> rows = {{"branches void and done again",
                             markup("{} ({})", history.voids.size(), Text(counted(history.void_frames, "frame")))},
                            {"attempts at frames and branches after a fault", markup("{}", count("attempt"))},
                            {"frames that carry a flag", markup("{} of {}{}", history.flagged, history.frames,
                                                                Text(flags.empty() ? "" : fmt::format(": {}", flags)))},
                            {"pauses, suspensions, questions to the operator",
                             markup("{}, {}, {}", count("pause"), count("suspension"), count("prompt"))},
                            {"warnings", markup("{}", count("warning"))},
                            {"checks of the set-up", checks_words(history.checks)},
                            {"operator’s entry", markup("{}", stated(input.laboratory.deviations))}};
  return pairs_table("Deviations from the method", rows);
}

}  // namespace

Markup method_part(const ReportInput& input) {
  const RunHistory& history = input.history;
  Markup out = sequences_table(input);
  out += pairs_table("Conditions",
                     {{"pressure medium", markup("{}", stated(input.laboratory.medium))},
                      {"surroundings", surroundings(input)},
                      {"mounting and what lies on the sensor", markup("{}", stated(input.laboratory.mounting))},
                      {"time by activity", markup("{}", stated(history.time_spent))}});
  if (!history.loaded) {
    out += markup("<p>Deviations from the method: not available.</p>\n");
    return out;
  }
  out += deviations_table(input);
  if (!history.voids.empty()) out += voids_table(history, input.unit);
  if (!history.events.empty()) out += events_table(history, input.unit);
  const std::size_t longest = std::max(history.voids.size(), history.events.size());
  if (longest > kMostEventsListed)
    out +=
        markup("<p class=\"note\">The first {} of each are printed; all stand in the store.</p>\n", kMostEventsListed);
  return out;
}

}  // namespace tactbench::analysis
