// Fuzzer of the HID scanner's reports: what decodes encodes to the same bytes. Each input is tried as it is and with a
// CRC that fits, which no fuzzer would guess.
#include "devices/tactile/scan_report.h"

#include <algorithm>
#include <cstdlib>
#include <vector>

using namespace tactbench::devices;

namespace {

template <class Report>
bool check(const std::optional<Report>& report, std::span<const std::uint8_t> bytes) {
  if (!report) return false;
  const auto again = encode(*report);
  if (!std::equal(again.begin(), again.end(), bytes.begin(), bytes.end())) std::abort();
  return true;
}

void check_all(std::span<const std::uint8_t> bytes) {
  const int kinds = static_cast<int>(check(decode_command(bytes), bytes)) +
                    static_cast<int>(check(decode_row(bytes), bytes)) +
                    static_cast<int>(check(decode_identity(bytes), bytes));
  if (kinds > 1) std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  check_all({data, size});
  if (size < 2) return 0;
  std::vector<std::uint8_t> sealed(data, data + size);
  const std::uint16_t crc = crc16_ccitt(std::span(sealed).first(size - 2));
  sealed[size - 2] = static_cast<std::uint8_t>(crc & 0xFFU);
  sealed[size - 1] = static_cast<std::uint8_t>(crc >> 8U);
  check_all(sealed);
  return 0;
}
