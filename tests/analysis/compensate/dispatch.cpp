// Frames of every dispatch that the processor has: the same bits.
#include "analysis/identify/dispatch.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <fstream>
#include <limits>
#include <string>

#include "analysis/compensate/frame_compensator.h"
#include "tests/analysis/compensate/frames.h"

using namespace synthetic;

TEST_CASE("the base vector level is always available, and frames use the processor's best one") {
  CHECK(dispatches().front() == Dispatch::kBase);
  CHECK(std::ranges::is_sorted(dispatches()));
  CHECK(best_dispatch() == dispatches().back());
  const Frames frames = random_reversals(16, 10, 0.004, 0.3);
  FrameCompensator<float> fast(frames.setup);
  CHECK(fast.dispatch() == best_dispatch());
  fast.set_dispatch(Dispatch::kAvx512);  // what it lacks is not used
  CHECK(fast.dispatch() == best_dispatch());
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

TEST_CASE("every dispatch level gives the same bits") {
  WARN("best level here: " << to_string(best_dispatch()));
  // Up to 8 samples in a mean are read from tables, more are computed; 50 taxels are no whole blocks, 64 are.
  for (const int longest_mean : {1, 3, 8, 9, 20})
    for (const int taxels : {50, 64}) {
      Frames frames = random_reversals(taxels, 500, 0.004, 0.3);
      frames.setup.options.longest_mean = longest_mean;
      frames.setup.start_unknown = taxels == 50;
      const auto width = static_cast<std::size_t>(taxels);
      FrameCompensator<float> base(frames.setup);
      base.set_dispatch(Dispatch::kBase);
      Results<float> a(width), b(width);
      for (const Dispatch level : {Dispatch::kAvx2, Dispatch::kAvx512}) {
        base.reset();
        FrameCompensator<float> other(frames.setup);
        other.reset();
        other.set_dispatch(level);
        INFO(to_string(other.dispatch()) << ", " << taxels << " taxels, means of up to " << longest_mean);
        for (std::size_t f = 0; f < frames.pressure.size(); ++f) {
          base.frame(frames.at(f), a.output());
          other.frame(frames.at(f), b.output());
          REQUIRE(a.pressure == b.pressure);
          REQUIRE(a.uncertainty == b.uncertainty);
          REQUIRE(a.status == b.status);
        }
      }
    }
}

TEST_CASE("every dispatch level gives the same bits from volts, with some that are not numbers") {
  const Frames frames = random_reversals(48, 400, 0.004, 0.5);
  const auto same = [&](auto real) {
    using Real = decltype(real);
    FrameCompensator<Real> base(frames.setup);
    base.set_dispatch(Dispatch::kBase);
    Results<Real> a(48), b(48);
    std::vector<Real> volts(48);
    for (const Dispatch level : {Dispatch::kAvx2, Dispatch::kAvx512}) {
      base.reset();
      FrameCompensator<Real> other(frames.setup);
      other.set_dispatch(level);
      for (std::size_t f = 0; f < frames.pressure.size(); ++f) {
        for (std::size_t t = 0; t < 48; ++t)
          volts[t] = (f + 7 * t) % 31 == 0 ? std::numeric_limits<Real>::quiet_NaN()
                                           : static_cast<Real>(frames.at(f)[t] * frames.setup.volts_per_count);
        base.frame(std::span<const Real>(volts), a.output());
        other.frame(std::span<const Real>(volts), b.output());
        REQUIRE(a.pressure == b.pressure);
        REQUIRE(a.uncertainty == b.uncertainty);
        REQUIRE(a.status == b.status);
        REQUIRE(((a.status[0] & kTaxelLost) != 0) == (f % 31 == 0));
      }
    }
  };
  same(0.0F);
  same(0.0);
}
