// Fuzz entry for the Zaber decoder: any bytes, in any pieces, with any silence. The first byte of each piece says how
// long it is (low 5 bits) and whether 20 ms of silence came before it (high bit).
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <vector>

#include "devices/stage/zaber_binary.h"

using namespace tactbench::devices;

namespace {

void demand(bool holds) {
  if (!holds) std::abort();
}

void check_frame(const ZaberBytes& bytes) {
  const ZaberFrame frame = decode(bytes);
  demand(encode(frame) == bytes);
  demand(encode_without_id(decode_without_id(bytes)) == bytes);
  demand(frame.data >= kZaberDataMin && frame.data <= kZaberDataMax);
  demand(!name(frame.command).empty());
  demand(!zaber_error_text(frame.data).empty());
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  ZaberParser parser;
  std::vector<ZaberBytes> frames;
  Nanoseconds time{0};
  std::size_t fed = 0;
  for (std::size_t at = 0; at < size;) {
    const std::uint8_t head = data[at++];
    const std::size_t count = std::min<std::size_t>(head & 0x1FU, size - at);
    time += (head & 0x80U) != 0 ? std::chrono::milliseconds(20) : std::chrono::milliseconds(1);
    parser.add({data + at, count}, time, frames);
    at += count;
    fed += count;
    demand(parser.waiting() < kZaberFrameBytes);
    demand(fed == frames.size() * kZaberFrameBytes + parser.waiting() + parser.dropped());
  }
  for (const ZaberBytes& frame : frames) check_frame(frame);
  return 0;
}
