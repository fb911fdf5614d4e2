// What a model leaves, in the uncertainty of ELAM's frames: beside the plain form, and through the C API, whose structs
// may end before the members that came later.
#include <catch2/catch.hpp>
#include <cstddef>
#include <cstring>
#include <limits>

#include "analysis/compensate/compensator_c.h"
#include "analysis/compensate/residual_bins.h"
#include "tests/analysis/compensate/frames.h"

using namespace synthetic;

namespace {

constexpr std::size_t kResidualTaxels = 20, kLevels = 20;

// All values of all taxels differ, so that each tells where it was read: from 0.3 psi, as a fitted taxel leaves.
std::vector<double> residual_of(std::size_t taxel) {
  std::vector<double> psi;
  for (std::size_t k = 0; k < 2 * kLevels; ++k)
    psi.push_back(0.3 + 0.02 * static_cast<double>(k) + 0.0003 * static_cast<double>(taxel));
  return psi;
}

FrameSetup with_residuals(FrameSetup setup) {
  for (std::size_t t = 0; t < setup.taxels.size(); ++t) setup.taxels[t].residual_psi = residual_of(t);
  return setup;
}

// A caller's structs of any size up to ours, each in memory that ends with it.
struct Caller {
  std::vector<char> setup, taxels;
  std::vector<std::vector<double>> residuals;

  Caller(const FrameSetup& own, std::size_t setup_size, std::size_t taxel_size, std::size_t levels = kLevels,
         std::uint32_t flags = TB_COMPENSATOR_START_AT_REST | TB_COMPENSATOR_DOUBLE) {
    tb_compensator_setup whole = c_setup_of(own, flags);
    whole.struct_size = setup_size;
    whole.residual_levels = levels;
    setup.assign(reinterpret_cast<const char*>(&whole), reinterpret_cast<const char*>(&whole) + setup_size);
    for (std::size_t t = 0; t < own.taxels.size(); ++t) residuals.push_back(residual_of(t));
    for (std::size_t t = 0; t < own.taxels.size(); ++t) {
      tb_compensator_taxel taxel = c_taxel_of(own.taxels[t]);
      taxel.struct_size = taxel_size;
      taxel.residual = residuals[t].data();
      const char* const bytes = reinterpret_cast<const char*>(&taxel);
      taxels.insert(taxels.end(), bytes, bytes + taxel_size);
    }
    taxels.shrink_to_fit();
  }
  Caller(const Caller&) = delete;  // the taxels point to its residuals
  Caller& operator=(const Caller&) = delete;
  int create(tb_compensator** handle, std::string& why) const {
    char message[100] = "";
    const int code = tb_compensator_create(reinterpret_cast<const tb_compensator_setup*>(setup.data()),
                                           reinterpret_cast<const tb_compensator_taxel*>(taxels.data()), handle,
                                           message, sizeof message);
    why = message;
    return code;
  }
};

constexpr std::size_t kSetupOfBefore = offsetof(tb_compensator_setup, residual_levels),
                      kTaxelOfBefore = offsetof(tb_compensator_taxel, residual);

}  // namespace

