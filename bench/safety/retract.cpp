#include "bench/safety/retract.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <exception>

#include "bench/common/process_time.h"
#include "devices/device.h"

namespace tactbench::bench {

using devices::Axis;
using devices::Nanoseconds;

namespace {

constexpr int kRetreatTries = 2;
constexpr Nanoseconds kSlice = std::chrono::milliseconds(100);
constexpr Nanoseconds kSettle = std::chrono::milliseconds(100);
constexpr double kArrivedMm = 0.001;  // as the stage rounds to microsteps

class Retraction {
 public:
  Retraction(devices::Stage& stage, devices::ForceSensor* force, devices::Clock& clock, const RetractOptions& options,
             const std::function<void(Nanoseconds)>& wait)
      : stage_(stage), force_(force), clock_(clock), options_(options), wait_(wait) {}

  RetractProof prove() {
    RetractProof proof;
    std::string trouble;
    for (int i = 0; i < kRetreatTries && !proof.z_mm; ++i) proof.z_mm = back_off(proof.halted, trouble);
    proof.force_n = force_now(trouble);
    // Pressed where the bench file says that nothing is touched: goes up as far as it can.
    if (proof.z_mm && (overloaded_ || (proof.force_n && !is_safe(*proof.force_n)))) {
      trouble.clear();
      try {
        proof.z_mm = go_up(options_.low_end_z_mm);
      } catch (const std::exception& error) {
        trouble = error.what();
      }
      proof.force_n = force_now(trouble);
    }
    const bool clear = proof.z_mm && *proof.z_mm <= options_.clear_z_mm + kArrivedMm;
    const bool free = proof.force_n && is_safe(*proof.force_n);
    proof.verified = clear && free;
    const char* head = proof.verified               ? "retracted, verified"
                       : proof.force_n && !free     ? "NOT SAFE: there is a force on the indenter"
                       : clear && force_ != nullptr ? "retracted, NOT verified: no force reading"
                       : clear                      ? "retracted, NOT verified: no force sensor"
                                                    : "retraction NOT verified";
    proof.text =
        fmt::format("{} ({}, {}{}{})", head, proof.z_mm ? fmt::format("z {:.3f} mm", *proof.z_mm) : "z not known",
                    proof.force_n ? fmt::format("{:.2f} N", *proof.force_n) : "force not known",
                    trouble.empty() ? "" : "; ", trouble);
    return proof;
  }

 private:
  [[nodiscard]] bool is_safe(double force_n) const { return force_n < options_.safe_force_n; }  // NaN is not

  // Moves z to `to_mm` unless it is further away; returns its final position.
  double go_up(double to_mm) {
    const double way_mm = stage_.state(Axis::kZ).position.value() - to_mm;
    if (way_mm > kArrivedMm) {
      stage_.start_move_to(Axis::kZ, devices::Millimetres(to_mm),
                           devices::MillimetresPerSecond(options_.speed_mm_per_s));
      pause(seconds(way_mm / options_.speed_mm_per_s));
      (void)stage_.wait(Axis::kZ);
    }
    pause(kSettle);
    return stage_.state(Axis::kZ).position.value();
  }

  // The final position of z; none when the stage did not obey.
  std::optional<double> back_off(bool& halted, std::string& trouble) {
    try {
      halted = stage_.halt();
      stage_.arm();
      if (!stage_.state(Axis::kZ).homed) stage_.home(Axis::kZ);
      return go_up(options_.clear_z_mm);
    } catch (const std::exception& error) {
      trouble = error.what();
      return std::nullopt;
    }
  }

  std::optional<double> force_now(std::string& trouble) {
    for (int i = 0; i < kRetreatTries && force_ != nullptr; ++i) {
      try {
        const double force_n = std::abs(force_->read(options_.records).wrench.force_n[2]);
        overloaded_ = false;
        return force_n;
      } catch (const devices::Fault& fault) {
        trouble = fault.what();
        overloaded_ = fault.id() == "TB-FORCE-TRIP" || fault.id() == "TB-FORCE-OVERLOAD";
      } catch (const std::exception& error) {
        trouble = error.what();
      }
    }
    return std::nullopt;
  }

  void pause(Nanoseconds span) {
    const Nanoseconds end = clock_.now() + span;
    while (clock_.now() < end) {
      const Nanoseconds next = std::min(end, clock_.now() + kSlice);
      try {
        if (wait_) wait_(next);
      } catch (...) {
        // A request to stop: retracting is the answer to it.
      }
      clock_.wait_until(next);
    }
  }

  devices::Stage& stage_;
  devices::ForceSensor* force_;
  devices::Clock& clock_;
  const RetractOptions& options_;
  const std::function<void(Nanoseconds)>& wait_;
  bool overloaded_ = false;  // the sensor reads no force because it is too large
};

}  // namespace

RetractProof retract(devices::Stage& stage, devices::ForceSensor* force, devices::Clock& clock,
                     const RetractOptions& options, const std::function<void(Nanoseconds)>& wait) noexcept {
  try {
    return Retraction(stage, force, clock, options, wait).prove();
  } catch (...) {
    return {};
  }
}

}  // namespace tactbench::bench
