#include "bench/cli/words/key_reference.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <vector>

#include "bench/cli/words/key_samples.h"
#include "sequences/toml/key_recorder.h"

namespace tactbench::bench {
namespace {

using sequences::KeyRecorder;
using sequences::KeyUse;

// What a key's ending says of its value. Longer endings first.
constexpr std::array<std::pair<const char*, const char*>, 41> kUnits = {
    {{"_percent_per_min", "% a minute"},
     {"_per_thousand_cycles", "1 a thousand cycles"},
     {"_v_per_month", "V a month"},
     {"_drift_per_month", "1 a month"},
     {"_n_per_mm2", "N/mm²"},
     {"_n_per_mm", "N/mm"},
     {"_mm_per_s", "mm/s"},
     {"_psi_per_s", "psi/s"},
     {"_percent_fs", "% of full scale"},
     {"_percent", "%"},
     {"_per_second", "1/s"},
     {"_months", "months"},
     {"_counts", "counts"},
     {"_share", "1"},
     {"_crosstalk", "1"},
     {"_nonuniformity", "1"},
     {"temperature_coefficient", "1/K"},
     {"_variation", "1"},
     {"chamber_tilt", "1"},
     {"damping", "1"},
     {"coverage_factor", "1"},
     {"volts_span", "V"},
     {"raw_span", "counts"},
     {"span_psi", "psi"},
     {"span_bar", "bar"},
     {"span_c", "°C"},
     {"baud", "bit/s"},
     {"_nmm", "N mm"},
     {"_mm2", "mm²"},
     {"_deg", "°"},
     {"_psi", "psi"},
     {"_bar", "bar"},
     {"_mm", "mm"},
     {"_ms", "ms"},
     {"_hz", "Hz"},
     {"_n", "N"},
     {"_s", "s"},
     {"_v", "V"},
     {"_c", "°C"},
     {"grid.x", "mm"},
     {"grid.y", "mm"}}};
// Of a recipe, in the unit that its key `unit` names.
constexpr std::array kOfRecipe = {"turning_points", "step", "conditioning.peak", "random.low", "random.high"};

std::string unit_of(const KeyUse& use, bool recipe) {
  if (use.type == "text" || use.type == "one of" || use.type == "true or false" || use.type == "date") return "";
  for (const char* key : kOfRecipe)
    if (recipe && use.key == key) return "`unit`";
  for (const auto& [ending, unit] : kUnits)
    if (use.key.ends_with(ending)) return unit;
  return "";
}

// `|` would end a cell.
std::string cell(std::string text) {
  for (std::size_t at = 0; (at = text.find('|', at)) != std::string::npos; at += 2) text.insert(at, "\\");
  return text;
}

std::string row_of(const KeyUse& use, bool recipe) {
  std::string usual = use.required           ? "required"
                      : use.defaults.empty() ? ""
                                             : fmt::format("`{}`", fmt::join(use.defaults, "` or `"));
  return fmt::format("| `{}` | {} | {} | {} | {} |\n", use.key, use.type, unit_of(use, recipe),
                     cell(fmt::format("{}", fmt::join(use.ranges, "; or "))), cell(usual));
}

// The keys of a table together, tables in the order of their first key.
std::vector<KeyUse> by_table(std::vector<KeyUse> keys) {
  std::vector<std::string> tables;
  const auto place = [&](const KeyUse& use) {
    const std::string table = use.key.substr(0, use.key.rfind('.') == std::string::npos ? 0 : use.key.rfind('.'));
    return std::ranges::find(tables, table) - tables.begin();
  };
  for (const KeyUse& use : keys)
    if (const auto at = place(use); at == std::ssize(tables))
      tables.push_back(use.key.substr(0, use.key.rfind('.') == std::string::npos ? 0 : use.key.rfind('.')));
  std::ranges::stable_sort(keys, {}, place);
  return keys;
}

}  // namespace

std::string key_reference() {
  std::string text =
      "# Keys of the TOML files\n\n"
      "The program writes this page (`tactbench reference-keys`), from what its own parsers ask for. An unknown key is "
      "an error,\n"
      "which names the line and the nearest known key. A value is a number alone; its unit is in the key. `[]` stands "
      "for each element of\n"
      "a list of tables, `NAME` for a name of yours. *required*: there is no default; in a table that may be left out, "
      "or with certain\n"
      "values of other keys, only there. A key with neither may be left out, and nothing stands in for it. Several "
      "ranges or defaults:\n"
      "it depends on other keys which one counts, as do those of `trip_psi` (from `command_psi` on), `high_mm`, "
      "`inner_diameter_mm`,\n"
      "`row` and `column` (the array's), `title` (the name), `peak_n` (from the contact's force on), `value` (from "
      "`low` to `high`).\n";
  for (const FileKind& kind : file_kinds()) {
    const KeyRecorder recorder(kind.name);
    kind.read();
    text += fmt::format("\n## {}\n{}\n\n| key | type | unit | range | default |\n|---|---|---|---|---|\n", kind.title,
                        kind.about);
    for (const KeyUse& use : by_table(recorder.keys()))
      if (!use.type.empty()) text += row_of(use, std::string(kind.title) == "Recipe");
  }
  return text;
}

}  // namespace tactbench::bench
