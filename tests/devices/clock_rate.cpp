// A steady clock that runs faster or slower than real time, and the versions of the libraries.
#include <modbus.h>

#include <catch2/catch.hpp>
#include <chrono>
#include <pugixml.hpp>
#include <string>
#include <thread>

#include "devices/clock.h"
#include "devices/library_versions.h"

using namespace tactbench::devices;
using namespace std::chrono_literals;

namespace {

using Real = std::chrono::steady_clock;

}  // namespace

TEST_CASE("clock: a steady clock's time is real time by its rate, seen from outside") {
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

TEST_CASE("clock: a wait lasts as long as the rate makes it, and ends after the time waited for") {
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

TEST_CASE("library versions: each library by its own number") {
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
  // pugixml tells its version as one number: 1 for the main one, two digits for the minor one, one for a patch.
  const std::string digits = std::to_string(PUGIXML_VERSION);
  REQUIRE(digits.size() == 4);
  const std::string minor = digits.substr(1, 2);
  CHECK(versions[3].second == digits.substr(0, 1) + "." + (minor[0] == '0' ? minor.substr(1) : minor));
}
