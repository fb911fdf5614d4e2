#include "analysis/statistics/studies/contact.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <numbers>
#include <optional>
#include <set>
#include <stdexcept>
#include <utility>

#include "analysis/error.h"
#include "analysis/identify/sensor_model.h"
#include "analysis/json_io.h"
#include "analysis/scanner_scale.h"
#include "analysis/statistics/figures/levels.h"
#include "db/record.h"

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

namespace {

// One frame read both ways.
struct ReadFrame {
  const PressFrame* frame;
  std::vector<double> raw_psi, compensated_psi;
  ContactFigures raw, compensated;
  int clamped = 0;
};

std::vector<ReadFrame> read_frames(const PressRun& run, const SensorModel& fit, const ArrayGeometry& geometry) {
  const ModelTaxel& mean = fit.mean_taxel();
  const double per_volt = (mean.xu() - mean.x0()) / (mean.yu() - mean.y0());
  const double sign = fit.falling ? -1.0 : 1.0;
  std::vector<std::unique_ptr<Compensator>> compensators;
  for (const ModelTaxel& taxel : fit.array())
    compensators.push_back(taxel.fitted() ? compensator_of(fit, taxel) : nullptr);
  std::vector<ReadFrame> out;
  const PressFrame* before = nullptr;
  for (const PressFrame& frame : run.frames) {
    // Between two rises the object was lifted off.
    const bool new_rise = before == nullptr || frame.repeat != before->repeat || frame.position != before->position ||
                          (frame.rising && !before->rising);
    const double seconds = before == nullptr ? 0.0 : std::max(0.0, frame.time_s - before->time_s);
    before = &frame;
    ReadFrame read{&frame, {}, {}, {}, {}, 0};
    for (std::size_t i = 0; i < frame.volts.size(); ++i) {
      const double volts = sign * frame.volts[i];
      if (compensators[i] == nullptr) {
        read.raw_psi.push_back(kNan);
        read.compensated_psi.push_back(kNan);
        continue;
      }
      if (new_rise) compensators[i]->rest(seconds);
      read.raw_psi.push_back(mean.x0() + (volts - mean.y0()) * per_volt);
      read.compensated_psi.push_back(compensators[i]->step(volts, new_rise ? 0.0 : seconds).pressure_psi);
      read.clamped += read.compensated_psi.back() >= mean.xu() ? 1 : 0;
    }
    read.raw = contact_figures(read.raw_psi, run.rows, run.columns, geometry);
    read.compensated = contact_figures(read.compensated_psi, run.rows, run.columns, geometry);
    out.push_back(std::move(read));
  }
  return out;
}

void add_weighted(ContactFigures& sum, const ContactFigures& own, double weight) {
  for (double ContactFigures::*figure :
       {&ContactFigures::force_n, &ContactFigures::x_mm, &ContactFigures::y_mm, &ContactFigures::moment_x_nmm,
        &ContactFigures::moment_y_nmm, &ContactFigures::area_mm2, &ContactFigures::threshold_psi})
    sum.*figure += weight * own.*figure;
}

double std_share(const std::vector<double>& values, double full_scale) {
  return sample_deviation(finite_of(values)) / full_scale;
}

// Mean place of each position, read one way.
using Places = std::map<int, std::array<double, 2>>;
Places mean_places(const std::vector<ReadFrame>& frames, ContactFigures ReadFrame::*way) {
  std::map<int, std::array<double, 3>> sums;
  for (const ReadFrame& read : frames) {
    const ContactFigures& own = read.*way;
    auto& sum = sums[read.frame->position];
    sum[0] += own.x_mm;
    sum[1] += own.y_mm;
    sum[2] += 1.0;
  }
  Places out;
  for (const auto& [position, sum] : sums) out[position] = {sum[0] / sum[2], sum[1] / sum[2]};
  return out;
}

struct LevelMaker {
  const PressRun& run;
  const SensorModel& fit;
  const ContactResult& result;
  const std::vector<ReadFrame>& frames;
  Places raw_places, compensated_places;

