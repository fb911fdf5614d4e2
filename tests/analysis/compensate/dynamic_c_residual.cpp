// What a dynamic model leaves, through the C API: by interval and direction, times a taxel's scale.
#include <catch2/catch.hpp>

#include "analysis/compensate/compensator_c.h"

namespace {

// 0 to 60 psi in two intervals: 0, 1 and 3 V going up, 3, 2 and 0 V coming down.
constexpr double kTwoIntervals[] = {0, 1, 0, 3, 1, 0}, kLeftPsi[] = {0.5, 0.6, 0.7, 0.8};

tb_compensator* with_residual(const double* residual, double scale) {
  tb_dynamic_setup setup{};
  setup.struct_size = sizeof setup;
  setup.flags = TB_COMPENSATOR_START_AT_REST | TB_COMPENSATOR_DOUBLE;
  setup.taxels = 1;
  setup.intervals = 2;
  setup.pressure_high = 60.0;
  setup.volts_per_count = 1e-6;
  setup.residual = residual;
  setup.top_share = -1.0;
  tb_dynamic_taxel taxel{};
  taxel.struct_size = sizeof taxel;
  taxel.flags = TB_TAXEL_USABLE;
  taxel.everett = kTwoIntervals;
  taxel.residual_scale = scale;
  tb_compensator* handle = nullptr;
  char message[80] = "";
  const int code = tb_compensator_create_dynamic(&setup, &taxel, &handle, message, sizeof message);
  INFO(message);
  REQUIRE(code == TB_COMPENSATOR_OK);
  return handle;
}

}  // namespace

TEST_CASE("C API by hand: a dynamic model's residual is that of the interval and the direction, times the scale") {
  for (const double scale : {1.0, 2.0, 0.0}) {  // 0 stands for 1
    tb_compensator* const handle = with_residual(kLeftPsi, scale);
    const double times = scale == 0.0 ? 1.0 : scale;
    const double way[][3] = {{0.5, 15, 0.5}, {2, 45, 0.6}, {3, 60, 0.6}, {2.5, 45, 0.8}, {1, 15, 0.7}};
    for (const auto& [volts, psi, left] : way) {
      CAPTURE(scale, volts);
      double pressure = 0.0, uncertainty = 0.0;
      REQUIRE(tb_compensator_volts_double(handle, &volts, 1, &pressure, &uncertainty, nullptr) == TB_COMPENSATOR_OK);
      CHECK(pressure == Approx(psi).margin(1e-3));
      CHECK(uncertainty == Approx(times * left).epsilon(1e-3));
    }
    tb_compensator_destroy(handle);
  }
  tb_compensator* const none = with_residual(nullptr, 1.0);
  const double volts = 0.5;
  double pressure = 0.0, uncertainty = 1.0;
  CHECK(tb_compensator_volts_double(none, &volts, 1, &pressure, &uncertainty, nullptr) == TB_COMPENSATOR_OK);
  CHECK(uncertainty == Approx(0.0).margin(1e-3));
  tb_compensator_destroy(none);
}
