#include "bench/monitor/array_view.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <nlohmann/json.hpp>

#include "analysis/error.h"
#include "analysis/identify/histories.h"
#include "analysis/json_io.h"
#include "analysis/scanner_scale.h"
#include "db/run_frame_reader.h"

namespace tactbench::bench {

namespace {

constexpr double kFullScaleCounts = 65535.0;
constexpr double kJudgedPsi = 5.0;  // below, weak taxels do not respond

struct Seating {
  int rows = 0, columns = 0;
  double pressure_psi = 0.0;
  std::vector<double> unloaded_v, loaded_v;
};

// The run's newest: a resumed run has two.
std::optional<Seating> seating_of(const std::vector<db::CheckRecord>& checks) {
  for (auto check = checks.rbegin(); check != checks.rend(); ++check) {
    if (check->kind != "seating") continue;
    const nlohmann::json detail = analysis::try_json(check->detail_json);
    if (!detail.is_object()) return std::nullopt;
    Seating seating;
    seating.rows = detail.value("rows", 0);
    seating.columns = detail.value("columns", 0);
    seating.pressure_psi = detail.value("pressure_psi", 0.0);
    const auto taxels = check->data.size() / 2;
    if (seating.rows <= 0 || seating.columns <= 0 ||
        taxels != static_cast<std::size_t>(seating.rows) * static_cast<std::size_t>(seating.columns))
      return std::nullopt;
    const double scale = detail.value("volts_per_count", 0.0);
    for (std::size_t i = 0; i < check->data.size(); ++i)
      (i < taxels ? seating.unloaded_v : seating.loaded_v).push_back(scale * check->data[i]);
    return seating;
  }
  return std::nullopt;
}

void find_dead(ArrayView& view, const std::vector<double>& unloaded_v, double pressure_psi) {
  if (unloaded_v.empty() || unloaded_v.size() != view.volts.size() || pressure_psi < kJudgedPsi) return;
  view.dead_are_known = true;
  for (std::size_t i = 0; i < view.volts.size(); ++i)
    if (view.volts[i] - unloaded_v[i] < analysis::kDeadV) view.dead.push_back(static_cast<int>(i));
}

std::vector<double> unloaded_of(const std::optional<Seating>& seating) {
  return seating ? seating->unloaded_v : std::vector<double>();
}

}  // namespace

std::optional<ArrayBasis> array_basis(const db::RunStore& store, const db::RunRecord& run) try {
  return ArrayBasis{analysis::volts_per_count(run), unloaded_of(seating_of(store.checks(run.run)))};
} catch (const analysis::AnalysisError&) {
  return std::nullopt;
}

ArrayView view_of_frame(const ArrayBasis& basis, const db::StoredFrame& frame, analysis::PressureUnit unit) {
  ArrayView view;
  view.full_scale_v = basis.volts_per_count * kFullScaleCounts;
  view.rows = frame.rows;
  view.columns = frame.columns;
  view.volts = db::mean_counts(frame);
  for (double& volts : view.volts) volts *= basis.volts_per_count;
  for (std::size_t i = 0; i < frame.counts.size(); ++i)
    if (frame.counts[i] == kFullScaleCounts) view.saturated.push_back(static_cast<int>(i % view.volts.size()));
  std::ranges::sort(view.saturated);
  view.saturated.erase(std::unique(view.saturated.begin(), view.saturated.end()), view.saturated.end());
  if (frame.wrench) {  // an object presses on a part of the array
    view.title = fmt::format("frame {} at {:.2f} N", frame.position, -frame.wrench->wrench[2]);
  } else {
    view.title = fmt::format("frame {} at {}", frame.position, unit.text(frame.reference_psi, 1));
    find_dead(view, basis.unloaded_v, frame.reference_psi);
  }
  return view;
}

std::optional<ArrayView> newest_array(const db::RunStore& store, const db::RunRecord& run,
                                      analysis::PressureUnit unit) {
  const std::optional<db::StoredFrame> frame = db::RunFrameReader(store, run.run).newest();
  const std::optional<Seating> seating = seating_of(store.checks(run.run));
  if (!frame && !seating) return std::nullopt;
  ArrayBasis basis{0.0, unloaded_of(seating)};
  try {
    basis.volts_per_count = analysis::volts_per_count(run);
  } catch (const analysis::AnalysisError&) {
    return std::nullopt;
  }
  if (frame) return view_of_frame(basis, *frame, unit);
  ArrayView view;
  view.full_scale_v = basis.volts_per_count * kFullScaleCounts;
  view.title = "seating check at " + unit.text(seating->pressure_psi, 1);
  view.rows = seating->rows;
  view.columns = seating->columns;
  view.volts = seating->loaded_v;
  find_dead(view, basis.unloaded_v, seating->pressure_psi);
  return view;
}

}  // namespace tactbench::bench
