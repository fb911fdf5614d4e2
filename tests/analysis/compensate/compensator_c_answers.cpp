// Each function of the C API against answers that are read off a loop on paper: pressures 0, 30 and 60, outputs 0, 1
// and 3 V on the way up, 3, 2 and 0 V on the way down. So 2 V are 45 going up, and 30 coming down.
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <type_traits>
#include <vector>

#include "analysis/compensate/compensator_c.h"

namespace {

constexpr double kVoltsPerCount = 1e-4;
constexpr double kLoopKnots[] = {0, 30, 60}, kLoopUp[] = {0, 1, 3}, kLoopDown[] = {0, 2, 3};
// A sensor whose output is 5 V less that of the first: its patterns are those of the negated output.
constexpr double kFallingUp[] = {-5, -4, -2}, kFallingDown[] = {-5, -3, -2};
// The same loop as rises between its three grid points: 0 to 30 is 1 V, 0 to 60 is 3 V, 30 to 60 (and back) is 1 V.
constexpr double kLoopEverett[] = {0, 1, 0, 3, 1, 0};

enum class LoopKind { kElam, kPreisach };

// Taxels: one that rises, one that is not usable, one that falls.
template <class Real>
class LoopHandle {
 public:
  explicit LoopHandle(LoopKind kind, std::uint32_t flags = TB_COMPENSATOR_START_AT_REST) {
    if (!std::is_same_v<Real, float>) flags |= TB_COMPENSATOR_DOUBLE;
    kind == LoopKind::kElam ? make_elam(flags) : make_preisach(flags);
  }
  LoopHandle(const LoopHandle&) = delete;
  LoopHandle& operator=(const LoopHandle&) = delete;
  ~LoopHandle() { tb_compensator_destroy(handle); }

  // The first taxel has this output, the falling one 5 V less it.
  int counts(double volts) {
    const std::uint16_t given[] = {counts_of(volts), counts_of(volts), counts_of(5.0 - volts)};
    if constexpr (std::is_same_v<Real, float>)
      return tb_compensator_counts(handle, given, 3, pressure, uncertainty, status);
    else
      return tb_compensator_counts_double(handle, given, 3, pressure, uncertainty, status);
  }
  int volts(double first, double third) {
    const Real given[] = {static_cast<Real>(first), static_cast<Real>(first), static_cast<Real>(third)};
    if constexpr (std::is_same_v<Real, float>)
      return tb_compensator_volts(handle, given, 3, pressure, uncertainty, status);
    else
      return tb_compensator_volts_double(handle, given, 3, pressure, uncertainty, status);
  }
  int tare(double volts, std::size_t* refused) {
    const std::uint16_t given[] = {counts_of(volts), counts_of(volts), counts_of(5.0 - volts)};
    return tb_compensator_tare(handle, given, 3, refused);
  }
  // Both taxels that count, from the last frame.
  void reads(double psi, int bits) const {
    for (const std::size_t taxel : {0U, 2U}) {
      CAPTURE(taxel);
      CHECK(pressure[taxel] == Approx(psi).margin(0.01));
      // How flat the loop is beside an unknown history is not what these loops tell.
      CHECK(((bits & TB_TAXEL_UNKNOWN) != 0 ? status[taxel] & ~TB_TAXEL_FLAT : status[taxel]) == bits);
    }
  }

  tb_compensator* handle = nullptr;
  Real pressure[3] = {}, uncertainty[3] = {};
  std::uint16_t status[3] = {};

