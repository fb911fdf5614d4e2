// Absolute paths of the source tree and of the built programs. The paths are in one source, so that
// all others are compiled alike in every checkout.
#pragma once

#include <string>

namespace tactbench::tests {

std::string source_path(const std::string& below);  // "sequences/nightly.toml": that file in the source tree
std::string program_path();                         // the program under test
std::string fake_nidaqmx_path();                    // the tests' own libnidaqmx.so
std::string power_cut_path();                       // what keeps only what a program synced (support/power_cut)

}  // namespace tactbench::tests
