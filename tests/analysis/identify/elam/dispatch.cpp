// The vector levels of the processor, by which identification computes.
#include "analysis/identify/elam/dispatch.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <fstream>
#include <string>

using namespace tactbench::analysis;

TEST_CASE("the base vector level is always available, and the processor's best one is used") {
  CHECK(dispatches().front() == Dispatch::kBase);
  CHECK(std::ranges::is_sorted(dispatches()));
  CHECK(best_dispatch() == dispatches().back());
  CHECK(to_string(Dispatch::kBase) == std::string("base"));
  CHECK(to_string(Dispatch::kAvx2) == std::string("avx2"));
  CHECK(to_string(Dispatch::kAvx512) == std::string("avx512"));
}

#if defined(__x86_64__)
TEST_CASE("the vector levels are those that the processor's flags name") {
  std::ifstream file("/proc/cpuinfo");
  std::string line, flags;
  while (flags.empty() && std::getline(file, line))
    if (line.starts_with("flags")) flags = line + ' ';
  if (flags.empty()) {
    WARN("the processor's flags cannot be read here: not checked");
    return;
  }
  const auto has = [&](const std::string& flag) { return flags.find(' ' + flag + ' ') != std::string::npos; };
  const bool avx512 = has("avx512f") && has("avx512dq") && has("avx512bw") && has("avx512vl");
  CHECK(dispatches().size() == (!has("avx2") ? 1U : avx512 ? 3U : 2U));
}
#endif
