// netftapi2.xml: a Fault, or a page that reads back as itself after it was written anew.
#include "devices/force/netft_xml.h"

#include <cmath>
#include <cstdint>
#include <cstdlib>

#include "devices/device.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace tactbench::devices;
  NetFtPage page;
  try {
    page = parse_netft_page({reinterpret_cast<const char*>(data), size}, "fuzzed.xml");
  } catch (const Fault& fault) {
    if (fault.id() != "TB-FORCE-CALIBRATION") std::abort();
    return 0;
  }
  if (!std::isnormal(page.newtons_per_count()) || !std::isnormal(page.newton_millimetres_per_count())) std::abort();
  // A control character that the reader took from a numeric reference is written as one: no text differs.
  if (parse_netft_page(format_netft_page(page), "written.xml") != page) std::abort();
  return 0;
}
