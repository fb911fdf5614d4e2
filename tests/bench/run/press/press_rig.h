// Stage and force sensor on their wires under a manual clock, and between them a contact whose force law the test
// gives.
#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "bench/common/process_time.h"
#include "bench/run/press/press.h"
#include "bench/run/press/press_axis.h"
#include "devices/device.h"
#include "devices/force/net_ft.h"
#include "devices/force/simulated_net_ft.h"
#include "tests/devices/fault_of.h"
#include "tests/devices/stage/scripted_chain.h"

namespace tactbench::tests {

// Stage and force sensor without wires, noise or delay under a manual clock, for unit tests of pressing: speed and time
// determine an axis's position, and a function of the test gives the force for z.

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

// Force (N, 0 or more) for z of the tip; asked by the simulated sensor's thread alone, and may remember.
using ContactLaw = std::function<double(double z_mm)>;

inline constexpr double kSurfaceMm = 12.0;  // as spring() has it

// F = a d + b d^2, more by `friction` of it while z goes in and less while it comes out, behind play.
inline ContactLaw cloth(double a, double b, double friction, double play_mm) {
  return [=, tip_mm = 0.0, rub = 0.0](double z_mm) mutable {
    const double before_mm = tip_mm;
    tip_mm = std::clamp(tip_mm, z_mm - play_mm / 2.0, z_mm + play_mm / 2.0);
    rub = std::clamp(rub + (tip_mm - before_mm) / 0.01, -1.0, 1.0);
    const double depth_mm = std::max(0.0, tip_mm + play_mm / 2.0 - kSurfaceMm);
    return (1.0 + friction * rub) * (a * depth_mm + b * depth_mm * depth_mm);
  };
}

class LawPort final : public devices::ForcePort {
 public:
  LawPort(const devices::StageView& stage, ContactLaw law, double sign)
      : stage_(stage), law_(std::move(law)), sign_(sign) {}
  devices::Wrench wrench() override {
    devices::Wrench wrench;
    // Deterministic noise of +- 5 mN, mean zero.
    const double noise = 0.005 * (static_cast<double>(count_++ * 7 % 11) / 5.0 - 1.0);
    wrench.force_n[2] = offset_n + sign_ * law_(stage_.position(devices::Axis::kZ).value()) + noise;
    return wrench;
  }
  std::atomic<double> offset_n{0.0};

 private:
  const devices::StageView& stage_;
  ContactLaw law_;
  double sign_;
  long count_ = 0;
};

// Hands everything on and keeps what z was sent to.
class RecordingStage final : public devices::Stage {
 public:
  explicit RecordingStage(devices::Stage& stage) : stage_(stage) {}
  void arm() override { stage_.arm(); }
  void disarm() noexcept override { stage_.disarm(); }
  bool armed() const override { return stage_.armed(); }
  void home(devices::Axis axis) override { stage_.home(axis); }
  void start_move_to(devices::Axis axis, devices::Millimetres position,
                     std::optional<devices::MillimetresPerSecond> speed) override {
    stage_.start_move_to(axis, position, speed);
    if (axis == devices::Axis::kZ) sent_mm.push_back(position.value());
  }
  void start_move_by(devices::Axis axis, devices::Millimetres distance,
                     std::optional<devices::MillimetresPerSecond> speed) override {
    stage_.start_move_by(axis, distance, speed);
  }
  void start_speed(devices::Axis axis, devices::MillimetresPerSecond speed) override {
    stage_.start_speed(axis, speed);
  }
  devices::Millimetres wait(devices::Axis axis) override { return stage_.wait(axis); }
  devices::Millimetres stop(devices::Axis axis) override { return stage_.stop(axis); }
  devices::AxisState state(devices::Axis axis) override { return stage_.state(axis); }
  bool halt() noexcept override {
    ++halts;
    return stage_.halt();
  }
  bool send_home(devices::Axis axis) noexcept override { return stage_.send_home(axis); }
  std::vector<devices::AxisIdentity> identify() override { return stage_.identify(); }
  std::vector<devices::Identity> identities() const override { return stage_.identities(); }
  std::uint64_t exchanges() const override { return stage_.exchanges(); }

  std::vector<double> sent_mm;
  int halts = 0;

 private:
  devices::Stage& stage_;
};

struct PressRig {
  explicit PressRig(ContactLaw law, bench::PressOptions options = ideal_options(),
                    devices::SimulatedNetFtFaults faults = {}, double sign = -1.0)
      : port(zaber.chain, std::move(law), sign), server({0, 0, page(), faults}, port), stage(zaber.stage) {
    devices::NetFtOptions net;
    net.host = "127.0.0.1";
    net.port = server.rdt_port();
    net.http_port = server.http_port();
    net.reply_timeout = faults.silent_after_records < 0 ? std::chrono::seconds(20) : std::chrono::milliseconds(400);
    net.page_timeout = std::chrono::seconds(20);
    net.origin = devices::Origin::kSimulated;
    force = std::make_unique<devices::NetFt>(net, zaber.clock);
    bench::PressHooks hooks;
    hooks.wait = [this](devices::Nanoseconds time) { wait(time); };
    hooks.event = [this](const std::string& id, const std::string&) { events.push_back(id); };
    hooks.sample = [this](const bench::ForceSample& sample) { samples.push_back(sample); };
    press = std::make_unique<bench::Press>(stage, *force, zaber.clock, options, hooks);
    stage.arm();
    press->home();
  }
  static devices::NetFtPage page() {
    devices::NetFtPage page;
    page.product = "P";
    page.calibration_serial = "FT99901";
    page.range = devices::SixAxes{25.0, 25.0, 35.0, 250.0, 250.0, 250.0};
    return page;
  }
  void wait(devices::Nanoseconds time) {
    if (on_wait) on_wait();
    zaber.clock.wait_until(time);
  }
  bench::PressReading go(double force_n, bench::Branch branch, double dwell_s = 2.0, bool hold_force = false) {
    return press->press({force_n, branch, dwell_s, hold_force}, [this] { ++frames; });
  }
  std::uint64_t exchanges() const { return stage.exchanges() + force->exchanges(); }
  double z_mm() const { return zaber.chain.position(devices::Axis::kZ).value(); }
  // Whether z is at rest: its position is unchanged a second later.
  bool stands() {
    const double before = z_mm();
    zaber.clock.wait_until(zaber.clock.now() + std::chrono::seconds(1));
    return z_mm() == before;
  }

  std::function<void()> on_wait;
  std::vector<std::string> events;
  std::vector<bench::ForceSample> samples;
  int frames = 0;
  devices::ZaberRig<> zaber;
  LawPort port;
  devices::SimulatedNetFt server;
  RecordingStage stage;
  std::unique_ptr<devices::NetFt> force;
  std::unique_ptr<bench::Press> press;
};

}  // namespace tactbench::tests
