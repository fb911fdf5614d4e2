#include "bench/cli/profile_options.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <utility>

#include "db/fleet/postgres.h"
#include "sequences/toml/strict_toml.h"

namespace tactbench::bench {

namespace {

std::string about_with_sources(const std::string& about, ProfileKey key) {
  const std::string variable = variable_of(key);
  return fmt::format("{} (otherwise by {}{})", about, variable.empty() ? "" : variable + " or ", kProfileFile);
}

}  // namespace

CLI::Option* ProfileOptions::add(CLI::App& verb, const std::string& names, ProfileKey key, std::string& value,
                                 const std::string& about) {
  CLI::Option* const option = verb.add_option(names, value, about_with_sources(about, key));
  return declare(verb, option, key, [&value](const ProfileValue& given) { value = given.values.front(); });
}

CLI::Option* ProfileOptions::add(CLI::App& verb, const std::string& names, ProfileKey key,
                                 std::vector<std::string>& values, const std::string& about) {
  CLI::Option* const option = verb.add_option(names, values, about_with_sources(about, key));
  return declare(verb, option, key, [&values](const ProfileValue& given) { values = given.values; });
}

CLI::Option* ProfileOptions::add_operator(CLI::App& verb, std::string& value) {
  return add(verb, "--operator", ProfileKey::kOperator, value, "name of the operator; recorded")->required();
}

CLI::Option* ProfileOptions::declare(CLI::App& verb, CLI::Option* option, ProfileKey key,
                                     std::function<void(const ProfileValue&)> take) {
  declared_.push_back({&verb, option, key, std::move(take)});
  // Before the verb's own words are read, which then overwrite what was filled in.
  verb.preparse_callback([this, &verb](std::size_t) { fill_in(verb); });
  return option;
}

const OperatorProfile& ProfileOptions::values() const {
  if (values_) return *values_;
  try {
    values_ = read_operator_profile(file_);
  } catch (const sequences::FileError&) {
    if (!tolerant_) throw;
    values_.emplace();
  }
  return *values_;
}

void ProfileOptions::fill_in(const CLI::App& verb) {
  const OperatorProfile& given = values();
  for (const Declared& declared : declared_) {
    const auto value = given.find(declared.key);
    if (declared.verb != &verb || value == given.end()) continue;
    declared.take(value->second);
    declared.option->required(false);
    declared.option->default_str(db::fleet::without_passwords(fmt::format("{}", fmt::join(value->second.values, " "))));
  }
}

}  // namespace tactbench::bench
