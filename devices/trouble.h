// What a simulated end asks before it answers a request: how the answer is to be spoilt. Whoever injects faults
// implements it (bench/simulation/faults.h); an end does what applies to its wire.
#pragma once

#include <functional>

namespace tactbench::devices {

enum class Trouble {
  kNone,
  kSilent,     // no answer
  kLate,       // the answer comes just before the next one
  kCorrupt,    // a bit of the answer is flipped
  kStale,      // the answer tells old values
  kRefused,    // the device says that it cannot
  kTorn,       // a part of the answer is missing
  kSaturated,  // the device says that its transducer is overloaded
  kUnplugged,  // the wire is gone; each end says what that is
};

// Called once a request from the end's thread, which then holds no lock; empty: nothing is ever wrong.
using TroubleSource = std::function<Trouble()>;

}  // namespace tactbench::devices
