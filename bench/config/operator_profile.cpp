#include "bench/config/operator_profile.h"

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <utility>

#include "analysis/pressure_unit.h"
#include "db/utf8.h"
#include "sequences/toml/strict_toml.h"

namespace tactbench::bench {

namespace {

// "descending, ascending" as two names.
std::vector<std::string> names_between_commas(const sequences::TomlTable& table, const std::string& key) {
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

const char* to_string(ProfileKey key) {
  switch (key) {
    case ProfileKey::kBench:
      return "bench";
    case ProfileKey::kDb:
      return "db";
    case ProfileKey::kOperator:
      return "operator";
    case ProfileKey::kRecipe:
      return "recipe";
    case ProfileKey::kUnits:
      return "units";
    case ProfileKey::kLimits:
      return "limits";
    case ProfileKey::kFleet:
      break;
  }
  return "fleet";
}

std::string variable_of(ProfileKey key) {
  if (key == ProfileKey::kBench) return "TACTBENCH_BENCH";
  if (key == ProfileKey::kFleet) return "TACTBENCH_FLEET";
  return key == ProfileKey::kDb ? "TACTBENCH_DB" : "";
}

namespace {

OperatorProfile profile_of(const sequences::TomlDocument& document) {
  OperatorProfile profile;
  const sequences::TomlTable root = document.root();
  (void)root.integer("schema", 1, 1, 1);
  for (const ProfileKey key : kProfileKeys) {
    const std::string name = to_string(key);
    if (!root.has(name)) continue;
    ProfileValue value;
    if (key == ProfileKey::kRecipe)
      value.values = names_between_commas(root, name);
    else
      value.values = {root.name(name)};
    if (key == ProfileKey::kUnits && !analysis::PressureUnit::from(value.values.front()))
      root.fail(name, "'units' is '" + value.values.front() + "'", "use kPa, bar or psi");
    const std::vector<sequences::Setting>& read = document.settings();
    value.origin = std::ranges::find(read, name, &sequences::Setting::key)->origin;
    profile[key] = value;
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
  return profile;
}

}  // namespace tactbench::bench
