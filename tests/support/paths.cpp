#include "tests/support/paths.h"

namespace tactbench::tests {

std::string source_path(const std::string& below) { return std::string(TACTBENCH_SOURCE_FOLDER) + "/" + below; }
std::string program_path() { return TACTBENCH_PROGRAM; }
std::string fake_nidaqmx_path() { return TACTBENCH_FAKE_NIDAQMX; }

}  // namespace tactbench::tests
