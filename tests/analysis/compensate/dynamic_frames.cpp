// The dynamic frame compensator against its plain form, in float and double, on every vector level.
#include <catch2/catch.hpp>

#include "analysis/compensate/dynamic_frame_compensator.h"
#include "tests/analysis/compensate/frames.h"
#include "tests/analysis/compensate/straight_setup.h"
#include "tests/analysis/support/dynamic_plant.h"

using namespace synthetic;

namespace {

struct DynamicFrames {
  DynamicArray array;
  std::vector<double> pressure;
  std::vector<std::uint16_t> counts;  // frames x taxels
  [[nodiscard]] std::span<const std::uint16_t> at(std::size_t frame) const {
    return std::span(counts).subspan(frame * array.films.size(), array.films.size());
  }
};

// Steps short and long, halts, turns near the top and within the noise.
DynamicFrames frames_of(std::size_t taxels, std::size_t count, double noise_v, double seconds) {
  DynamicFrames frames{dynamic_array(taxels, noise_v), {}, {}};
  std::vector<double> way = random_way(count / 3, 1.5, 21);
  for (const double psi : random_way(count / 3, 0.05, 22)) way.push_back(psi);
  std::mt19937 random(5);
  std::uniform_real_distribution<double> level(0.0, 60.0);
  while (way.size() < count) way.push_back(way.size() % 4 == 0 ? level(random) : way.back());
  std::vector<DynamicPlant> plants;
  for (std::size_t t = 0; t < taxels; ++t)
    plants.emplace_back(frames.array.films[t], frames.array.setup.dynamics, frames.array.setup.taxels[t], 20);
  std::normal_distribution<double> normal(0.0, noise_v);
  for (const double psi : way) {
    frames.pressure.push_back(psi);
    for (DynamicPlant& plant : plants)
      frames.counts.push_back(static_cast<std::uint16_t>(
          std::clamp(std::lround((plant.step(psi, seconds) + normal(random)) * 65536.0 / 5.0), 0L, 65535L)));
  }
  return frames;
}

constexpr double kSeconds = 0.5;

}  // namespace

TEST_CASE("dynamic frames in double are those of the plain form, known or unknown start, on every level", "[dynamic]") {
  constexpr std::size_t kTaxels = 19;
  DynamicFrames frames = frames_of(kTaxels, 1500, 0.002, kSeconds);
  DynamicSetup& setup = frames.array.setup;
  setup.observer.share = 0.01;
  setup.residual_psi.assign(40, 0.1);
  std::fill_n(setup.residual_psi.begin(), 20, 0.3);  // rising
  const DynamicSetup plain_setup = with_rounding(setup);
  for (const Dispatch level : {Dispatch::kBase, Dispatch::kAvx2, Dispatch::kAvx512})
    for (const bool unknown : {false, true}) {
      setup.start_unknown = unknown;
      DynamicFrameCompensator<double> fast(setup);
      fast.set_interval(kSeconds);
      fast.set_dispatch(level);
      std::vector<DynamicTaxelCompensator> plain;
      for (std::size_t t = 0; t < kTaxels; ++t) {
        plain.emplace_back(plain_setup, t);
        if (unknown) plain.back().reset_unknown();
      }
      Results<double> out(kTaxels);
      double most = 0.0;
      int turns_seen = 0, unknowns = 0;
      for (std::size_t f = unknown ? 10 : 0; f < frames.pressure.size(); ++f) {
        fast.frame(frames.at(f), out.output());
        for (std::size_t t = 0; t < kTaxels; ++t) {
          const Compensated now = plain[t].step(frames.at(f)[t] * setup.volts_per_count, kSeconds);
          most = std::max(most, std::abs(now.pressure_psi - out.pressure[t]));
          REQUIRE(now.unknown == ((out.status[t] & kTaxelUnknown) != 0));
          REQUIRE(now.out_of_range == ((out.status[t] & kTaxelOutOfRange) != 0));
          unknowns += now.unknown ? 1 : 0;
          turns_seen += plain[t].ascending() ? 0 : 1;
          if (now.unknown) continue;
          const double residual = plain[t].ascending() ? 0.3 : 0.1;
          REQUIRE(out.uncertainty[t] >= 0.999 * residual);
          REQUIRE(now.uncertainty_psi >= 0.999 * residual);
        }
        INFO("frame " << f);
        REQUIRE(most < 1e-7);
      }
      CHECK(turns_seen > 100);
      CHECK((unknowns > 0) == unknown);
    }
}

