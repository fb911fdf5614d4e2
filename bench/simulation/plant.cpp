#include "bench/simulation/plant.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <stdexcept>

#include "bench/simulation/counter_noise.h"
#include "devices/tactile/scan_report.h"

namespace tactbench::bench {
namespace {

using devices::Nanoseconds;

constexpr Nanoseconds kCell = std::chrono::milliseconds(10);
// The specimen moves when the pressure has changed by this much, at each turning point, and in calm pressure at times
// that grow with the calm, as creep's rate falls with it.
constexpr double kMovePsi = 0.25;
constexpr double kTurnPsi = 0.001;
constexpr double kShortestCalmSeconds = 0.1;
constexpr double kLongestCalmSeconds = 60.0;
constexpr double kCalmGrowth = 0.5;
constexpr double kFullScaleVolts = 10.0;
constexpr double kNotSettledShare = 0.01;

enum Stream : std::uint64_t { kFeedback = 101, kReference, kScan, kWrench };

double seconds_of(Nanoseconds time) { return std::chrono::duration<double>(time).count(); }

}  // namespace

Plant::Plant(const PlantOptions& options, const devices::Clock& clock)
    : options_(options),
      clock_(clock),
      chamber_(options.chamber),
      specimen_(options.specimen),
      time_(clock.now()),
      volts_(static_cast<std::size_t>(options.specimen.rows) * static_cast<std::size_t>(options.specimen.columns)) {}

void Plant::drive(devices::Volts command, Nanoseconds hold_until, devices::Volts fallback) {
  const std::lock_guard lock(mutex_);
  const Nanoseconds now = clock_.now();
  advance_to(now);
  // The grid is cut only where the command changes: feeding the watchdog leaves no trace.
  if (command != command_ || (held_ && hold_until_ <= now)) step_to(now);
  command_ = command;
  chamber_.command(command);
  hold_until_ = hold_until;
  fallback_ = fallback;
  held_ = true;
}

devices::Volts Plant::feedback() {
  const std::lock_guard lock(mutex_);
  advance_to(clock_.now());
  const double noise = bell_of(hash_of(options_.seed, kFeedback, feedback_counter_++));
  const double psi = chamber_.believed().value() + options_.chamber.feedback_noise_psi * noise;
  return devices::Volts(psi / options_.chamber.span_psi * kFullScaleVolts);
}

devices::Volts Plant::reference() {
  return devices::Volts(reference_pressure().value() / options_.chamber.reference_span_psi * kFullScaleVolts);
}

devices::Psi Plant::reference_pressure() {
  const std::lock_guard lock(mutex_);
  advance_to(clock_.now());
  const double noise = bell_of(hash_of(options_.seed, kReference, reference_counter_++));
  return devices::Psi(chamber_.pressure().value() + options_.chamber.reference_noise_psi * noise);
}

devices::Wrench Plant::wrench() {
  const ContactOptions& contact = options_.contact;
  const devices::StageView* stage = stage_;
  const double z_mm = stage == nullptr ? 0.0 : stage->position(devices::Axis::kZ).value();
  devices::Wrench wrench;
  wrench.force_n[2] = -contact.stiffness_n_per_mm * std::max(0.0, z_mm - contact.surface_z_mm);
  const std::lock_guard lock(mutex_);
  const std::uint64_t key = hash_of(options_.seed, kWrench, wrench_counter_++);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    wrench.force_n[axis] += contact.force_noise_n * bell_of(mix64(key ^ axis));
    wrench.torque_nmm[axis] += contact.torque_noise_nmm * bell_of(mix64(key ^ (axis + 3)));
  }
  return wrench;
}

