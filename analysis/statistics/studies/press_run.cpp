#include "analysis/statistics/studies/press_run.h"

#include <fmt/format.h>

#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <numbers>

#include "analysis/json_io.h"
#include "analysis/scanner_scale.h"
#include "db/scan_means.h"

namespace tactbench::analysis {
namespace {

std::vector<double> frame_volts(const db::FrameRecord& frame, double volts_a_count) {
  const auto taxels = static_cast<std::size_t>(frame.rows) * static_cast<std::size_t>(frame.columns);
  const auto scans = static_cast<std::size_t>(std::max(0, frame.scans));
  if (scans == 0 || frame.counts.size() != taxels * scans)
    throw AnalysisError("TB-ANALYSIS-FRAME",
                        fmt::format("frame {} of branch {} does not hold {} x {} x {} counts", frame.ordinal,
                                    frame.branch, frame.rows, frame.columns, frame.scans),
                        "check the store: tactbench verify");
  std::vector<double> volts = db::scan_means(frame.counts, scans);
  for (double& value : volts) value *= volts_a_count;
  return volts;
}

}  // namespace

std::array<double, 2> MountTransform::taxel_mm(double stage_x_mm, double stage_y_mm) const {
  const double turn = -angle_deg * std::numbers::pi / 180.0;
  const double x = (stage_x_mm - offset_mm[0]) / scale, y = (stage_y_mm - offset_mm[1]) / scale;
  const double along = std::cos(turn) * x - std::sin(turn) * y, down = std::sin(turn) * x + std::cos(turn) * y;
  return {along, flipped ? -down : down};
}

std::vector<MountTransform> mount_of(const StoredRun& run) {
  std::vector<MountTransform> out;
  for (const db::CheckRecord& check : run.checks) {
    if (check.kind != "mount") continue;
    const auto json = try_json(check.detail_json);
    if (!json.is_object() || !json.contains("angle_deg") || !json.contains("offset_mm")) continue;
    MountTransform mount;
    mount.run = run.record.run;
    mount.angle_deg = json["angle_deg"].get<double>();
    mount.offset_mm = json["offset_mm"].get<std::array<double, 2>>();
    mount.flipped = json.value("flipped", false);
    mount.scale = json.value("scale", 1.0);
    out.assign(1, mount);  // of several the last
  }
  return out;
}

std::vector<PressRun> load_press_runs(const StoredRun& run) {
  const db::RunRecord& record = run.record;
  std::map<std::int64_t, db::BranchRecord> branches;
  for (const db::BranchRecord& branch : run.branches) branches.emplace(branch.branch, branch);
  std::map<int, PressRun> by_sequence;
  double scale = 0.0;
  for (const db::FrameRecord& frame : run.frames) {
    const auto branch = branches.find(frame.branch);
    if (!frame.wrench || branch == branches.end() || branch->second.is_void) continue;
    if (scale == 0.0) scale = volts_per_count(record);
    PressRun& press = by_sequence[branch->second.sequence];
    press.rows = frame.rows;
    press.columns = frame.columns;
    const db::WrenchRecord& wrench = *frame.wrench;
    PressFrame own;
    own.time_s = 1e-9 * static_cast<double>(frame.time_ns);
    own.repeat = branch->second.repeat;
    own.position = branch->second.ordinal / 2;  // a rising and a falling branch a place
    own.rising = branch->second.to_n.value_or(0.0) >= branch->second.from_n.value_or(0.0);
    own.target_n = wrench.target_n;
    // The sign of pressing in the force sensor's frame is the bench's; the force at the dwell's start has it taken out.
    own.force_n = wrench.wrench[2] * wrench.force_start_n < 0.0 ? -wrench.wrench[2] : wrench.wrench[2];
    own.wrench = wrench.wrench;
    own.place_mm = wrench.place_mm;
    own.volts = frame_volts(frame, scale);
    press.frames.push_back(std::move(own));
  }
  std::vector<PressRun> out;
  for (auto& [number, press] : by_sequence) {
    press.run = record.run;
    for (const db::SequenceRecord& sequence : record.sequences)
      if (sequence.sequence == number) press.sequence = sequence.name;
    press.origin = record.origin;
    press.sensor_serial = record.sensor_serial;
    press.scanner_serial = record.scanner_serial;
    press.mount = mount_of(run);
    out.push_back(std::move(press));
  }
  return out;
}

std::vector<PointFrame> point_frames(const PressRun& run) {
  std::vector<PointFrame> out;
  for (const PressFrame& frame : run.frames) out.push_back({frame.position, frame.rising, frame.force_n, frame.volts});
  return out;
}

}  // namespace tactbench::analysis
