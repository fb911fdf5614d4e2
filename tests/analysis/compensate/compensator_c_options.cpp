// Each number of the C API's setup reaches the compensator: the stream is that of the C++ side with the same number,
// and another one than by default.
#include <catch2/catch.hpp>
#include <cstdint>
#include <vector>

#include "analysis/compensate/compensator_c.h"
#include "tests/analysis/compensate/frames.h"

using namespace synthetic;

namespace {

constexpr std::size_t kArrayTaxels = 8;

struct Streams {
  std::vector<float> pressure, uncertainty;
  std::vector<std::uint16_t> status;
  std::size_t refused = 0;
  bool operator==(const Streams&) const = default;
};

// Half of the frames, `lost` lost ones, a third of the rest, a tare to the lowest outputs and 3000 counts more, the
// rest.
template <class Frame, class Lost, class Tare>
Streams streamed(const Frames& frames, int lost, const Frame& frame, const Lost& lose, const Tare& tare) {
  Streams streams;
  const std::size_t count = frames.pressure.size();
  std::vector<std::uint16_t> unloaded;
  for (const TaxelSetup& taxel : frames.setup.taxels)
    unloaded.push_back(
        static_cast<std::uint16_t>(std::lround(taxel.ascending_v.front() / frames.setup.volts_per_count) + 3000));
  for (std::size_t f = 0; f < count; ++f) {
    if (f == count / 2)
      for (int i = 0; i < lost; ++i) lose();
    if (f == 2 * count / 3) streams.refused = tare(unloaded);
    frame(frames.at(f), streams);
  }
  return streams;
}

Streams of_c(const Frames& frames, int lost, const tb_compensator_setup& options, std::uint32_t flags) {
  tb_compensator_setup setup = c_setup_of(frames.setup, flags);
  setup.longest_gap = options.longest_gap;
  setup.flat_pressure = options.flat_pressure;
  setup.known_pressure = options.known_pressure;
  setup.tare_share = options.tare_share;
  std::vector<tb_compensator_taxel> taxels;
  for (const TaxelSetup& own : frames.setup.taxels) taxels.push_back(c_taxel_of(own));
  tb_compensator* handle = nullptr;
  char message[80];
  REQUIRE(tb_compensator_create(&setup, taxels.data(), &handle, message, sizeof message) == TB_COMPENSATOR_OK);
  const auto frame = [&](std::span<const std::uint16_t> counts, Streams& streams) {
    const std::size_t at = streams.pressure.size();
    streams.pressure.resize(at + kArrayTaxels);
    streams.uncertainty.resize(at + kArrayTaxels);
    streams.status.resize(at + kArrayTaxels);
    CHECK(tb_compensator_counts(handle, counts.data(), kArrayTaxels, &streams.pressure[at], &streams.uncertainty[at],
                                &streams.status[at]) == 0);
  };
  const Streams streams = streamed(
      frames, lost, frame, [&] { CHECK(tb_compensator_lost_frame(handle) == 0); },
      [&](const std::vector<std::uint16_t>& counts) {
        std::size_t refused = 0;
        CHECK(tb_compensator_tare(handle, counts.data(), kArrayTaxels, &refused) == 0);
        return refused;
      });
  tb_compensator_destroy(handle);
  return streams;
}

Streams of_cpp(const Frames& frames, int lost, const FrameSetup& setup) {
  FrameCompensator<float> compensator(setup);
  Results<float> results(kArrayTaxels);
  return streamed(
      frames, lost,
      [&](std::span<const std::uint16_t> counts, Streams& streams) {
        compensator.frame(counts, results.output());
        streams.pressure.insert(streams.pressure.end(), results.pressure.begin(), results.pressure.end());
        streams.uncertainty.insert(streams.uncertainty.end(), results.uncertainty.begin(), results.uncertainty.end());
        streams.status.insert(streams.status.end(), results.status.begin(), results.status.end());
      },
      [&] { compensator.lost_frame(results.output()); },
      [&](const std::vector<std::uint16_t>& counts) { return compensator.tare(counts); });
}

}  // namespace

TEST_CASE("C API: each number of the setup is the compensator's own, and 0 its default") {
  const Frames frames = random_reversals(static_cast<int>(kArrayTaxels), 600, 0.03, 0.9, 30.0);
  FrameSetup by_default = frames.setup;
  by_default.start_unknown = true;
  constexpr int kLost = 3;
  const Streams plain = of_cpp(frames, kLost, by_default);
  CHECK(of_c(frames, kLost, {}, 0) == plain);
  const auto same = [&](const char* what, const tb_compensator_setup& given, const FrameSetup& own,
                        std::uint32_t flags = 0) {
    INFO(what);
    const Streams expected = of_cpp(frames, kLost, own);
    CHECK(of_c(frames, kLost, given, flags) == expected);
    CHECK_FALSE(expected == plain);
  };
  const auto number = [&](const char* what, auto change) {
    FrameSetup own = by_default;
    tb_compensator_setup given{};
    change(given, own);
    same(what, given, own);
  };
  number("longest_gap", [](auto& given, auto& own) {
    given.longest_gap = 2;
    own.longest_gap = 2;
  });
  number("flat_pressure", [](auto& given, auto& own) { given.flat_pressure = own.options.flat_psi = 0.5; });
  number("known_pressure", [](auto& given, auto& own) { given.known_pressure = own.options.known_psi = 6.0; });
  number("tare_share", [](auto& given, auto& own) { given.tare_share = own.tare_share = 0.01; });
  FrameSetup own = by_default;
  own.start_unknown = false;
  same("start at rest", {}, own, TB_COMPENSATOR_START_AT_REST);
  own = by_default;
  own.elam.exact_outer = true;
  same("exact outer", {}, own, TB_COMPENSATOR_EXACT_OUTER);
}

TEST_CASE("C API: the longest gap is what it says, up to the largest number") {
  const Frames frames = random_reversals(static_cast<int>(kArrayTaxels), 60, 0.002, 0.9);
  const auto unknown = [&](std::uint32_t longest, int lost) {
    tb_compensator_setup given{};
    given.longest_gap = longest;
    const Streams streams = of_c(frames, lost, given, TB_COMPENSATOR_START_AT_REST);
    return (streams.status[30 * kArrayTaxels] & TB_TAXEL_UNKNOWN) != 0;
  };
  CHECK_FALSE(unknown(2, 2));
  CHECK(unknown(2, 3));
  CHECK_FALSE(unknown(0, 10));
  CHECK(unknown(0, 11));
  CHECK_FALSE(unknown(0xffffffffU, 50));
}
