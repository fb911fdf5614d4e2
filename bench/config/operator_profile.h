// Defaults for command-line options: tactbench.toml in the working folder, and environment variables, which take
// precedence over it; if neither names a bench file, bench.toml in the same folder. The command line takes precedence
// over all of them.
#pragma once

#include <array>
#include <map>
#include <string>
#include <vector>

#include "sequences/toml/strict_toml.h"

namespace tactbench::bench {

inline constexpr const char* kProfileFile = "tactbench.toml";
inline constexpr const char* kBenchHere = "bench.toml";  // in the same folder: the bench file if none is named
inline constexpr const char* kBenchHereOrigin = "found in this folder";

enum class ProfileKey { kBench, kDb, kOperator, kRecipe, kLimits, kLab, kFleet, kUnits };
inline constexpr std::array kProfileKeys = {ProfileKey::kBench,  ProfileKey::kDb,     ProfileKey::kOperator,
                                            ProfileKey::kRecipe, ProfileKey::kLimits, ProfileKey::kLab,
                                            ProfileKey::kFleet,  ProfileKey::kUnits};
const char* to_string(ProfileKey key);  // the key as in the file: "bench"
// "TACTBENCH_BENCH", "TACTBENCH_DB", "TACTBENCH_FLEET"; empty if the environment cannot give the value.
std::string variable_of(ProfileKey key);

struct ProfileValue {
  std::vector<std::string> values;  // one; for kRecipe one or more, separated by commas in the text
  std::string origin;               // "TACTBENCH_DB", "tactbench.toml:2", or kBenchHereOrigin
};
using OperatorProfile = std::map<ProfileKey, ProfileValue>;  // without the keys that have no value

// The values of the environment and of the file at `path`, which may be absent; a blank variable counts as unset. A
// bench.toml in the same folder is the bench if neither names one. Throws sequences::FileError: TB-FILE-KEY for an
// unknown key, with its line and the nearest known key.
OperatorProfile read_operator_profile(const std::string& path = kProfileFile);
// Only the file's values, from a text; `name` replaces the file name in error messages.
OperatorProfile parse_operator_profile(const std::string& text, const std::string& name);
std::vector<sequences::KeyFacts> operator_profile_keys();

}  // namespace tactbench::bench
