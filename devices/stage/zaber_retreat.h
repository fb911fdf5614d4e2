// The dead-man's retreat of the stage over a line alone: stop every axis, then move z away from the specimen. Needs no
// armed driver and no message ids. Not verified on hardware.
#pragma once

#include <string>

#include "devices/stage/zaber_line.h"
#include "devices/stage/zaber_stage.h"

namespace tactbench::devices {

struct ZaberRetreat {
  bool stands = false;      // every axis answered that it stands
  bool backed_off = false;  // z is farther from the specimen by the distance ordered, or at its home
  std::string text;         // "stage stands; z from 31.50 to 26.50 mm"
};

// Stops all axes after more than 10 ms without a byte, waits until they stand, then moves z toward its home by
// `back_off`, never below 0, and not at all when z was not homed (its position then means nothing). Waits in real time,
// at most halt_timeout and `move_timeout` plus a reply timeout a question. Throws the wire's Fault.
[[nodiscard]] ZaberRetreat retreat(std::unique_ptr<ByteStream> stream, const ZaberStageOptions& options,
                                   Millimetres back_off, Nanoseconds move_timeout);

}  // namespace tactbench::devices
