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

constexpr double kFullScaleVolts = 10.0;
constexpr double kNotSettledShare = 0.01;

enum PlantStream : std::uint64_t { kFeedback = 101, kReference, kScan, kWrench };

SpecimenOptions with_seed(SpecimenOptions specimen, std::uint64_t seed) {
  specimen.seed = seed;
  return specimen;
}

}  // namespace

Plant::Plant(const PlantOptions& options, const devices::Clock& clock)
    : options_(options),
      clock_(clock),
      faults_(options.faults),
      chamber_(options.chamber),
      contact_(options.contact, options.specimen.rows, options.specimen.columns),
      specimen_(with_seed(options.specimen, options.seed)),
      instruments_(options.instruments),
      time_(clock.now()),
      volts_(static_cast<std::size_t>(options.specimen.rows) * static_cast<std::size_t>(options.specimen.columns)) {}

void Plant::drive(devices::Volts command, Nanoseconds hold_until, devices::Volts fallback) {
  const std::lock_guard lock(mutex_);
  const Nanoseconds now = clock_.now();
  advance_to(now);
  // The grid is cut only where the command changes: feeding the watchdog leaves no trace.
  if (command != command_ || (held_ && hold_until_ <= now)) step_to(now);
  if (command != command_) {
    if (const auto beyond = faults_.take(FaultKind::kOvershoot, now)) {
      chamber_.overshoot(command > command_ ? *beyond : -*beyond);
    }
  }
  command_ = command;
  chamber_.command(command);
  hold_until_ = hold_until;
  fallback_ = fallback;
  held_ = true;
}

void Plant::dump(bool open) {
  const std::lock_guard lock(mutex_);
  advance_to(clock_.now());
  if (open == dumping_) return;
  step_to(clock_.now());
  dumping_ = open;
  chamber_.dump(open);
}

devices::Volts Plant::feedback() {
  const std::lock_guard lock(mutex_);
  advance_to(clock_.now());
  const double noise = bell_of(hash_of(options_.seed, kFeedback, feedback_counter_++));
  if (faults_.active(FaultKind::kRegulatorUnpowered, clock_.now())) return devices::Volts(0.0);
  const double offset = faults_.active(FaultKind::kFeedbackOffset, clock_.now()).value_or(0.0);
  const double psi = chamber_.believed().value() + offset + options_.chamber.feedback_noise_psi * noise;
  const ChamberOptions& chamber = options_.chamber;
  return devices::Volts((psi - chamber.low_psi) / (chamber.span_psi - chamber.low_psi) * kFullScaleVolts);
}

devices::Volts Plant::reference() {
  return devices::Volts(reference_pressure().value() / options_.chamber.reference_span_psi * kFullScaleVolts);
}

devices::Psi Plant::reference_pressure() {
  const std::lock_guard lock(mutex_);
  advance_to(clock_.now());
  const double noise = bell_of(hash_of(options_.seed, kReference, reference_counter_++));
  const double offset = faults_.active(FaultKind::kReferenceOffset, clock_.now()).value_or(0.0);
  const double psi = chamber_.pressure().value();
  return devices::Psi(psi + instruments_.reference_psi(psi, options_.specimen.temperature_c) + offset +
                      options_.chamber.reference_noise_psi * noise);
}

double Plant::supply_bar() {
  const std::lock_guard lock(mutex_);
  advance_to(clock_.now());
  return faults_.active(FaultKind::kSupplyLost, clock_.now()) ? 0.0 : options_.supply_bar;
}

devices::Wrench Plant::wrench() {
  const ContactOptions& contact = options_.contact;
  const std::lock_guard lock(mutex_);
  devices::Wrench wrench;
  const double force_n = contact_now().force_n;
  wrench.force_n[2] = -force_n - instruments_.force_n(force_n);
  const std::uint64_t key = hash_of(options_.seed, kWrench, wrench_counter_++);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    wrench.force_n[axis] += contact.force_noise_n * bell_of(mix64(key ^ axis));
    wrench.torque_nmm[axis] += contact.torque_noise_nmm * bell_of(mix64(key ^ (axis + 3)));
  }
  return wrench;
}

void Plant::read_specimen() {
  advance_to(clock_.now());
  if (volts_fresh_) return;
  specimen_.output_after(load().chamber_psi, pending_s_, volts_, contact_psi(contact_state_.force_n));
  volts_fresh_ = true;
}

