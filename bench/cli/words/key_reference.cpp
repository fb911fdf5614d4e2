#include "bench/cli/words/key_reference.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "bench/cli/words/key_list.h"

namespace tactbench::bench {
namespace {

// `|` would end a cell.
std::string table_cell(std::string text) {
  for (std::size_t at = 0; (at = text.find('|', at)) != std::string::npos; at += 2) text.insert(at, "\\");
  return text;
}

std::string row_of(const KnownKey& key) {
  const sequences::KeyUse& use = key.use;
  std::string usual = use.required           ? "required"
                      : use.defaults.empty() ? ""
                                             : fmt::format("`{}`", fmt::join(use.defaults, "` or `"));
  return fmt::format("| `{}` | {} | {} | {} | {} | {} |\n", use.key, table_cell(key.meaning), use.type, key.unit,
                     table_cell(fmt::format("{}", fmt::join(use.ranges, "; or "))), table_cell(usual));
}

}  // namespace

std::string key_reference() {
  std::string text =
      "# Keys of the TOML files\n\n"
      "The program writes this page (`tactbench reference-keys`), from what its own parsers ask for; `man 5 "
      "tactbench-bench`,\n"
      "`tactbench-recipe` and so on have the same. An unknown key is an error, which names the line and the nearest "
      "known key. A value\n"
      "is a number alone; its unit is in the key. `[]` stands for each element of a list of tables, `NAME` for a name "
      "of yours.\n"
      "*required*: there is no default; in a table that may be left out, or with certain values of other keys, only "
      "there. A key with\n"
      "neither may be left out, and nothing stands in for it. Several ranges or defaults: it depends on other keys "
      "which one counts, as\n"
      "do those of `trip_psi` (from `command_psi` on), `high_mm`, `inner_diameter_mm`, `row` and `column` (the "
      "array's), `title` (the\n"
      "name), `peak_n` (from the contact's force on), `value` (from `low` to `high`).\n";
  for (const FileKind& kind : file_kinds()) {
    text += fmt::format("\n## {}\n{}\n\n| key | meaning | type | unit | range | default |\n|---|---|---|---|---|---|\n",
                        kind.title, kind.about);
    check_meanings(kind);
    for (const KnownKey& key : known_keys(kind)) text += row_of(key);
  }
  return text;
}

}  // namespace tactbench::bench
