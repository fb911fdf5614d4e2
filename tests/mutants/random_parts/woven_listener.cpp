// Writes which places of mutants each test reached, a line a test, to the file that TACTBENCH_MUTANTS_REACHED names:
// seconds, the numbers with commas between, the test's name. The first line is of no test: what was reached before.
#define CATCH_CONFIG_EXTERNAL_INTERFACES
#include <catch2/catch.hpp>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <fstream>

#include "tests/mutants/random_parts/woven.h"

namespace tactbench::mutants {
namespace {

struct Reached : Catch::TestEventListenerBase {
  using TestEventListenerBase::TestEventListenerBase;

  void testRunStarting(const Catch::TestRunInfo&) override { write(""); }
  void testCaseStarting(const Catch::TestCaseInfo&) override { begun = std::chrono::steady_clock::now(); }
  void testCaseEnded(const Catch::TestCaseStats& stats) override { write(stats.testInfo.name); }

  void write(const std::string& name) {
    const char* path = std::getenv("TACTBENCH_MUTANTS_REACHED");
    if (path == nullptr) return;
    on(0);
    std::ofstream out(path, std::ios::app);
    out << std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count() << '\t';
    for (int i = 0; i < int(sizeof(control->reached)); ++i)
      if (control->reached[i] != 0) out << i << ',';
    out << '\t' << name << '\n';
    std::memset(control->reached, 0, sizeof(control->reached));
  }

  std::chrono::steady_clock::time_point begun = std::chrono::steady_clock::now();
};

CATCH_REGISTER_LISTENER(Reached)

}  // namespace
}  // namespace tactbench::mutants
