#include <modbus.h>

#include <catch2/catch.hpp>
#include <chrono>
#include <pugixml.hpp>
#include <string>
#include <thread>
#include <type_traits>

#include "devices/clock.h"
#include "devices/library_versions.h"
#include "devices/units.h"

using namespace tactbench::devices;
using namespace std::chrono_literals;

static_assert(!std::is_convertible_v<double, Psi>, "a bare number is no pressure");
static_assert(!std::is_convertible_v<Volts, Psi> && !std::is_constructible_v<Psi, Volts>, "volts are no pressure");

TEST_CASE("units: conversions agree with published values") {
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

TEST_CASE("clock: a simulated clock advances only by waits and lost replies, and never goes back") {
  ManualClock clock;
  CHECK(clock.now() == 0ns);
  clock.wait_until(2s);
  CHECK(clock.now() == 2s);
  clock.wait_until(1s);
  CHECK(clock.now() == 2s);
  clock.reply_lost(500ms);
  CHECK(clock.now() == 2500ms);
}

TEST_CASE("clock: a lost reply does not advance a steady clock") {
  SteadyClock clock;
  const auto before = clock.now();
  clock.reply_lost(1h);  // real waiting has already moved it
  CHECK(clock.now() - before < 30min);
}

namespace {

using Real = std::chrono::steady_clock;

}  // namespace

TEST_CASE("clock: the time of a steady clock is real time multiplied by its rate") {
  for (const double rate : {1.0, 0.25, 1.2, 4.0, 1000.0}) {
    INFO("rate " << rate);
    const auto before_it = Real::now();
    const SteadyClock clock(rate);
    const auto after_it = Real::now();
    std::this_thread::sleep_for(5ms);
    for (int i = 0; i < 5; ++i) {
      const auto least = std::chrono::duration<double, std::nano>(Real::now() - after_it);
      const double now = static_cast<double>(clock.now().count());
      const auto most = std::chrono::duration<double, std::nano>(Real::now() - before_it);
      CHECK(now >= least.count() * rate - 1000.0);
      CHECK(now <= most.count() * rate + 1000.0);
    }
  }
}

TEST_CASE("clock: a wait on a steady clock lasts as long as its rate requires, and ends at or after its time") {
  for (const double rate : {0.5, 1.0, 1000.0}) {
    INFO("rate " << rate);
    SteadyClock clock(rate);
    const auto aim = std::chrono::duration_cast<Nanoseconds>(20ms * rate);
    const auto begin = Real::now();
    clock.wait_until(aim);
    CHECK(clock.now() >= aim);
    CHECK(Real::now() - begin > 10ms);
    CHECK(Real::now() - begin < 10s);  // 20 ms and what a busy machine adds
    const auto again = Real::now();
    clock.wait_until(aim);  // gone by
    CHECK(Real::now() - again < 10s);
  }
}

TEST_CASE("library versions: each device library has its own version number") {
  const auto versions = library_versions();
  REQUIRE(versions.size() == 5);
  const char* names[] = {"libmodbus", "libserialport", "hidapi", "pugixml", "Eigen"};
  for (std::size_t i = 0; i < versions.size(); ++i) {
    INFO(versions[i].first << " " << versions[i].second);
    CHECK(versions[i].first == names[i]);
    CHECK(versions[i].second.find_first_not_of("0123456789.") == std::string::npos);
    CHECK(versions[i].second.find('.') != std::string::npos);
  }
  CHECK(versions[0].second.starts_with(LIBMODBUS_VERSION_STRING));
  // pugixml reports its version as one number: 1 for the main one, two digits for the minor one, one for a patch.
  const std::string digits = std::to_string(PUGIXML_VERSION);
  REQUIRE(digits.size() == 4);
  const std::string minor = digits.substr(1, 2);
  CHECK(versions[3].second == digits.substr(0, 1) + "." + (minor[0] == '0' ? minor.substr(1) : minor));
}
