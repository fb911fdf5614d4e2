// Where the tests find the source tree and what was built beside them, absolute. The paths stand in one source, so that
// all others are compiled alike in every checkout.
#pragma once

#include <string>

namespace tactbench::tests {

std::string source_path(const std::string& below);  // "sequences/nightly.toml": that file in the source tree
std::string program_path();                         // the program under test
std::string fake_nidaqmx_path();                    // the tests' own libnidaqmx.so
std::string power_cut_path();                       // what keeps only what a program synced (support/power_cut)

}  // namespace tactbench::tests
