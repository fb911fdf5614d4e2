#include "devices/wire/report_link.h"

#include <catch2/catch.hpp>

#include "tests/devices/test_chamber.h"

using namespace tactbench::devices;

TEST_CASE("hid link: an absent device is a fault that names it") {
  check_fault([] { (void)open_hid_link({0xFFF7, 0xFFF3, "NOBODY"}); }, "TB-HID-OPEN", {}, "fff7:fff3");
}