 private:
  static std::uint16_t counts_of(double volts) {
    return static_cast<std::uint16_t>(std::lround(volts / kVoltsPerCount));
  }
  void make_elam(std::uint32_t flags) {
    tb_compensator_setup setup{};
    setup.struct_size = sizeof setup;
    setup.flags = flags | TB_COMPENSATOR_EXACT_OUTER;
    setup.taxels = setup.knots = 3;
    setup.pressure = kLoopKnots;
    setup.volts_per_count = kVoltsPerCount;
    tb_compensator_taxel taxels[3] = {};
    for (tb_compensator_taxel& taxel : taxels) {
      taxel.struct_size = sizeof taxel;
      taxel.alpha_d = taxel.beta_d = taxel.alpha_a0 = taxel.beta_a = 0.5;
    }
    taxels[0].flags = TB_TAXEL_USABLE;
    taxels[0].ascending = kLoopUp;
    taxels[0].descending = kLoopDown;
    taxels[2].flags = TB_TAXEL_USABLE | TB_TAXEL_FALLING;
    taxels[2].ascending = kFallingUp;
    taxels[2].descending = kFallingDown;
    char message[80] = "";
    const int code = tb_compensator_create(&setup, taxels, &handle, message, sizeof message);
    INFO(message);
    REQUIRE(code == TB_COMPENSATOR_OK);
  }
  void make_preisach(std::uint32_t flags) {
    tb_dynamic_setup setup{};
    setup.struct_size = sizeof setup;
    setup.flags = flags;
    setup.taxels = 3;
    setup.intervals = 2;
    setup.pressure_high = 60.0;
    setup.volts_per_count = kVoltsPerCount;
    tb_dynamic_taxel taxels[3] = {};
    for (tb_dynamic_taxel& taxel : taxels) {
      taxel.struct_size = sizeof taxel;
      taxel.everett = kLoopEverett;
    }
    taxels[0].flags = TB_TAXEL_USABLE;
    taxels[2].flags = TB_TAXEL_USABLE | TB_TAXEL_FALLING;
    taxels[2].zero_volts = -5.0;
    char message[80] = "";
    const int code = tb_compensator_create_dynamic(&setup, taxels, &handle, message, sizeof message);
    INFO(message);
    REQUIRE(code == TB_COMPENSATOR_OK);
  }
};

constexpr double kNoVolts = std::numeric_limits<double>::quiet_NaN();

}  // namespace

TEMPLATE_TEST_CASE("C API by hand: up and down the loop in counts and volts, and at rest again after a reset", "",
                   float, double) {
  const LoopKind kind = GENERATE(LoopKind::kElam, LoopKind::kPreisach);
  LoopHandle<TestType> loop(kind);
  CHECK(tb_compensator_abi_version() == 1);
  CHECK(tb_compensator_taxels(loop.handle) == 3);
  for (int turn = 0; turn < 2; ++turn) {
    for (const auto& [volts, psi] : {std::pair{0.0, 0.0},
                                     {0.5, 15.0},
                                     {1.0, 30.0},
                                     {2.0, 45.0},
                                     {3.0, 60.0},
                                     {2.5, 45.0},
                                     {2.0, 30.0},
                                     {1.0, 15.0},
                                     {0.5, 7.5}}) {
      CAPTURE(turn, volts);
      CHECK((turn == 0 ? loop.counts(volts) : loop.volts(volts, 5.0 - volts)) == TB_COMPENSATOR_OK);
      loop.reads(psi, TB_TAXEL_VALID);
      CHECK(loop.uncertainty[0] < 0.1);
      CHECK(loop.pressure[1] == 0.0);
      CHECK(loop.uncertainty[1] == 60.0);  // dead: the whole span
      CHECK(loop.status[1] == TB_TAXEL_DEAD);
    }
    // Half way down: without a reset 1 V would be 15 or so, and what follows on the way up not the loop's.
    CHECK(tb_compensator_reset(loop.handle) == TB_COMPENSATOR_OK);
    loop.counts(1.0);
    loop.reads(30.0, TB_TAXEL_VALID);
    loop.counts(2.0);
    loop.reads(45.0, TB_TAXEL_VALID);
    CHECK(tb_compensator_reset(loop.handle) == TB_COMPENSATOR_OK);
  }
  loop.counts(4.0);
  loop.reads(60.0, TB_TAXEL_OUT_OF_RANGE);
}

