// Stage and force sensor without wires, noise or delay under a manual clock, for unit tests of pressing: speed and time
// determine an axis's position, and a function of the test gives the force for z.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "bench/common/process_time.h"
#include "bench/run/press/press_axis.h"
#include "devices/device.h"
#include "tests/devices/fault_of.h"

namespace tactbench::tests {

class IdealStage final : public devices::Stage {
 public:
  explicit IdealStage(devices::Clock& clock) : clock_(clock) {}
  void arm() override {
    ++arms;
    armed_ = true;
    if (refuses_arms-- > 0) throw devices::Fault("TB-STAGE-TEST", "stage", "does not arm", "none");
  }
  void disarm() noexcept override { armed_ = false; }
  bool armed() const override { return armed_; }
  void home(devices::Axis axis) override {
    homed_order.push_back(axis);
    at(axis) = {};
    homed = true;
  }
  void start_move_to(devices::Axis axis, devices::Millimetres position,
                     std::optional<devices::MillimetresPerSecond> speed) override {
    Way& way = at(axis);
    way = {mm(axis), position.value(), speed ? speed->value() : 4.0, clock_.now()};
    if (axis == devices::Axis::kZ) {
      sent_mm.push_back(position.value());
      speeds.push_back(way.speed);
    }
  }
  void start_move_by(devices::Axis, devices::Millimetres, std::optional<devices::MillimetresPerSecond>) override {}
  void start_speed(devices::Axis, devices::MillimetresPerSecond) override {}
  devices::Millimetres wait(devices::Axis axis) override {
    Way& way = at(axis);
    clock_.wait_until(way.begun + bench::seconds(std::abs(way.to - way.from) / way.speed));
    way.from = way.to;
    return devices::Millimetres(way.to);
  }
  devices::Millimetres stop(devices::Axis axis) override {
    at(axis).from = at(axis).to = mm(axis);
    return devices::Millimetres(at(axis).to);
  }
  devices::AxisState state(devices::Axis axis) override {
    devices::AxisState state;
    state.position = devices::Millimetres(mm(axis));
    state.homed = homed;
    state.time = clock_.now();
    return state;
  }
  bool halt() noexcept override {
    ++halts;
    for (const devices::Axis axis : {devices::Axis::kX, devices::Axis::kY, devices::Axis::kZ}) (void)stop(axis);
    return obeys;
  }
  bool send_home(devices::Axis) noexcept override { return false; }
  std::vector<devices::AxisIdentity> identify() override { return {}; }
  std::vector<devices::Identity> identities() const override { return {}; }
  std::uint64_t exchanges() const override { return 0; }

  [[nodiscard]] double mm(devices::Axis axis) const {
    const Way& way = ways_[static_cast<std::size_t>(axis)];
    const double gone = way.speed * devices::in_seconds(clock_.now() - way.begun);
    return gone >= std::abs(way.to - way.from) ? way.to : way.from + std::copysign(gone, way.to - way.from);
  }
  [[nodiscard]] double z_mm() const { return mm(devices::Axis::kZ); }
  void put(devices::Axis axis, double place_mm) { at(axis) = {place_mm, place_mm, 4.0, clock_.now()}; }

  std::vector<double> sent_mm, speeds;  // of z
  std::vector<devices::Axis> homed_order;
  int halts = 0, arms = 0, refuses_arms = 0;
  bool homed = true, obeys = true;

