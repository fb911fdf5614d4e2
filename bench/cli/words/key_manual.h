// Manual pages of section 5: the keys of each TOML file that the program reads, with their meanings. The build makes
// and installs them from what the program says (bench/install/install.cmake).
#pragma once

#include <string>
#include <vector>

namespace tactbench::bench {

std::vector<std::string> key_manual_names();  // "tactbench-bench", ..., without the section
// In man(7) format; `date` as 2026-01-31. Throws as known_keys() does, Error TB-USAGE for another name.
std::string key_manual(const std::string& name, const std::string& version, const std::string& date);

}  // namespace tactbench::bench