// A block with few events attends them one by one, one with many in vectors: 3 of 19 taxels are in a block of their
// own.
TEST_CASE("dynamic frames have the residual of the level, direction and gain that the plain form has", "[dynamic]") {
  constexpr std::size_t kTaxels = 19;
  DynamicFrames frames = frames_of(kTaxels, 900, 0.0, kSeconds);
  DynamicSetup& setup = frames.array.setup;
  for (std::size_t k = 0; k < 40; ++k) setup.residual_psi.push_back(5.0 + static_cast<double>(k));
  for (DynamicTaxel& taxel : setup.taxels) taxel.divider.zero += 0.01;  // a gain to correct
  setup.taxels[2].residual_scale = setup.taxels[18].residual_scale = 0.5;
  setup.start_unknown = false;
  const DynamicSetup plain_setup = with_rounding(setup);
  for (const Dispatch level : {Dispatch::kBase, Dispatch::kAvx2, Dispatch::kAvx512}) {
    DynamicFrameCompensator<double> fast(setup);
    fast.set_interval(kSeconds);
    fast.set_dispatch(level);
    std::vector<DynamicTaxelCompensator> plain;
    for (std::size_t t = 0; t < kTaxels; ++t) plain.emplace_back(plain_setup, t);
    Results<double> out(kTaxels);
    int compared = 0, apart = 0, corrected = 0;
    for (std::size_t f = 0; f < frames.pressure.size(); ++f) {
      fast.frame(frames.at(f), out.output());
      for (std::size_t t = 0; t < kTaxels; ++t) {
        const Compensated now = plain[t].step(frames.at(f)[t] * setup.volts_per_count, kSeconds);
        ++compared;
        apart += std::abs(now.uncertainty_psi - out.uncertainty[t]) > 0.2 ? 1 : 0;
        corrected += plain[t].gain() != 1.0 ? 1 : 0;
      }
    }
    INFO(apart << " of " << compared << " apart, " << corrected << " with a gain");
    CHECK(corrected > compared / 4);
    CHECK(200 * apart < compared);
  }
}

TEST_CASE("dynamic frames in float are no further from the truth", "[dynamic]") {
  constexpr std::size_t kTaxels = 32;
  DynamicFrames frames = frames_of(kTaxels, 1500, 0.002, kSeconds);
  DynamicSetup& setup = frames.array.setup;
  DynamicFrameCompensator<double> whole(setup);
  DynamicFrameCompensator<float> single(setup);
  whole.set_interval(kSeconds);
  single.set_interval(kSeconds);
  CHECK(single.bytes_per_taxel() <= 2048);
  Results<double> a(kTaxels);
  Results<float> b(kTaxels);
  double whole_error = 0.0, single_error = 0.0, apart = 0.0;
  for (std::size_t f = 0; f < frames.pressure.size(); ++f) {
    whole.frame(frames.at(f), a.output());
    single.frame(frames.at(f), b.output());
    for (std::size_t t = 0; t < kTaxels; ++t) {
      whole_error += std::abs(a.pressure[t] - frames.pressure[f]);
      single_error += std::abs(static_cast<double>(b.pressure[t]) - frames.pressure[f]);
      apart += std::abs(a.pressure[t] - static_cast<double>(b.pressure[t]));
    }
  }
  const auto count = static_cast<double>(kTaxels * frames.pressure.size());
  INFO("double " << whole_error / count << " psi, float " << single_error / count << ", apart " << apart / count);
  CHECK(single_error < 1.01 * whole_error);
  CHECK(apart / count < 0.01);
}
