// Stage and force sensor on their wires under a manual clock, and between them a contact whose force law the test
// gives.
#pragma once

#include <algorithm>
#include <atomic>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "bench/run/press/press.h"
#include "devices/force/net_ft.h"
#include "devices/force/simulated_net_ft.h"
#include "tests/bench/run/press/ideal_press.h"
#include "tests/devices/stage/zaber_rig.h"

namespace tactbench::tests {

// Force (N, 0 or more) for z of the tip; asked by the simulated sensor's thread alone, and may remember.
using ContactLaw = std::function<double(double z_mm)>;

inline constexpr double kSurfaceMm = 12.0;  // as spring() of ideal_press.h has it

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