TEST_CASE("residual in frames: noise and what the plain form's place leaves, at most one interval off") {
  for (const bool unknown : {false, true}) {
    const Frames frames = random_reversals(kResidualTaxels, 1500, 0.0015, 0.7, unknown ? 25.0 : 0.0);
    FrameSetup alone = frames.setup;
    alone.start_unknown = unknown;
    const std::vector<double>& knots = alone.pressure_psi;
    FrameCompensator<double> fast(with_residuals(alone)), noise(alone);
    std::vector<TaxelCompensator> plain = plain_of(frames, unknown);
    Results<double> with(kResidualTaxels), without(kResidualTaxels);
    int exact = 0, near = 0, all = 0, fallen = 0;
    double sum = 0.0, expected = 0.0;
    for (std::size_t f = 0; f < frames.pressure.size(); ++f) {
      fast.frame(frames.at(f), with.output());
      noise.frame(frames.at(f), without.output());
      REQUIRE(with.pressure == without.pressure);
      REQUIRE(with.status == without.status);
      for (std::size_t t = 0; t < kResidualTaxels; ++t) {
        const Compensated one = plain[t].step(frames.at(f)[t] * alone.volts_per_count);
        const std::vector<double> psi = residual_of(t);
        const ResidualBins bins{knots.front(), knots.back(), psi};
        const double u = with.uncertainty[t], u0 = without.uncertainty[t], residual = std::sqrt(u * u - u0 * u0);
        const std::size_t place = bins.place(one.pressure_psi, plain[t].ascending());
        const std::size_t first = place / kLevels * kLevels, last = first + kLevels - 1;
        const double tiny = 1e-9 * (1.0 + u * u);
        const bool is_near =
            residual >= psi[std::max(place, first + 1) - 1] - tiny && residual <= psi[std::min(place + 1, last)] + tiny;
        near += is_near ? 1 : 0;
        exact += std::abs(residual - psi[place]) < tiny ? 1 : 0;
        fallen += plain[t].ascending() ? 0 : 1;
        ++all;
        if (one.flat || one.unknown) continue;
        sum += u;
        expected += std::hypot(one.uncertainty_psi, psi[place]);
      }
    }
    INFO("unknown start " << unknown << ": " << all << " samples, exact " << exact << ", within an interval " << near
                          << ", falling " << fallen << ", mean over the plain form's " << sum / expected);
    CHECK(near > 0.9995 * all);  // half a piece, which on an inner curve may be longer than an interval
    CHECK(exact > 0.7 * all);
    CHECK(fallen > 0.3 * all);
    CHECK(sum / expected == Approx(1.0).margin(0.05));
  }
}

TEST_CASE("residual in frames: the same bits on each level, in counts and volts, after a loss, a tare and a reset") {
  const Frames frames = random_reversals(kResidualTaxels, 400, 0.002, 0.7);
  FrameSetup setup = with_residuals(frames.setup);
  setup.taxels[3].usable = false;
  setup.taxels[4].residual_psi.clear();
  FrameCompensator<float> base(setup), best(setup);
  base.set_dispatch(Dispatch::kBase);
  Results<float> a(kResidualTaxels), b(kResidualTaxels);
  for (std::size_t f = 0; f < frames.pressure.size(); ++f) {
    base.frame(frames.at(f), a.output());
    best.frame(frames.at(f), b.output());
    REQUIRE(a.uncertainty == b.uncertainty);
    REQUIRE(a.uncertainty[5] > 0.3F);
  }
  CHECK(a.uncertainty[3] == 60.0F);
  FrameCompensator<float> alone(frames.setup);
  Results<float> c(kResidualTaxels);
  for (std::size_t f = 0; f < frames.pressure.size(); ++f) alone.frame(frames.at(f), c.output());
  CHECK(a.uncertainty[4] == c.uncertainty[4]);  // not known: noise alone
  const float last = a.uncertainty[5];
  base.lost_frame(a.output());
  CHECK(a.uncertainty[5] == last);
  base.reset();
  base.lost_frame(a.output());
  CHECK(a.uncertainty[5] == static_cast<float>(residual_of(5).front()));
  CHECK(base.tare(frames.at(0)) == 0);
  base.frame(frames.at(0), a.output());
  CHECK(a.uncertainty[5] >= 0.3F);
  CHECK(a.uncertainty[5] < 0.5F);
}

TEST_CASE("residual in frames: wrong sizes and values are refused by taxel") {
  const Frames frames = random_reversals(4, 10, 0.001, 1.0);
  const auto refused = [&](const auto& spoil, const char* taxel = "taxel 2") {
    FrameSetup setup = with_residuals(frames.setup);
    spoil(setup.taxels[2].residual_psi);
    CHECK_THROWS_WITH(FrameCompensator<float>(setup), Catch::Contains(taxel));
  };
  refused([](std::vector<double>& psi) { psi.resize(38); });
  refused([](std::vector<double>& psi) { psi.push_back(0.1); }, "taxel 0");  // the others are of fewer than the most
  refused([](std::vector<double>& psi) { psi[7] = -0.1; });
  refused([](std::vector<double>& psi) { psi[39] = std::nan(""); });
  refused([](std::vector<double>& psi) { psi[0] = std::numeric_limits<double>::infinity(); });
  FrameSetup odd = frames.setup;
  for (TaxelSetup& taxel : odd.taxels) taxel.residual_psi.assign(3, 0.1);
  CHECK_THROWS_AS(FrameCompensator<double>(odd), std::invalid_argument);
  FrameSetup dead = with_residuals(frames.setup);
  dead.taxels[2].usable = false;
  dead.taxels[2].residual_psi = {-1.0};  // not read
  CHECK_NOTHROW(FrameCompensator<double>(dead));
}