void Plant::scan(std::span<std::uint16_t> counts, std::span<std::uint8_t> status) {
  const auto rows = static_cast<std::size_t>(options_.specimen.rows);
  const auto columns = static_cast<std::size_t>(options_.specimen.columns);
  if (counts.size() != rows * columns || status.size() != rows) {
    throw std::invalid_argument("Plant::scan: spans do not fit the array");
  }
  const std::lock_guard lock(mutex_);
  advance_to(clock_.now());
  if (!volts_fresh_) {
    specimen_.output_after(chamber_.pressure().value(), pending_s_, volts_);
    volts_fresh_ = true;
  }
  const ScannerFrontEnd& front = options_.scanner;
  const double left_over =
      front.relay_time_constant_s > 0.0 ? std::exp(-front.relay_settle_s / front.relay_time_constant_s) : 0.0;
  const std::uint64_t key = hash_of(options_.seed, kScan, scan_counter_++);
  for (std::size_t r = 0; r < rows; ++r) {
    const std::size_t row_before = r == 0 ? rows - 1 : r - 1;  // the scan before ended with the last row
    status[r] = left_over > kNotSettledShare ? devices::kStatusNotSettled : std::uint8_t{0};
    for (std::size_t c = 0; c < columns; ++c) {
      const std::size_t i = r * columns + c;
      const double own = specimen_.noise_v(static_cast<int>(i));
      const double spread = own > 0.0 ? std::hypot(front.noise_v, own) : front.noise_v;
      const double settled = volts_[i] + left_over * (volts_[row_before * columns + c] - volts_[i]);
      const double count = std::round((settled + spread * bell_of(mix64(key ^ i))) / front.volts_per_count);
      counts[i] = static_cast<std::uint16_t>(std::clamp(count, 0.0, 65535.0));
      if (counts[i] == 0 || counts[i] == 65535) status[r] |= devices::kStatusAtLimit;
    }
  }
}

devices::Psi Plant::true_pressure() {
  const std::lock_guard lock(mutex_);
  advance_to(clock_.now());
  return chamber_.pressure();
}

std::string Plant::specimen_state() {
  const std::lock_guard lock(mutex_);
  advance_to(clock_.now());
  if (!(pending_s_ > 0.0)) return specimen_.state();
  // Lives through the pending time for the text only: asking must not cut the grid.
  const std::string before = specimen_.state();
  specimen_.advance(chamber_.pressure().value(), pending_s_);
  std::string now = specimen_.state();
  specimen_.set_state(before);
  return now;
}

void Plant::set_specimen_state(const std::string& text) {
  const std::lock_guard lock(mutex_);
  advance_to(clock_.now());
  specimen_.set_state(text);
  pending_s_ = 0.0;
  calm_s_ = 0.0;
  moved_psi_ = chamber_.pressure().value();
  volts_fresh_ = false;
}

void Plant::advance_to(Nanoseconds time) {
  while (true) {
    const Nanoseconds next = (time_ / kCell + 1) * kCell;
    if (next > time) return;
    step_to(next);
  }
}

void Plant::step_to(Nanoseconds time) {
  while (time_ < time) {
    if (held_ && hold_until_ <= time_) {
      held_ = false;
      command_ = fallback_;
      chamber_.command(fallback_);
    }
    const Nanoseconds end = held_ ? std::min(time, hold_until_) : time;
    const double seconds = seconds_of(end - time_);
    chamber_.advance(seconds);
    time_ = end;
    follow(seconds);
  }
}

void Plant::follow(double seconds) {
  const double pressure = chamber_.pressure().value();
  const double change = pressure - previous_psi_;
  const int direction = change > 0.0 ? 1 : (change < 0.0 ? -1 : direction_);
  if (direction != direction_ && pending_s_ > 0.0 && std::abs(previous_psi_ - moved_psi_) > kTurnPsi) {
    move_specimen(previous_psi_, pending_s_);  // the turning point itself: plays remember it
    pending_s_ = 0.0;
  }
  direction_ = direction;
  previous_psi_ = pressure;
  pending_s_ += seconds;
  calm_s_ += seconds;
  volts_fresh_ = false;
  if (std::abs(pressure - moved_psi_) >= kMovePsi) {
    move_specimen(pressure, pending_s_);
    pending_s_ = 0.0;
    calm_s_ = 0.0;
  } else if (pending_s_ >= std::clamp(kCalmGrowth * calm_s_, kShortestCalmSeconds, kLongestCalmSeconds)) {
    move_specimen(pressure, pending_s_);
    pending_s_ = 0.0;
  }
}

void Plant::move_specimen(double pressure_psi, double seconds) {
  specimen_.advance(pressure_psi, seconds);
  moved_psi_ = pressure_psi;
}

}  // namespace tactbench::bench
