#include "bench/cli/words/key_list.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <set>
#include <stdexcept>

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

// The keys of a table together, tables in the order of their first key.
std::vector<KeyUse> by_table(std::vector<KeyUse> keys) {
  std::vector<std::string> tables;
  const auto place = [&](const KeyUse& use) { return std::ranges::find(tables, table_of(use.key)) - tables.begin(); };
  for (const KeyUse& use : keys)
    if (place(use) == std::ssize(tables)) tables.push_back(table_of(use.key));
  std::ranges::stable_sort(keys, {}, place);
  return keys;
}

// The line of a key, and which entries of the list were used.
class MeaningOf {
 public:
  explicit MeaningOf(const FileKind& kind) : kind_(kind) {}

  const char* operator()(const std::string& key) {
    for (const std::string& wanted : {key, "*." + key.substr(key.rfind('.') + 1)}) {
      const auto found = std::ranges::find_if(kind_.meanings, [&](const KeyMeaning& one) { return wanted == one.key; });
      if (found == kind_.meanings.end()) continue;
      used_.insert(wanted);
      return found->text;
    }
    missing_ = key;
    return "";
  }

  // Throws where a key has no line, or a line no key.
  void check() const {
    if (!missing_.empty())
      throw std::logic_error(fmt::format("bench/cli/words/meanings has no line for '{}' of {}", missing_, kind_.title));
    for (const KeyMeaning& one : kind_.meanings)
      if (!used_.contains(one.key))
        throw std::logic_error(
            fmt::format("bench/cli/words/meanings: '{}' of {} is a key that no parser reads, or stands there twice",
                        one.key, kind_.title));
    if (used_.size() != kind_.meanings.size())
      throw std::logic_error(fmt::format("bench/cli/words/meanings: a key of {} stands there twice", kind_.title));
  }

 private:
  const FileKind& kind_;
  std::set<std::string> used_;
  std::string missing_;
};

std::vector<KnownKey> keys_with(MeaningOf& meaning, const FileKind& kind) {
  const KeyRecorder recorder(kind.name);
  kind.read();
  std::vector<KnownKey> keys;
  for (const KeyUse& use : by_table(recorder.keys()))
    if (!use.type.empty()) keys.push_back({use, unit_of(use, std::string(kind.title) == "Recipe"), meaning(use.key)});
  return keys;
}

}  // namespace

std::string table_of(const std::string& key) {
  const std::size_t dot = key.rfind('.');
  return dot == std::string::npos ? std::string() : key.substr(0, dot);
}

std::vector<KnownKey> known_keys(const FileKind& kind) {
  MeaningOf meaning(kind);
  return keys_with(meaning, kind);
}

void check_meanings(const FileKind& kind) {
  MeaningOf meaning(kind);
  (void)keys_with(meaning, kind);
  meaning.check();
}

}  // namespace tactbench::bench
