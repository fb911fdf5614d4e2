#include <catch2/catch.hpp>
#include <cmath>

#include "devices/pressure/analog_module.h"
#include "devices/pressure/pressure_reference.h"
#include "devices/pressure/regulator.h"
#include "tests/devices/test_chamber.h"

using namespace tactbench::devices;

namespace {

struct Unconnected {
  TurnedClock clock;
  AnalogModule module{module_profile("beckhoff-ek9000"), ModbusEndpoint{}, std::chrono::milliseconds(1000), clock,
                      Origin::kSimulated};
};

}  // namespace

TEST_CASE("analog module: 0x7FFF is 10 V, both ways") {
  const Unconnected rig;
  const LinearScale& volts = rig.module.profile().inputs.volts;
  CHECK(volts.physical(0x7FFF) == 10.0);
  CHECK(volts.physical(0) == 0.0);
  CHECK(volts.physical(-0x7FFF) == -10.0);
  CHECK(rig.module.counts(Volts(10.0)) == 0x7FFF);
  CHECK(rig.module.counts(Volts(5.0)) == 16384);  // 16383.5 rounds up
  CHECK(rig.module.counts(Volts(12.0)) == 0x7FFF);
  CHECK(rig.module.counts(Volts(-1.0)) == 0);
  CHECK(rig.module.counts(Volts(std::nan(""))) == 0);
  for (int counts = 0; counts <= 0x7FFF; ++counts) {
    if (rig.module.counts(Volts(volts.physical(counts))) != counts) FAIL("counts " << counts << " do not come back");
  }
}

TEST_CASE("regulator span: 60 psi of a 9 bar regulator are 4.596 V, 2 psi 0.1532 V") {
  LinearSpan span;
  span.high = Psi(9.0 * kPsiPerBar);
  CHECK(span.voltage(Psi(60.0)).value() == Approx(4.5965).margin(0.0005));
  CHECK(span.voltage(Psi(2.0)).value() == Approx(0.1532).margin(0.00005));
  CHECK(span.pressure(Volts(10.0)).value() == Approx(130.534).epsilon(1e-5));
  CHECK(span.pressure(span.voltage(Psi(37.5))).value() == Approx(37.5));
  const LinearSpan live_zero{Volts(1.0), Volts(5.0), Psi(0.0), Psi(100.0)};
  CHECK(live_zero.pressure(Volts(3.0)).value() == Approx(50.0));
  CHECK(live_zero.voltage(Psi(0.0)).value() == Approx(1.0));
}
