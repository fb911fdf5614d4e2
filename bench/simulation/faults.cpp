#include "bench/simulation/faults.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>

namespace tactbench::bench {
namespace {

using devices::InjectedFault;
using devices::Nanoseconds;

struct Kind {
  const char* word;
  double default_fault_value;
  std::optional<Instrument> instrument;  // whose answers it spoils
  InjectedFault injected;
};

constexpr std::array<Kind, kFaultKinds> kKinds{{
    {"valve_stuck", 0.0, std::nullopt, InjectedFault::kNone},
    {"leak", 5.0, std::nullopt, InjectedFault::kNone},
    {"overshoot", 2.0, std::nullopt, InjectedFault::kNone},
    {"supply_lost", 0.2, std::nullopt, InjectedFault::kNone},
    {"regulator_unpowered", 0.0, std::nullopt, InjectedFault::kNone},
    {"feedback_offset", 10.0, std::nullopt, InjectedFault::kNone},
    {"reference_offset", 10.0, std::nullopt, InjectedFault::kNone},
    {"module_silent", 0.0, Instrument::kModule, InjectedFault::kSilent},
    {"module_late", 0.0, Instrument::kModule, InjectedFault::kLate},
    {"module_corrupt", 0.0, Instrument::kModule, InjectedFault::kCorrupt},
    {"module_stale", 0.0, Instrument::kModule, InjectedFault::kStale},
    {"module_exception", 0.0, Instrument::kModule, InjectedFault::kRefused},
    {"module_busy", 0.0, Instrument::kModule, InjectedFault::kBusy},
    {"module_unplugged", 0.0, Instrument::kModule, InjectedFault::kUnplugged},
    {"controller_silent", 0.0, Instrument::kController, InjectedFault::kSilent},
    {"controller_late", 0.0, Instrument::kController, InjectedFault::kLate},
    {"controller_corrupt", 0.0, Instrument::kController, InjectedFault::kCorrupt},
    {"controller_refused", 0.0, Instrument::kController, InjectedFault::kRefused},
    {"controller_unplugged", 0.0, Instrument::kController, InjectedFault::kUnplugged},
    {"stage_stalled", 0.0, std::nullopt, InjectedFault::kNone},
    {"stage_silent", 0.0, Instrument::kStage, InjectedFault::kSilent},
    {"stage_late", 0.0, Instrument::kStage, InjectedFault::kLate},
    {"stage_corrupt", 0.0, Instrument::kStage, InjectedFault::kCorrupt},
    {"stage_torn", 0.0, Instrument::kStage, InjectedFault::kTorn},
    {"stage_unplugged", 0.0, Instrument::kStage, InjectedFault::kUnplugged},
    {"force_saturated", 0.0, Instrument::kForce, InjectedFault::kSaturated},
    {"force_stale", 0.0, Instrument::kForce, InjectedFault::kStale},
    {"force_silent", 0.0, Instrument::kForce, InjectedFault::kSilent},
    {"row_stuck", 0.0, std::nullopt, InjectedFault::kNone},
    {"scanner_silent", 0.0, Instrument::kScanner, InjectedFault::kSilent},
    {"scanner_stale", 0.0, Instrument::kScanner, InjectedFault::kStale},
    {"scanner_corrupt", 0.0, Instrument::kScanner, InjectedFault::kCorrupt},
    {"scanner_torn", 0.0, Instrument::kScanner, InjectedFault::kTorn},
    {"scanner_unplugged", 0.0, Instrument::kScanner, InjectedFault::kUnplugged},
}};

const Kind& of(FaultKind kind) { return kKinds.at(static_cast<std::size_t>(kind)); }

Nanoseconds time_of(double seconds) { return std::chrono::round<Nanoseconds>(std::chrono::duration<double>(seconds)); }

}  // namespace

const std::vector<std::string>& fault_kind_names() {
  static const std::vector<std::string> words = [] {
    std::vector<std::string> all;
    for (const Kind& kind : kKinds) all.emplace_back(kind.word);
    return all;
  }();
  return words;
}

double default_fault_value(FaultKind kind) { return of(kind).default_fault_value; }

Faults::Faults(const std::vector<PlannedFault>& planned) {
  for (const PlannedFault& fault : planned) {
    const bool waits = fault.at_psi || fault.at_n;
    if (waits) waits_for_load_ = true;
    std::optional<Nanoseconds> from;
    if (fault.at_s || !waits) from = time_of(fault.at_s.value_or(0.0));
    add(fault, from);
  }
}

void Faults::add(const PlannedFault& fault, std::optional<Nanoseconds> from) {
  Entry entry{fault, from, std::nullopt, 0};
  entry.plan.value = fault.value.value_or(default_fault_value(fault.kind));
  if (fault.kind == FaultKind::kOvershoot && fault.times == 0) entry.plan.times = 1;
  if (from && std::isfinite(fault.lasts_s)) entry.until = *from + time_of(fault.lasts_s);
  entries_.push_back(entry);
  any_ = true;
}

void Faults::inject(const PlannedFault& fault, Nanoseconds now) {
  const std::lock_guard lock(mutex_);
  add(fault, now);
}

void Faults::clear(FaultKind kind, Nanoseconds now) {
  const std::lock_guard lock(mutex_);
  for (Entry& entry : entries_) {
    const bool begun = entry.from && *entry.from <= now;
    if (entry.plan.kind == kind && begun && (!entry.until || *entry.until > now)) entry.until = now;
  }
}

void Faults::load(double psi, double newtons, Nanoseconds time) {
  if (!waits_for_load_.load(std::memory_order_relaxed)) return;
  const std::lock_guard lock(mutex_);
  bool waits = false;
  for (Entry& entry : entries_) {
    const PlannedFault& plan = entry.plan;
    if (!plan.at_psi && !plan.at_n) continue;
    if (entry.from && *entry.from <= time) continue;
    if ((plan.at_psi && psi >= *plan.at_psi) || (plan.at_n && newtons >= *plan.at_n)) {
      entry.from = time;
      if (std::isfinite(plan.lasts_s)) entry.until = time + time_of(plan.lasts_s);
    } else {
      waits = true;
    }
  }
  waits_for_load_ = waits;
}

const Faults::Entry* Faults::find(FaultKind kind, Nanoseconds time) const {
  for (const Entry& entry : entries_) {
    if (entry.plan.kind != kind || !entry.from || *entry.from > time) continue;
    if (entry.until && *entry.until <= time) continue;
    if (entry.plan.times > 0 && entry.taken >= entry.plan.times) continue;
    return &entry;
  }
  return nullptr;
}

std::optional<double> Faults::active(FaultKind kind, Nanoseconds time) const {
  if (!any()) return std::nullopt;
  const std::lock_guard lock(mutex_);
  const Entry* entry = find(kind, time);
  return entry != nullptr ? entry->plan.value : std::nullopt;
}

std::optional<double> Faults::take(FaultKind kind, Nanoseconds time) {
  if (!any()) return std::nullopt;
  const std::lock_guard lock(mutex_);
  const Entry* entry = find(kind, time);
  if (entry == nullptr) return std::nullopt;
  ++entries_[static_cast<std::size_t>(entry - entries_.data())].taken;
  return entry->plan.value;
}

InjectedFault Faults::injected(Instrument instrument, Nanoseconds time) {
  if (!any()) return InjectedFault::kNone;
  for (std::size_t i = 0; i < kKinds.size(); ++i) {
    if (kKinds[i].instrument == instrument && take(static_cast<FaultKind>(i), time)) return kKinds[i].injected;
  }
  return InjectedFault::kNone;
}

Faults::Window Faults::last(FaultKind kind, Nanoseconds time) const {
  Window window;
  if (!any()) return window;
  const std::lock_guard lock(mutex_);
  for (const Entry& entry : entries_) {
    if (entry.plan.kind != kind || !entry.from || *entry.from > time || (window.from && *window.from > *entry.from))
      continue;
    window = {entry.from, entry.until, *entry.plan.value};
  }
  return window;
}

}  // namespace tactbench::bench
