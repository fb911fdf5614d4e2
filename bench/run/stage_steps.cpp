#include "bench/run/stage_steps.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "analysis/json_io.h"
#include "bench/common/error.h"
#include "devices/device.h"

namespace tactbench::bench {

using sequences::Step;
using sequences::StepKind;

namespace {

std::array<double, 6> six(const devices::Wrench& wrench) {
  return {wrench.force_n[0],    wrench.force_n[1],    wrench.force_n[2],
          wrench.torque_nmm[0], wrench.torque_nmm[1], wrench.torque_nmm[2]};
}

}  // namespace

PressOptions press_options(const BenchConfig& config, const sequences::Recipe& recipe) {
  PressOptions options = press_options(config);
  options.clear_z_mm = config.limits.clear_z_mm;
  options.safe_force_n = config.limits.contact_n;
  options.force_limit_n = std::min(options.force_limit_n, config.limits.force_n[2]);
  options.approach_mm_per_s = recipe.press.approach_mm_per_s;
  options.contact_n = recipe.press.contact_n;
  options.servo_mm_per_s = recipe.press.servo_mm_per_s;
  options.clear_mm = recipe.press.clear_mm;
  return options;
}

std::vector<std::string> press_complaints(const sequences::Recipe& recipe, const BenchConfig& config,
                                          const std::array<double, 6>& force_range) {
  PressEnvelope envelope;
  envelope.force_range = force_range;
  envelope.overload_share = config.force->overload_share;
  for (std::size_t i = 0; i < devices::kAxes; ++i) {
    const devices::AxisOptions& axis = config.stage->axis(i);
    envelope.axes_mm[i] = {axis.low.value(), axis.high.value()};
  }
  return press_complaints({recipe.press.positions_mm, recipe.press.forces_n}, press_options(config, recipe), envelope);
}

void StageSteps::open(const sequences::Recipe& recipe) {
  Rig& rig = sequencer_.rig();
  if (rig.stage_gate() == nullptr || !rig.config().force) {
    throw Error("TB-BENCH-NO-STAGE",
                fmt::format("recipe '{}' presses, but the bench has no stage or no force sensor", recipe.name),
                rig.config().file);
  }
  // The module's watchdog may set its outputs to 0 meanwhile, where they are anyway.
  if (rig.source().armed()) rig.source().disarm();
  if (press_ && rig.stage_gate()->armed()) return;
  devices::ForceSensor& force = rig.force() != nullptr ? *rig.force() : rig.open_force();
  if (!rig.stage_gate()->armed()) rig.stage_gate()->arm();
  const PressOptions options = press_options(rig.config(), recipe);
  // The calibrated range is known only once the sensor is open. Nothing has moved yet.
  const std::vector<std::string> complaints = press_complaints(recipe, rig.config(), force.range());
  if (!complaints.empty()) {
    throw Error("TB-PRESS-LIMIT", fmt::format("recipe '{}': {}", recipe.name, complaints.front()), rig.config().file);
  }
  PressHooks hooks;
  hooks.wait = [this](devices::Nanoseconds time) { sequencer_.wait_until(time); };
  hooks.event = [this](const std::string& id, const std::string& text) { recorder_.event("stage", id, text); };
  press_ = std::make_unique<Press>(*rig.stage_gate(), force, rig.clock(), options, hooks);
}

void StageSteps::carry_out(const Step& step, const sequences::Recipe& recipe) {
  open(recipe);
  TimeSpent& times = sequencer_.times();
  (void)times.start(Spent::kMoving);
  switch (step.kind) {
    case StepKind::kTare: {
      const TareReading tare = press_->tare();
      nlohmann::ordered_json json = {{"removed_fz_n", tare.removed.wrench.force_n[2]}};
      if (tare.drift) json["drift_fz_n"] = tare.drift->force_n[2];
      const bool scatters = tare.removed.spread_n > press_->options().tolerance(0.0);
      if (scatters) json["spread_n"] = tare.removed.spread_n;
      const auto removed = six(tare.removed.wrench);
      recorder_.check("tare", scatters ? "warning" : "pass", analysis::json_line(json),
                      {removed.begin(), removed.end()});
      return;
    }
    case StepKind::kHome:
      return press_->home();
    case StepKind::kMoveXy:
      press_->move_xy(step.x_mm, step.y_mm);
      x_mm_ = step.x_mm;
      y_mm_ = step.y_mm;
      return;
    case StepKind::kApproach:
      (void)press_->approach();
      return;
    case StepKind::kPress:
      return press(step, recipe);
    case StepKind::kRetract: {
      const RetractProof proof = press_->retract();
      if (proof.verified) return;
      throw devices::Fault("TB-PRESS-NOT-CLEAR", "stage z", proof.text, "check the indenter before any move");
    }
    default:
      throw std::logic_error("no step of the stage");
  }
}

void StageSteps::press(const Step& step, const sequences::Recipe& recipe) {
  Rig& rig = sequencer_.rig();
  const std::uint64_t exchanges_before = rig.exchanges();
  StepReadings readings;
  PressLevel level;
  level.force_n = step.force_n;
  level.branch = step.force_to_n >= step.force_from_n ? Branch::kLoading : Branch::kUnloading;
  level.dwell_s = step.dwell_s;
  level.hold_force = step.hold_force;
  std::function<void()> frame;
  if (sequences::has_frame(step)) frame = [&] { readings.scans = sequencer_.read_array(readings.flags); };
  (void)sequencer_.times().start(Spent::kDwelling);
  const PressReading reading = press_->press(level, frame);
  if (reading.broken) {
    throw PathBroken{fmt::format("{:.3f} N at a level of {:g} N: {:.3f} N beyond it", reading.broken->force_n,
                                 reading.broken->target_n, reading.broken->overshoot_n)};
  }
  if (!frame) return;
  readings.commanded_at = reading.commanded_at;
  readings.in_band_since = reading.in_band_since;
  readings.exchanges = static_cast<int>(rig.exchanges() - exchanges_before);
  const double dwelt = std::chrono::duration<double>(readings.scans.time - reading.in_band_since).count();
  if (std::abs(dwelt - step.dwell_s) > recipe.dwell_tolerance_s) {
    readings.flags += readings.flags.empty() ? "dwell" : " dwell";
  }
  // Then a mean, of the force or of its zero, hides that most of its records were elsewhere.
  if (reading.spread_n > press_->options().tolerance(level.force_n)) {
    readings.flags += readings.flags.empty() ? "force-spread" : " force-spread";
  }
  db::WrenchRecord wrench;
  wrench.target_n = step.force_n;
  wrench.force_start_n = reading.start.force_n;
  wrench.wrench = six(reading.wrench);
  for (std::size_t i = 0; i < 6; ++i) wrench.raw[i] = 0.5 * (reading.before.raw[i] + reading.after.raw[i]);
  wrench.place_mm = {x_mm_, y_mm_, reading.z_mm};
  readings.wrench = wrench;
  recorder_.frame(step, readings);
  if (!recipe.press.registers) return;
  touches_.push_back({x_mm_, y_mm_, unloaded_frame_of(readings.scans)});
}

void StageSteps::forget() { press_.reset(); }

void StageSteps::register_mount(double pitch_mm, const std::vector<double>& baseline) {
  if (touches_.empty()) return;
  const devices::TactileArray& array = sequencer_.rig().array();
  const double least = 0.05 / array.volts_per_count().value();
  std::vector<Touch> touches;
  for (const TouchFrame& touch : touches_) {
    touches.push_back({touch.x_mm, touch.y_mm,
                       touch_centre_mm(touch.counts, baseline, array.rows(), array.columns(), pitch_mm, least)});
  }
  touches_.clear();
  RegistrationOptions options;
  options.max_rms_mm = 0.4 * pitch_mm;  // a point smaller than a taxel cannot be located better
  const MountRegistration mount = bench::register_mount(touches, pitch_mm, options);
  recorder_.check("mount", "pass", mount.json(),
                  {mount.angle_deg, mount.offset_mm[0], mount.offset_mm[1], mount.rms_mm});
}

}  // namespace tactbench::bench
