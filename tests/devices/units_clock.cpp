#include <catch2/catch.hpp>
#include <type_traits>

#include "devices/clock.h"
#include "devices/units.h"

using namespace tactbench::devices;
using namespace std::chrono_literals;

static_assert(!std::is_convertible_v<double, Psi>, "a bare number is no pressure");
static_assert(!std::is_convertible_v<Volts, Psi> && !std::is_constructible_v<Psi, Volts>, "volts are no pressure");

TEST_CASE("units: conversions against published values") {
  CHECK(9.0 * kPsiPerBar == Approx(130.534).epsilon(1e-5));  // 9 bar = 130.5 psi
  CHECK(kilopascals(Psi(60.0)) == Approx(413.6854).epsilon(1e-6));
  CHECK(kilopascals(Psi(kPsiPerBar)) == Approx(100.0));
}

TEST_CASE("units: arithmetic and order stay within one unit") {
  CHECK((Psi(40.0) + Psi(20.0) - Psi(10.0)) == Psi(50.0));
  CHECK(Psi(30.0) / Psi(60.0) == 0.5);
  CHECK((-Psi(2.0) * 3.0).value() == -6.0);
  CHECK(Psi(59.9) < Psi(60.0));
  CHECK_FALSE(Psi(std::nan("")) <= Psi(60.0));
}

TEST_CASE("clock: a turned clock moves only when turned and never back") {
  TurnedClock clock;
  CHECK(clock.now() == 0ns);
  clock.wait_until(2s);
  CHECK(clock.now() == 2s);
  clock.wait_until(1s);
  CHECK(clock.now() == 2s);
  clock.reply_lost(500ms);
  CHECK(clock.now() == 2500ms);
}

TEST_CASE("clock: a steady clock has passed the time waited for") {
  SteadyClock clock;
  const auto aim = clock.now() + 1ms;
  clock.wait_until(aim);
  CHECK(clock.now() >= aim);
  const auto before = clock.now();
  clock.reply_lost(1h);  // real waiting has already moved it
  CHECK(clock.now() - before < 30min);
}
