#include <fmt/format.h>
#include <CLI/Version.hpp>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <ctime>
#include <nlohmann/json_fwd.hpp>
#include <thread>

#include "bench/common/build_info.h"
#include "bench/common/utc.h"
#include "bench/selfcheck/selfcheck.h"
#include "db/library_versions.h"
#include "devices/library_versions.h"
#include "sequences/library_versions.h"

namespace tactbench::bench {

namespace {

using SteadyTime = std::chrono::steady_clock;

SelfcheckAnswer steady_reads() {
  constexpr int kReads = 200'000;
  std::int64_t backwards = 0;
  auto before = SteadyTime::now();
  auto smallest = SteadyTime::duration::max();
  for (int i = 0; i < kReads; ++i) {
    const auto now = SteadyTime::now();
    if (now < before) ++backwards;
    if (now > before) smallest = std::min(smallest, now - before);
    before = now;
  }
  const auto tick = std::chrono::duration_cast<std::chrono::nanoseconds>(smallest).count();
  return {backwards == 0 && tick < 100'000, fmt::format("{} backwards, ticks of {} ns", backwards, tick)};
}

// The wall clock less the steady one, in ms: of many readings the one in which the least time passed between the two,
// for a process that has to wait for the processor in between would see that wait as a difference.
double wall_less_steady_ms() {
  using Milliseconds = std::chrono::duration<double, std::milli>;
  Milliseconds least = Milliseconds::max(), difference{};
  for (int i = 0; i < 100; ++i) {
    const Milliseconds before = SteadyTime::now().time_since_epoch();
    const Milliseconds wall = std::chrono::system_clock::now().time_since_epoch();
    const Milliseconds between = SteadyTime::now().time_since_epoch() - before;
    if (between < least) {
      least = between;
      difference = wall - before;
    }
  }
  return difference.count();
}

SelfcheckAnswer two_clocks() {
  const auto begun = SteadyTime::now();
  const double before_ms = wall_less_steady_ms();
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
  const double apart = std::abs(wall_less_steady_ms() - before_ms);
  const std::chrono::duration<double, std::milli> passed = SteadyTime::now() - begun;
  return {apart <= 3.0 && passed.count() >= 300.0,
          fmt::format("{:.3f} ms apart after {:.0f} ms", apart, passed.count())};
}

SelfcheckAnswer not_before_the_build() {
  const std::string now = utc_now();
  return {now.substr(0, 10) >= build_info().date, now};
}

}  // namespace

SelfcheckLines check_clocks() {
  SelfcheckLines lines;
  lines.push_back(
      selfchecked("clock", "steady clock, read 200000 times", "0 backwards, ticks below 100000 ns", steady_reads));
  lines.push_back(selfchecked("clock", "steady and wall clock over 300 ms", "at most 3 ms apart", two_clocks));
  lines.push_back(selfchecked("clock", "wall clock against the program's commit",
                              fmt::format("not before {}", build_info().date), not_before_the_build));
  return lines;
}

std::vector<std::pair<std::string, std::string>> library_versions() {
  std::vector<std::pair<std::string, std::string>> versions = db::library_versions();
  for (auto& version : devices::library_versions()) versions.push_back(std::move(version));
  for (auto& version : sequences::library_versions()) versions.push_back(std::move(version));
  versions.emplace_back("fmt",
                        fmt::format("{}.{}.{}", FMT_VERSION / 10000, FMT_VERSION / 100 % 100, FMT_VERSION % 100));
  versions.emplace_back("CLI11", CLI11_VERSION);
  versions.emplace_back("nlohmann-json", fmt::format("{}.{}.{}", NLOHMANN_JSON_VERSION_MAJOR,
                                                     NLOHMANN_JSON_VERSION_MINOR, NLOHMANN_JSON_VERSION_PATCH));
  std::ranges::sort(versions);
  return versions;
}

}  // namespace tactbench::bench