  double off_axis(const PressFrame& frame, const ContactFigures& own) const {
    if (run.mount.empty()) return kNan;
    const auto taxel = run.mount.front().taxel_mm(frame.place_mm[0], frame.place_mm[1]);
    const double x = taxel[0] - 0.5 * (run.columns - 1) * result.geometry.pitch_mm;
    const double y = taxel[1] - 0.5 * (run.rows - 1) * result.geometry.pitch_mm;
    return std::hypot(own.x_mm - x, own.y_mm - y);
  }
  static double wander(const ContactFigures& own, const std::array<double, 2>& mean) {
    return std::hypot(own.x_mm - mean[0], own.y_mm - mean[1]);
  }

  ContactLevel level(double target, bool rising) const {
    std::vector<const ReadFrame*> chosen;
    for (const ReadFrame& read : frames)
      if (read.frame->rising == rising && read.frame->target_n == target) chosen.push_back(&read);
    ContactLevel out;
    out.target_n = target;
    out.rising = rising;
    out.frames = static_cast<int>(chosen.size());
    const double weight = 1.0 / static_cast<double>(chosen.size());
    const int first_position = chosen.front()->frame->position;
    double shown = 0.0;
    for (const ReadFrame* read : chosen) shown += read->frame->position == first_position ? 1.0 : 0.0;
    out.raw_v.assign(fit.array().size(), 0.0);
    out.compensated_psi.assign(fit.array().size(), 0.0);
    std::vector<double> fitted_v(fit.array().size(), kNan);
    for (const ReadFrame* read : chosen) {
      const PressFrame& frame = *read->frame;
      out.force_n += weight * frame.force_n;
      out.torque_nmm += weight * std::hypot(frame.wrench[3], frame.wrench[4]);
      add_weighted(out.raw, read->raw, weight);
      add_weighted(out.compensated, read->compensated, weight);
      out.raw_force_error_n += weight * std::abs(read->raw.force_n - frame.force_n);
      out.compensated_force_error_n += weight * std::abs(read->compensated.force_n - frame.force_n);
      out.raw_place_error_mm += weight * off_axis(frame, read->raw);
      out.compensated_place_error_mm += weight * off_axis(frame, read->compensated);
      out.raw_wander_mm += weight * wander(read->raw, raw_places.at(frame.position));
      out.compensated_wander_mm += weight * wander(read->compensated, compensated_places.at(frame.position));
      out.clamped_taxels += weight * read->clamped;
      if (frame.position != first_position) continue;
      for (std::size_t i = 0; i < frame.volts.size(); ++i) {
        out.raw_v[i] += frame.volts[i] / shown;
        out.compensated_psi[i] += read->compensated_psi[i] / shown;
      }
    }
    for (std::size_t i = 0; i < fitted_v.size(); ++i)
      if (fit.taxels[i].status == TaxelStatus::kFitted) fitted_v[i] = out.raw_v[i];
    out.raw_std = std_share(fitted_v, result.full_scale_v);
    out.compensated_std = std_share(out.compensated_psi, result.full_scale_psi);
    return out;
  }
};

double mean_distance(const std::vector<double>& up, const std::vector<double>& down, const SensorModel& fit,
                     double full_scale) {
  double sum = 0.0, n = 0.0;
  for (std::size_t i = 0; i < up.size(); ++i) {
    if (fit.taxels[i].status != TaxelStatus::kFitted) continue;
    sum += std::abs(up[i] - down[i]);
    n += 1.0;
  }
  return sum / n / full_scale;
}

}  // namespace

