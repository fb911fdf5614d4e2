// Emergency retreat of the stage, used by the dead-man process over a bare serial line: stops every axis, then moves z
// away from the specimen. Needs no armed driver and no message ids. Not verified on hardware.
#pragma once

#include <string>

#include "devices/stage/zaber_line.h"
#include "devices/stage/zaber_stage.h"

namespace tactbench::devices {

struct ZaberRetreat {
  bool stands = false;      // every axis reported that it is at rest
  bool backed_off = false;  // z moved away from the specimen by the commanded distance, or is at its home
  std::string text;         // "stage stands; z from 31.50 to 26.50 mm"
};

// Stops all axes after more than 10 ms without a byte, waits until they are at rest, then moves z toward its home by
// `back_off`, never below 0; not at all when z was not homed, since its position then means nothing. Waits in real
// time, at most halt_timeout and `move_timeout` plus one reply timeout per query. Throws the wire's Fault.
[[nodiscard]] ZaberRetreat retreat(std::unique_ptr<ByteStream> stream, const ZaberStageOptions& options,
                                   Millimetres back_off, Nanoseconds move_timeout);

}  // namespace tactbench::devices
