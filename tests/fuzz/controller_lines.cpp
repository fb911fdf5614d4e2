// Lines of a serial pressure controller, as either side may send them: what decodes is finite, and decodes the same
// after it is encoded.
#include "devices/pressure/controller_lines.h"

#include <cmath>
#include <cstdint>
#include <cstdlib>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace tactbench::devices;
  const std::string_view line(reinterpret_cast<const char*>(data), size);
  const auto request = decode_request(line, 'A');
  if (request && !std::isfinite(request->setpoint)) std::abort();
  const ControllerAnswer answer = decode_answer(line, 'A', {});
  if (answer.refused && answer.frame) std::abort();
  if (!answer.frame) return 0;
  if (!std::isfinite(answer.frame->pressure) || !std::isfinite(answer.frame->setpoint)) std::abort();
  const std::string again = encode_answer('A', *answer.frame, 2);
  const auto back = decode_answer(std::string_view(again).substr(0, again.size() - 1), 'A', {}).frame;
  if (!back || back->status != answer.frame->status) std::abort();
  return 0;
}