TEST_CASE("C API: residuals reach the uncertainty, and structs that end before them work and give noise alone") {
  const Frames frames = random_reversals(kResidualTaxels, 300, 0.002, 0.7);
  FrameCompensator<double> fast(with_residuals(frames.setup)), noise(frames.setup);
  constexpr std::size_t kSetup = sizeof(tb_compensator_setup), kTaxel = sizeof(tb_compensator_taxel);
  static_assert(kSetupOfBefore < kSetup && kTaxelOfBefore < kTaxel);
  struct Sizes {
    std::size_t setup, taxel, levels = kLevels;
  };
  std::vector<tb_compensator*> handles;
  for (const Sizes& sizes :
       {Sizes{kSetup, kTaxel}, Sizes{kSetupOfBefore, kTaxel}, Sizes{kSetup, kTaxelOfBefore},
        Sizes{kSetupOfBefore, kTaxelOfBefore}, Sizes{kSetup, kTaxel, 0}, Sizes{kSetup - 1, kTaxel}}) {
    const Caller caller(frames.setup, sizes.setup, sizes.taxel, sizes.levels);
    std::string why;
    handles.push_back(nullptr);
    REQUIRE(caller.create(&handles.back(), why) == TB_COMPENSATOR_OK);
    CHECK(why.empty());
  }
  Results<double> with(kResidualTaxels), without(kResidualTaxels), given(kResidualTaxels);
  for (std::size_t f = 0; f < frames.pressure.size(); ++f) {
    fast.frame(frames.at(f), with.output());
    noise.frame(frames.at(f), without.output());
    for (std::size_t k = 0; k < handles.size(); ++k) {
      REQUIRE(tb_compensator_counts_double(handles[k], frames.at(f).data(), kResidualTaxels, given.pressure.data(),
                                           given.uncertainty.data(), given.status.data()) == TB_COMPENSATOR_OK);
      REQUIRE(given.pressure == with.pressure);
      REQUIRE(given.uncertainty == (k == 0 ? with.uncertainty : without.uncertainty));
    }
  }
  for (tb_compensator* const handle : handles) tb_compensator_destroy(handle);
}

TEST_CASE("C API: residuals of wrong values, too many levels and structs below version 1's are refused") {
  const Frames frames = random_reversals(4, 10, 0.002, 0.7);
  constexpr std::size_t kSetup = sizeof(tb_compensator_setup), kTaxel = sizeof(tb_compensator_taxel);
  tb_compensator* handle = nullptr;
  std::string why;
  CHECK(Caller(frames.setup, kSetupOfBefore - 8, kTaxel).create(&handle, why) == TB_COMPENSATOR_SIZE);
  CHECK(Caller(frames.setup, kSetup, kTaxelOfBefore - 8).create(&handle, why) == TB_COMPENSATOR_SIZE);
  CHECK(Caller(frames.setup, kSetup, kTaxel, 1001).create(&handle, why) == TB_COMPENSATOR_SIZE);
  CHECK_THAT(why, Catch::Contains("residual_levels"));
  CHECK(Caller(frames.setup, kSetup, kTaxel, std::numeric_limits<std::size_t>::max()).create(&handle, why) ==
        TB_COMPENSATOR_SIZE);
  for (const double wrong : {-0.1, std::nan("")}) {
    Caller caller(frames.setup, kSetup, kTaxel);
    caller.residuals[2][2 * kLevels - 1] = wrong;
    CHECK(caller.create(&handle, why) == TB_COMPENSATOR_VALUE);
    CHECK_THAT(why, Catch::Contains("taxel 2") && Catch::Contains("residual"));
  }
  CHECK(handle == nullptr);
}
