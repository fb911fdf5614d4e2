#include "bench/cli/words/key_manual.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>

#include "bench/cli/words/key_list.h"
#include "bench/cli/words/roff.h"
#include "bench/common/error.h"

namespace tactbench::bench {
namespace {

// Markdown's links as their words, what stands between backticks in bold.
std::string roff_of_markdown(const std::string& text) {
  std::string plain;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const std::size_t end = text[i] == '[' ? text.find(']', i) : std::string::npos;
    if (end == std::string::npos || text.compare(end, 2, "](") != 0) {
      plain += text[i];
      continue;
    }
    plain += text.substr(i + 1, end - i - 1);
    i = text.find(')', end);
  }
  std::string out;
  bool bold = false;
  for (std::size_t from = 0; from <= plain.size();) {
    const std::size_t to = std::min(plain.find('`', from), plain.size());
    const std::string part = plain.substr(from, to - from);
    out += bold ? fmt::format("\\fB{}\\fR", roff(part)) : roff(part);
    bold = !bold;
    from = to + 1;
  }
  return out;
}

// "[[scenario]]" of "scenario[]", "[scenario.taxels]" of "scenario[].taxels".
std::string header_of(const std::string& table) {
  if (table.empty()) return "At the top of the file";
  std::string name = table;
  for (std::size_t at = 0; (at = name.find("[]", at)) != std::string::npos;) name.erase(at, 2);
  return table.ends_with("[]") ? fmt::format("[[{}]]", name) : fmt::format("[{}]", name);
}

std::string facts_of(const KnownKey& key) {
  const sequences::KeyUse& use = key.use;
  const bool word = use.type == "one of" && !use.ranges.empty();
  std::vector<std::string> facts = {word ? fmt::format("one of {}", fmt::join(use.ranges, "; or ")) : use.type};
  if (!key.unit.empty()) facts.push_back(key.unit == "`unit`" ? "in the file's unit" : key.unit);
  if (!word && !use.ranges.empty()) facts.push_back(fmt::format("{}", fmt::join(use.ranges, "; or ")));
  if (use.required) facts.emplace_back("required");
  if (!use.required && !use.defaults.empty())
    facts.push_back(fmt::format("default {}", fmt::join(use.defaults, " or ")));
  return fmt::format("{}", fmt::join(facts, ", "));
}

std::string entry_of(const KnownKey& key) {
  const std::string name = key.use.key.substr(table_of(key.use.key).empty() ? 0 : table_of(key.use.key).size() + 1);
  std::string meaning = roff_paragraph(key.meaning.empty() ? "Not described" : key.meaning);
  if (!meaning.ends_with('.')) meaning += '.';
  return fmt::format(".TP\n\\fB{}\\fR ({})\n{}\n", roff(name), roff(facts_of(key)), meaning);
}

std::string keys_section(const FileKind& kind) {
  std::string text = ".SH KEYS\n", table;
  bool first = true;
  for (const KnownKey& key : known_keys(kind)) {
    if (first || table_of(key.use.key) != table) {
      table = table_of(key.use.key);
      text += fmt::format(".SS \"{}\"\n", roff(header_of(table)));
    }
    first = false;
    text += entry_of(key);
  }
  return text;
}

}  // namespace

std::vector<std::string> key_manual_names() {
  std::vector<std::string> names;
  for (const FileKind& kind : file_kinds()) names.emplace_back(kind.page);
  return names;
}

std::string key_manual(const std::string& name, const std::string& version, const std::string& date) {
  const auto kind = std::ranges::find_if(file_kinds(), [&](const FileKind& one) { return name == one.page; });
  if (kind == file_kinds().end())
    throw Error(ExitCode::kUsage, "TB-USAGE", fmt::format("there is no page '{}'", name), "manual-page",
                fmt::format("one of: {}", fmt::join(key_manual_names(), ", ")));
  std::string title = name;
  std::ranges::transform(title, title.begin(),
                         [](char c) { return static_cast<char>(std::toupper(static_cast<unsigned char>(c))); });
  std::vector<std::string> others;
  for (const std::string& other : key_manual_names())
    if (other != name) others.push_back(fmt::format("\\fB{}\\fR(5)", roff(other)));
  return fmt::format(
      ".TH {} 5 \"{}\" \"tactbench {}\" \"File Formats\"\n.SH NAME\n{} \\- {}\n.SH DESCRIPTION\n{}\n.PP\n"
      "The file is TOML, in UTF\\-8.\nA number stands alone: its unit is in the key.\nAn unknown key is an error, "
      "which "
      "names the line and the nearest known key.\nA key that is \\fIrequired\\fR in a table that may be left out is "
      "required only where the table is there.\nSeveral ranges or defaults depend on other keys.\n{}"
      ".SH SEE ALSO\n\\fBtactbench\\fR(1), {}\n",
      roff(title), date, roff(version), roff(name), roff(kind->summary), roff_of_markdown(kind->about),
      keys_section(*kind), fmt::join(others, ", "));
}

}  // namespace tactbench::bench
