#include "tests/support/paths.h"

#include <cstdlib>

namespace tactbench::tests {

std::string source_path(const std::string& below) { return std::string(TACTBENCH_SOURCE_FOLDER) + "/" + below; }
std::string program_path() {
  const char* other = std::getenv("TACTBENCH_TEST_PROGRAM");  // with a mutant in it (tests/mutants)
  return other != nullptr && *other != '\0' ? other : TACTBENCH_PROGRAM;
}
std::string fake_nidaqmx_path() { return TACTBENCH_FAKE_NIDAQMX; }
std::string power_cut_path() { return TACTBENCH_POWER_CUT_LIBRARY; }

}  // namespace tactbench::tests
