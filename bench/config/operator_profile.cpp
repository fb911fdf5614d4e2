#include "bench/config/operator_profile.h"

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <utility>

#include "analysis/pressure_unit.h"
#include "db/remarks.h"
#include "sequences/toml/key_table.h"

namespace tactbench::bench {

using sequences::KeyTable;
using sequences::TomlTable;
namespace key = sequences::key;

namespace {

// "descending, ascending" as two names.
std::vector<std::string> names_between_commas(const TomlTable& table, const std::string& key) {
  constexpr const char* kBlanks = " \t\r\n";
  std::vector<std::string> names;
  const std::string text = table.name(key);
  for (std::size_t from = 0, end = 0; end != std::string::npos; from = end + 1) {
    end = text.find(',', from);
    std::string name = text.substr(from, end == std::string::npos ? end : end - from);
    if (name.find_first_not_of(kBlanks) == std::string::npos)
      table.fail(key, "a name between the commas of '" + key + "' is empty", "write \"one\" or \"one, another\"");
    name.erase(0, name.find_first_not_of(kBlanks));
    name.erase(name.find_last_not_of(kBlanks) + 1);
    names.push_back(std::move(name));
  }
  return names;
}

}  // namespace

namespace {

struct ProfileRow {
  ProfileKey key;
  const char *name, *variable, *meaning;
};
constexpr std::array<ProfileRow, kProfileKeys.size()> kRows = {
    {{ProfileKey::kBench, "bench", "TACTBENCH_BENCH", "Bench file, default of --bench"},
     {ProfileKey::kDb, "db", "TACTBENCH_DB", "Store, default of --db"},
     {ProfileKey::kOperator, "operator", "", "Your name, default of --operator"},
     {ProfileKey::kRecipe, "recipe", "", "Default recipe of run and calibrate; several are separated by commas"},
     {ProfileKey::kLimits, "limits", "",
      "Limits file by which calibrate and judge give verdicts; run warns of limits that could not be judged"},
     {ProfileKey::kLab, "lab", "", "Laboratory file of reports and verdicts, default of --lab"},
     {ProfileKey::kFleet, "fleet", "TACTBENCH_FLEET",
      "Database of the fleet, for verbs that need one if TACTBENCH_FLEET is not set"},
     {ProfileKey::kUnits, "units", "", "Unit of printed pressures, default of --units"}}};

const ProfileRow& row_of(ProfileKey key) { return *std::ranges::find(kRows, key, &ProfileRow::key); }

KeyTable profile_keys(OperatorProfile& profile) {
  KeyTable keys = {key::described(key::made({"schema", "whole number", "1", "1", "", "Version of this file's format"},
                                            [](const TomlTable& table) { (void)table.integer("schema", 1, 1, 1); }),
                                  "`1`")};
  for (const ProfileRow& row : kRows) {
    const bool units = row.key == ProfileKey::kUnits;
    keys.push_back(
        key::optional(key::made({row.name, "text", "-", units ? "kPa, bar, psi" : "not blank", "", row.meaning},
                                [&profile, row, units](const TomlTable& table) {
                                  std::vector<std::string>& values = profile[row.key].values;
                                  if (row.key == ProfileKey::kRecipe)
                                    values = names_between_commas(table, row.name);
                                  else
                                    values = {table.name(row.name)};
                                  if (units && !analysis::PressureUnit::from(values.front()))
                                    table.fail(row.name, "'units' is '" + values.front() + "'", "use kPa, bar or psi");
                                })));
  }
  return keys;
}

}  // namespace

const char* to_string(ProfileKey key) { return row_of(key).name; }

std::string variable_of(ProfileKey key) { return row_of(key).variable; }

std::vector<sequences::KeyFacts> operator_profile_keys() {
  OperatorProfile profile;
  std::vector<sequences::KeyFacts> all;
  add_facts(all, "", profile_keys(profile));
  return all;
}

namespace {

OperatorProfile profile_of(const sequences::TomlDocument& document) {
  OperatorProfile profile;
  const TomlTable root = document.root();
  read_keys(root, profile_keys(profile));
  for (auto& [key, value] : profile) {
    const std::vector<sequences::Setting>& read = document.settings();
    value.origin = std::ranges::find(read, std::string(to_string(key)), &sequences::Setting::key)->origin;
  }
  root.finish();
  return profile;
}

}  // namespace

OperatorProfile parse_operator_profile(const std::string& text, const std::string& name) {
  return profile_of(sequences::TomlDocument::from_text(text, name));
}

OperatorProfile read_operator_profile(const std::string& path) {
  OperatorProfile profile;
  std::error_code unreadable;  // then reading it says so
  if (std::filesystem::exists(path, unreadable) || unreadable)
    profile = profile_of(sequences::TomlDocument::from_file(path));
  for (const ProfileKey key : kProfileKeys) {
    const std::string variable = variable_of(key);
    const char* const value = variable.empty() ? nullptr : std::getenv(variable.c_str());
    if (value != nullptr && !db::is_blank(value)) profile[key] = {{value}, variable};
  }
  const std::filesystem::path here = std::filesystem::path(path).replace_filename(kBenchHere);
  if (!profile.contains(ProfileKey::kBench) && std::filesystem::is_regular_file(here, unreadable))
    profile[ProfileKey::kBench] = {{here.string()}, kBenchHereOrigin};
  return profile;
}

}  // namespace tactbench::bench