TEMPLATE_TEST_CASE("C API by hand: an unknown history lies between going up and coming down", "", float, double) {
  const LoopKind kind = GENERATE(LoopKind::kElam, LoopKind::kPreisach);
  const bool by_call = GENERATE(true, false);
  LoopHandle<TestType> loop(kind, by_call ? TB_COMPENSATOR_START_AT_REST : 0);
  if (by_call) CHECK(tb_compensator_reset_unknown(loop.handle) == TB_COMPENSATOR_OK);
  loop.counts(2.0);
  loop.reads(37.5, TB_TAXEL_VALID | TB_TAXEL_UNKNOWN);  // of 45 and 30
  CHECK(loop.uncertainty[0] == Approx(7.5).margin(0.01));
  loop.counts(3.0);  // where both meet the history is known
  loop.counts(2.0);
  loop.reads(30.0, TB_TAXEL_VALID);
}

TEMPLATE_TEST_CASE("C API by hand: lost frames and samples keep the pressure and say so", "", float, double) {
  const LoopKind kind = GENERATE(LoopKind::kElam, LoopKind::kPreisach);
  LoopHandle<TestType> loop(kind);
  loop.counts(2.0);
  CHECK(loop.volts(kNoVolts, 4.0) == TB_COMPENSATOR_OK);
  CHECK(loop.pressure[0] == Approx(45.0).margin(0.01));
  CHECK(loop.status[0] == TB_TAXEL_LOST);
  CHECK(loop.status[1] == TB_TAXEL_DEAD);
  CHECK(loop.status[2] == TB_TAXEL_VALID);
  CHECK(tb_compensator_reset(loop.handle) == TB_COMPENSATOR_OK);
  loop.counts(1.0);
  for (int lost = 0; lost < 10; ++lost) CHECK(tb_compensator_lost_frame(loop.handle) == TB_COMPENSATOR_OK);
  loop.counts(2.0);
  loop.reads(45.0, TB_TAXEL_VALID);
  for (int lost = 0; lost < 11; ++lost) CHECK(tb_compensator_lost_frame(loop.handle) == TB_COMPENSATOR_OK);
  loop.counts(2.0);
  loop.reads(37.5, TB_TAXEL_VALID | TB_TAXEL_UNKNOWN);
}

TEMPLATE_TEST_CASE("C API by hand: a tare moves the zero by a fifth of the span at most", "", float, double) {
  const LoopKind kind = GENERATE(LoopKind::kElam, LoopKind::kPreisach);
  LoopHandle<TestType> loop(kind);
  loop.counts(2.0);
  std::size_t refused = 9;
  CHECK(loop.tare(0.25, &refused) == TB_COMPENSATOR_OK);
  CHECK(refused == 0);
  for (const auto& [volts, psi] : {std::pair{0.25, 0.0}, {1.25, 30.0}, {2.25, 45.0}, {3.25, 60.0}, {2.25, 30.0}}) {
    CAPTURE(volts);
    loop.counts(volts);
    loop.reads(psi, TB_TAXEL_VALID);
  }
  CHECK(loop.tare(0.90, &refused) == TB_COMPENSATOR_OK);  // 0.65 V more: of 3 V a fifth is 0.6 V
  CHECK(refused == 2);
  CHECK(loop.tare(0.90, nullptr) == TB_COMPENSATOR_OK);
  loop.counts(2.25);
  loop.reads(37.5, TB_TAXEL_VALID | TB_TAXEL_UNKNOWN);
}

TEMPLATE_TEST_CASE("C API by hand: what lies outside the validity is marked as long as the caller says so", "", float,
                   double) {
  LoopHandle<TestType> loop(GENERATE(LoopKind::kElam, LoopKind::kPreisach));
  CHECK(tb_compensator_set_outside_validity(loop.handle, 1) == TB_COMPENSATOR_OK);
  loop.counts(1.0);
  loop.reads(30.0, TB_TAXEL_OUTSIDE);
  CHECK(tb_compensator_set_outside_validity(loop.handle, 0) == TB_COMPENSATOR_OK);
  loop.counts(1.0);
  loop.reads(30.0, TB_TAXEL_VALID);
}