std::vector<double> Plant::true_output() {
  const std::lock_guard lock(mutex_);
  read_specimen();
  return volts_;
}

void Plant::scan(std::span<std::uint16_t> counts, std::span<std::uint8_t> status) {
  const auto rows = static_cast<std::size_t>(options_.specimen.rows);
  const auto columns = static_cast<std::size_t>(options_.specimen.columns);
  if (counts.size() != rows * columns || status.size() != rows) {
    throw std::invalid_argument("Plant::scan: spans do not fit the array");
  }
  const std::lock_guard lock(mutex_);
  read_specimen();
  std::vector<double> volts = volts_;
  specimen_.add_film_noise(devices::in_seconds(clock_.now()), volts);
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
      const double settled = volts[i] + left_over * (volts[row_before * columns + c] - volts[i]);
      const double noise = spread * specimen_.white_noise(mix64(key ^ i));
      const double count = std::round((settled + noise) / front.volts_per_count);
      counts[i] = static_cast<std::uint16_t>(std::clamp(count, 0.0, 65535.0));
      if (counts[i] == 0 || counts[i] == 65535) status[r] |= devices::kStatusAtLimit;
    }
  }
  const auto stuck_row = faults_.active(FaultKind::kRowStuck, clock_.now());
  if (!stuck_row) return stuck_counts_.clear();
  const auto row = counts.subspan(std::min(static_cast<std::size_t>(*stuck_row), rows - 1) * columns, columns);
  if (stuck_counts_.empty()) stuck_counts_.assign(row.begin(), row.end());
  std::copy(stuck_counts_.begin(), stuck_counts_.end(), row.begin());
}

void Plant::inject(FaultKind kind, std::optional<double> value, long times) {
  const std::lock_guard lock(mutex_);
  const Nanoseconds now = clock_.now();
  advance_to(now);
  PlannedFault fault;
  fault.kind = kind;
  fault.value = value;
  fault.times = times;
  faults_.inject(fault, now);
}

void Plant::clear(FaultKind kind) {
  const std::lock_guard lock(mutex_);
  advance_to(clock_.now());
  faults_.clear(kind, clock_.now());
}

devices::InjectedFault Plant::injected(Instrument instrument) {
  if (!faults_.any()) return devices::InjectedFault::kNone;
  const std::lock_guard lock(mutex_);
  advance_to(clock_.now());  // faults that wait for a load
  return faults_.injected(instrument, clock_.now());
}

devices::Newtons Plant::true_force() {
  const std::lock_guard lock(mutex_);
  return devices::Newtons(contact_now().force_n);
}

std::vector<double> Plant::true_contact_psi() {
  const std::lock_guard lock(mutex_);
  const auto psi = contact_psi(contact_now().force_n);
  return {psi.begin(), psi.end()};
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
  specimen_.advance(load().chamber_psi, pending_s_, contact_psi(contact_state_.force_n));
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
  moved_ = load();
  volts_fresh_ = false;
}

// How the plant goes through time: a fixed grid, cut where a command or its time limit changes the drive.

namespace {

constexpr Nanoseconds kCell = std::chrono::milliseconds(10);
// The specimen moves when the pressure on some taxel has changed by this much, at each turning point, and in calm
// pressure at times that grow with the calm, as creep's rate falls with it.
constexpr double kMovePsi = 0.25;
constexpr double kTurnPsi = 0.001;
constexpr double kShortestCalmSeconds = 0.1;
constexpr double kLongestCalmSeconds = 60.0;
constexpr double kCalmGrowth = 0.5;

double seconds_of(Nanoseconds time) { return std::chrono::duration<double>(time).count(); }

// True at a turn; `direction` follows `change`.
bool turns(int& direction, double change) {
  const int now = change > 0.0 ? 1 : (change < 0.0 ? -1 : direction);
  const bool turned = now != direction;
  direction = now;
  return turned;
}

}  // namespace

void Plant::set_stage(const devices::StageView* stage) {
  const std::lock_guard lock(mutex_);
  advance_to(clock_.now());
  stage_ = stage;
  contact_state_ = {};
}

void Plant::forget_stage() {
  const std::lock_guard lock(mutex_);
  stage_ = nullptr;
}

