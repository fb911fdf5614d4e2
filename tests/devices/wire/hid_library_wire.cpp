#include "devices/wire/hid_link.h"

#include <catch2/catch.hpp>

#include "tests/devices/test_chamber.h"

using namespace tactbench::devices;

TEST_CASE("hid link: the error for an absent device lists those present") {
  const auto fault = fault_of([] { (void)open_hid_link({0xFFF7, 0xFFF3, "NOBODY"}); });
  REQUIRE(fault);
  CHECK(fault->id() == "TB-HID-OPEN");
  CHECK_THAT(fault->what(), Catch::Contains("fff7:fff3") && Catch::Contains("NOBODY") && Catch::Contains("present"));
  CHECK_FALSE(fault->remedy().empty());
}
