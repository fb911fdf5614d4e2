// Faults injected into a simulated instrument ("end" of a connection): before it answers a request, it asks how to
// corrupt the reply. The injector is bench/simulation/faults.h; an end applies the faults that exist on its wire.
#pragma once

#include <functional>

namespace tactbench::devices {

enum class InjectedFault {
  kNone,
  kSilent,     // no reply
  kLate,       // the reply comes just before the next one
  kCorrupt,    // a bit of the reply is flipped
  kStale,      // the reply carries old values
  kRefused,    // the device refuses the request
  kBusy,       // the device does nothing and requests a repetition
  kTorn,       // a part of the reply is missing
  kSaturated,  // the device reports an overloaded transducer
  kUnplugged,  // the wire is disconnected; each end states what that means on its wire
};

// Called once per request from the end's thread, which then holds no lock; empty: no fault is ever injected.
using FaultInjector = std::function<InjectedFault()>;

}  // namespace tactbench::devices