void Plant::advance_to(Nanoseconds time) {
  const Nanoseconds last = time / kCell * kCell;
  if (last <= time_) return;
  stage_rests_ = stage_ == nullptr || (contact_.quiet(contact_state_) && stage_->at_rest_since(time_));
  for (Nanoseconds next = (time_ / kCell + 1) * kCell; next <= last; next += kCell) step_to(next);
  stage_rests_ = false;
}

void Plant::step_to(Nanoseconds time) {
  while (time_ < time) {
    if (held_ && hold_until_ <= time_) {
      held_ = false;
      command_ = fallback_;
      chamber_.command(fallback_);
    }
    if (faults_.any()) apply_faults();
    const Nanoseconds end = held_ ? std::min(time, hold_until_) : time;
    const double seconds = seconds_of(end - time_);
    chamber_.advance(seconds);
    instruments_.follow(chamber_.pressure().value());
    time_ = end;
    if (!stage_rests_ && stage_ != nullptr) follow_stage(seconds);
    follow(seconds);
    faults_.load(chamber_.pressure().value(), contact_state_.force_n, time_);
  }
}

void Plant::apply_faults() {
  const auto value = [&](FaultKind kind) { return faults_.active(kind, time_); };
  ChamberFaults trouble;
  trouble.valve_shut = value(FaultKind::kValveStuck) || value(FaultKind::kRegulatorUnpowered);
  trouble.leak_psi_per_s = value(FaultKind::kLeak).value_or(0.0);
  trouble.no_supply_fall_psi_per_s = value(FaultKind::kSupplyLost).value_or(0.0);
  chamber_.set_faults(trouble);
}

void Plant::follow_stage(double seconds) {
  const auto places = stage_->places(time_);
  contact_.advance(contact_state_, places[2].value(), seconds);
  if (contact_state_.force_n == 0.0) return;
  const auto& shape = contact_.psi_per_newton(places[0].value(), places[1].value());
  if (shape == psi_per_newton_) return;
  psi_per_newton_ = shape;
  peak_psi_per_newton_ = *std::max_element(shape.begin(), shape.end());
  shifted_ = true;
}

ContactState Plant::contact_now() {
  const Nanoseconds now = clock_.now();
  advance_to(now);
  ContactState state = contact_state_;
  if (stage_ != nullptr && time_ < now) {
    contact_.advance(state, stage_->places(now)[2].value(), seconds_of(now - time_));
  }
  return state;
}

std::span<const double> Plant::contact_psi(double force_n) {
  if (!(force_n > 0.0) || psi_per_newton_.empty()) return {};
  contact_psi_.resize(psi_per_newton_.size());
  std::transform(psi_per_newton_.begin(), psi_per_newton_.end(), contact_psi_.begin(),
                 [&](double psi) { return psi * force_n; });
  return contact_psi_;
}

void Plant::follow(double seconds) {
  const Load now = load();
  const bool turned = turns(direction_, now.chamber_psi - previous_.chamber_psi);
  const bool contact_turned = turns(contact_direction_, now.force_n - previous_.force_n);
  // The turning point itself: plays remember it.
  if (pending_s_ > 0.0 && ((turned && std::abs(previous_.chamber_psi - moved_.chamber_psi) > kTurnPsi) ||
                           (contact_turned && peak_psi(std::abs(previous_.force_n - moved_.force_n)) > kTurnPsi))) {
    move_specimen(previous_, pending_s_);
    pending_s_ = 0.0;
  }
  previous_ = now;
  pending_s_ += seconds;
  calm_s_ += seconds;
  volts_fresh_ = false;
  if (std::abs(now.chamber_psi - moved_.chamber_psi) >= kMovePsi ||
      peak_psi(std::abs(now.force_n - moved_.force_n)) >= kMovePsi || shifted_) {
    move_specimen(now, pending_s_);
    pending_s_ = 0.0;
    calm_s_ = 0.0;
    shifted_ = false;
  } else if (pending_s_ >= std::clamp(kCalmGrowth * calm_s_, kShortestCalmSeconds, kLongestCalmSeconds)) {
    move_specimen(now, pending_s_);
    pending_s_ = 0.0;
  }
}

void Plant::move_specimen(const Load& load, double seconds) {
  specimen_.advance(load.chamber_psi, seconds, contact_psi(load.force_n));
  moved_ = load;
}

}  // namespace tactbench::bench