ContactResult contact_result(const PressRun& run, const SensorModel& fit, const ArrayGeometry& geometry) {
  check_same_sensor(
      {fmt::format("run {}", run.run), run.origin, run.sensor_serial, run.scanner_serial, run.rows, run.columns}, fit);
  ContactResult out;
  out.run = run.run;
  out.mount_run = run.mount.empty() ? 0 : run.mount.front().run;
  out.sequence = run.sequence;
  out.object = run.object;
  out.geometry = geometry;
  out.full_scale_v = fit.full_scale_v();
  out.full_scale_psi = fit.pressure_psi.back();
  const std::vector<ReadFrame> frames = read_frames(run, fit, geometry);
  std::set<int> positions, repeats;
  std::set<double> rising, falling;
  for (const ReadFrame& read : frames) {
    positions.insert(read.frame->position);
    repeats.insert(read.frame->repeat);
    (read.frame->rising ? rising : falling).insert(read.frame->target_n);
    const double raw = std::abs(read.raw.force_n - read.frame->force_n);
    const double compensated = std::abs(read.compensated.force_n - read.frame->force_n);
    out.raw_mean_error_n += raw / static_cast<double>(frames.size());
    out.compensated_mean_error_n += compensated / static_cast<double>(frames.size());
    out.raw_max_error_n = std::max(out.raw_max_error_n, raw);
    out.compensated_max_error_n = std::max(out.compensated_max_error_n, compensated);
  }
  out.positions = static_cast<int>(positions.size());
  out.repeats = static_cast<int>(repeats.size());
  const LevelMaker maker{
      run, fit, out, frames, mean_places(frames, &ReadFrame::raw), mean_places(frames, &ReadFrame::compensated)};
  std::vector<ContactLevel> levels;
  for (const double target : rising) levels.push_back(maker.level(target, true));
  for (auto target = falling.rbegin(); target != falling.rend(); ++target)
    levels.push_back(maker.level(*target, false));
  for (const double target : rising) {
    const auto at = [&](bool up) {
      return std::ranges::find_if(levels,
                                  [&](const ContactLevel& own) { return own.rising == up && own.target_n == target; });
    };
    const auto up = at(true), down = at(false);
    const bool both = down != levels.end();
    out.raw_distance.push_back(both ? mean_distance(up->raw_v, down->raw_v, fit, out.full_scale_v) : kNan);
    out.compensated_distance.push_back(
        both ? mean_distance(up->compensated_psi, down->compensated_psi, fit, out.full_scale_psi) : kNan);
  }
  out.levels = std::move(levels);
  return out;
}

namespace {

constexpr double kContactShare = 0.1, kLeastContactPsi = 0.5;

}  // namespace

ContactFigures contact_figures(std::span<const double> pressure_psi, int rows, int columns,
                               const ArrayGeometry& geometry) {
  if (pressure_psi.size() != static_cast<std::size_t>(rows) * static_cast<std::size_t>(columns))
    throw std::invalid_argument("a frame of pressures has one value a taxel");
  ContactFigures out;
  double peak = 0.0, in_contact = 0.0;
  for (const double pressure : pressure_psi)
    if (std::isfinite(pressure)) peak = std::max(peak, pressure);
  out.threshold_psi = std::max(kLeastContactPsi, kContactShare * peak);
  for (std::size_t i = 0; i < pressure_psi.size(); ++i) {
    if (!std::isfinite(pressure_psi[i])) continue;
    const auto row = static_cast<int>(i) / columns, column = static_cast<int>(i) % columns;
    const double x = (column - 0.5 * (columns - 1)) * geometry.pitch_mm;
    const double y = (row - 0.5 * (rows - 1)) * geometry.pitch_mm;
    const double force = pressure_psi[i] * geometry.taxel_area_mm2 * kNewtonPerPsiMm2;
    out.force_n += force;
    if (pressure_psi[i] < out.threshold_psi) continue;
    in_contact += force;
    out.moment_x_nmm += force * y;
    out.moment_y_nmm -= force * x;
    out.area_mm2 += geometry.taxel_area_mm2;
  }
  const bool pressed = in_contact > 0.0;
  out.x_mm = pressed ? -out.moment_y_nmm / in_contact : kNan;
  out.y_mm = pressed ? out.moment_x_nmm / in_contact : kNan;
  return out;
}

}  // namespace tactbench::analysis
