// Reads module profiles: shipped files of devices/profiles, or the user's own.
#pragma once

#include <string>
#include <vector>

#include "devices/pressure/module_profile.h"
#include "sequences/toml/strict_toml.h"

namespace tactbench::bench {

// `name` is a shipped profile ("beckhoff-ek9000") or the path of a .toml file. Throws sequences::FileError, which lists
// the shipped profiles when there is none of that name.
devices::ModuleProfile read_module_profile(const std::string& name);
std::vector<std::string> shipped_profiles();
std::vector<sequences::KeyFacts> module_profile_keys();

}  // namespace tactbench::bench