TEST_CASE("C API by hand: nulls, sizes, the other precision and wrong seconds have their codes, function by function") {
  const LoopKind kind = GENERATE(LoopKind::kElam, LoopKind::kPreisach);
  LoopHandle<float> single(kind);
  LoopHandle<double> whole(kind);
  const std::uint16_t counts[] = {10000, 10000, 40000};
  const float f[] = {1, 1, 4};
  const double d[] = {1, 1, 4};
  float pf[3];
  double pd[3];
  CHECK(tb_compensator_counts(whole.handle, counts, 3, pf, nullptr, nullptr) == TB_COMPENSATOR_PRECISION);
  CHECK(tb_compensator_volts(whole.handle, f, 3, pf, nullptr, nullptr) == TB_COMPENSATOR_PRECISION);
  CHECK(tb_compensator_counts_double(single.handle, counts, 3, pd, nullptr, nullptr) == TB_COMPENSATOR_PRECISION);
  CHECK(tb_compensator_volts_double(single.handle, d, 3, pd, nullptr, nullptr) == TB_COMPENSATOR_PRECISION);
  CHECK(tb_compensator_counts(single.handle, counts, 2, pf, nullptr, nullptr) == TB_COMPENSATOR_SIZE);
  CHECK(tb_compensator_volts(single.handle, f, 4, pf, nullptr, nullptr) == TB_COMPENSATOR_SIZE);
  CHECK(tb_compensator_counts_double(whole.handle, counts, 2, pd, nullptr, nullptr) == TB_COMPENSATOR_SIZE);
  CHECK(tb_compensator_volts_double(whole.handle, d, 4, pd, nullptr, nullptr) == TB_COMPENSATOR_SIZE);
  CHECK(tb_compensator_tare(single.handle, counts, 2, nullptr) == TB_COMPENSATOR_SIZE);
  CHECK(tb_compensator_volts(nullptr, f, 3, pf, nullptr, nullptr) == TB_COMPENSATOR_NULL);
  CHECK(tb_compensator_volts(single.handle, nullptr, 3, pf, nullptr, nullptr) == TB_COMPENSATOR_NULL);
  CHECK(tb_compensator_volts(single.handle, f, 3, nullptr, nullptr, nullptr) == TB_COMPENSATOR_NULL);
  CHECK(tb_compensator_counts_double(nullptr, counts, 3, pd, nullptr, nullptr) == TB_COMPENSATOR_NULL);
  CHECK(tb_compensator_volts_double(whole.handle, d, 3, nullptr, nullptr, nullptr) == TB_COMPENSATOR_NULL);
  CHECK(tb_compensator_tare(single.handle, nullptr, 3, nullptr) == TB_COMPENSATOR_NULL);
  CHECK(tb_compensator_tare(nullptr, counts, 3, nullptr) == TB_COMPENSATOR_NULL);
  for (const auto function : {&tb_compensator_lost_frame, &tb_compensator_reset, &tb_compensator_reset_unknown})
    CHECK(function(nullptr) == TB_COMPENSATOR_NULL);
  CHECK(tb_compensator_set_outside_validity(nullptr, 1) == TB_COMPENSATOR_NULL);
  CHECK(tb_compensator_set_interval(nullptr, 1.0) == TB_COMPENSATOR_NULL);
  CHECK(tb_compensator_set_interval(single.handle, 0.0) == TB_COMPENSATOR_OK);
  for (const double seconds : {-1.0, kNoVolts, std::numeric_limits<double>::infinity()})
    CHECK(tb_compensator_set_interval(single.handle, seconds) == TB_COMPENSATOR_VALUE);
  // After all these refusals the state is as before, and results that nobody wants may be null.
  CHECK(tb_compensator_counts(single.handle, counts, 3, pf, nullptr, nullptr) == TB_COMPENSATOR_OK);
  CHECK((pf[0] == Approx(30.0).margin(0.01) && pf[2] == Approx(30.0).margin(0.01)));
  CHECK(tb_compensator_volts_double(whole.handle, d, 3, pd, nullptr, nullptr) == TB_COMPENSATOR_OK);
  CHECK((pd[0] == Approx(30.0).margin(0.01) && pd[2] == Approx(30.0).margin(0.01)));
}
