// .cal files: a Fault, or a calibration whose matrix and range are of use.
#include "devices/force/ati_calibration.h"

#include <cstdint>
#include <cstdlib>

#include "devices/device.h"
#include "devices/force/ati_matrix.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace tactbench::devices;
  try {
    const auto calibration = parse_ati_calibration({reinterpret_cast<const char*>(data), size}, "fuzzed.cal");
    if (calibration.serial.empty() || !working_matrix(calibration).allFinite()) std::abort();
    for (const double range : rated_range(calibration)) {
      if (!(range > 0.0)) std::abort();
    }
  } catch (const Fault& fault) {
    if (fault.id() != "TB-FORCE-CALIBRATION") std::abort();
  }
  return 0;
}