 private:
  struct Way {
    double from = 0.0, to = 0.0, speed = 4.0;
    devices::Nanoseconds begun{0};
  };
  Way& at(devices::Axis axis) { return ways_[static_cast<std::size_t>(axis)]; }
  devices::Clock& clock_;
  std::array<Way, devices::kAxes> ways_;
  bool armed_ = true;
};

class IdealForce final : public devices::ForceSensor {
 public:
  using Law = std::function<double(double z_mm)>;  // N, positive when it presses
  struct Read {
    devices::Nanoseconds time{0};
    int records = 0;
    double force_n = 0.0;
  };
  IdealForce(const devices::Clock& clock, const IdealStage& stage, Law given)
      : law(std::move(given)), clock_(clock), stage_(stage) {}
  devices::ForceReading read(int records) override {
    if (failures-- > 0) throw devices::Fault("TB-FORCE-TEST", "force sensor", "no record", "none");
    devices::ForceReading reading;
    const double force_n = law(stage_.z_mm());
    reading.wrench.force_n = {0.25 * force_n, -0.5 * force_n, offset_n - bias_n_ - force_n};
    reading.wrench.torque_nmm = {1.0 + force_n, 2.0 + force_n, 3.0 + force_n};
    for (std::size_t i = 0; i < 6; ++i) reading.raw[i] = 100.0 * static_cast<double>(i) + force_n;
    reading.records = records;
    reading.time = clock_.now();
    reads.push_back({clock_.now(), records, force_n});
    return reading;
  }
  devices::ForceReading bias(int records) override {
    biased_by = records;
    devices::ForceReading removed;
    removed.wrench.force_n[2] = offset_n;
    removed.wrench.torque_nmm[1] = 2.0 * offset_n;
    removed.spread_n = spread_n;
    bias_n_ = offset_n;
    return removed;
  }
  std::array<double, 6> range() const override { return {25.0, 25.0, 35.0, 250.0, 250.0, 250.0}; }
  std::string calibration_serial() const override { return "FT1"; }
  std::uint64_t exchanges() const override { return reads.size(); }
  devices::Identity identity() const override { return {}; }

  Law law;
  std::vector<Read> reads;
  double offset_n = 0.0;
  double spread_n = 0.0;  // of a tare
  int failures = 0;       // of the next reads
  int biased_by = 0;

 private:
  const devices::Clock& clock_;
  const IdealStage& stage_;
  double bias_n_ = 0.0;
};

inline bench::PressOptions ideal_options() {
  bench::PressOptions options;
  options.clear_z_mm = 10.0;
  options.clear_mm = 1.0;
  options.max_z_mm = 14.0;
  options.contact_n = 0.1;
  return options;
}

// Surface at z = 12 mm.
inline IdealForce::Law spring(double n_per_mm) {
  return [=](double z_mm) { return n_per_mm * std::max(0.0, z_mm - 12.0); };
}

// A fault with this id that names these numbers.
template <class Act>
void check_press_fault(Act&& act, const std::string& id, const std::vector<std::string>& numbers) {
  const auto fault = devices::fault_of(act);
  REQUIRE(fault);
  CHECK(fault->id() == id);
  INFO(fault->what());
  for (const std::string& number : numbers) CHECK(std::string(fault->what()).find(number) != std::string::npos);
}

// All that PressAxis needs, and what it told.
struct IdealBed {
  explicit IdealBed(IdealForce::Law law, const bench::PressOptions& given = ideal_options())
      : options(given), stage(clock), force(clock, stage, std::move(law)), axis(stage, force, clock, options, hooks) {
    hooks.wait = [this](devices::Nanoseconds time) {
      waits.push_back(time);
      clock.wait_until(time);
    };
    hooks.event = [this](const std::string& id, const std::string& text) { events.emplace_back(id, text); };
    hooks.sample = [this](const bench::ForceSample& sample) { samples.push_back(sample); };
  }
  IdealBed(const IdealBed&) = delete;
  IdealBed& operator=(const IdealBed&) = delete;

  devices::ManualClock clock;
  bench::PressOptions options;
  bench::PressHooks hooks;
  IdealStage stage;
  IdealForce force;
  bench::PressAxis axis;
  std::vector<devices::Nanoseconds> waits;
  std::vector<std::pair<std::string, std::string>> events;
  std::vector<bench::ForceSample> samples;
};

}  // namespace tactbench::tests
