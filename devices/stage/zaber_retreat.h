// Emergency retreat of the stage, used by the dead-man process over a bare serial line: stops every axis, then moves z
// away from the specimen. Needs no armed driver and no message ids. Not verified on hardware.
#pragma once

#include "devices/stage/zaber_line.h"
#include "devices/stage/zaber_stage.h"

namespace tactbench::devices {

// Stops all axes after more than 10 ms without a byte, waits until they are at rest, then moves z toward its home by
// `back_off`, never below 0; not at all if z was not homed, because its position is then unknown. Waits in real
// time, at most halt_timeout and `move_timeout` plus one reply timeout per query. Throws the wire's Fault.
[[nodiscard]] StageRetreat retreat(std::unique_ptr<ByteStream> stream, const ZaberStageOptions& options,
                                   Millimetres back_off, Nanoseconds move_timeout);

}  // namespace tactbench::devices
