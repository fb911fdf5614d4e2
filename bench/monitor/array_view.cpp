#include "bench/monitor/array_view.h"

#include <fmt/format.h>

#include <cstdint>
#include <nlohmann/json.hpp>

#include "analysis/error.h"
#include "analysis/identify/taxel_status.h"
#include "analysis/json_io.h"
#include "analysis/scanner_scale.h"
#include "db/newest.h"

namespace tactbench::bench {

namespace {

constexpr double kConverterRange = 65535.0;
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

std::vector<double> mean_volts(const db::NewestFrame& frame, double scale) {
  const std::size_t taxels = static_cast<std::size_t>(frame.rows) * static_cast<std::size_t>(frame.columns);
  std::vector<double> volts(taxels, 0.0);
  for (std::size_t i = 0; i < frame.counts.size(); ++i) volts[i % taxels] += scale * frame.counts[i] / frame.scans;
  return volts;
}

void find_dead(ArrayView& view, const std::optional<Seating>& seating, double pressure_psi) {
  if (!seating || seating->unloaded_v.size() != view.volts.size() || pressure_psi < kJudgedPsi) return;
  view.dead_are_known = true;
  for (std::size_t i = 0; i < view.volts.size(); ++i)
    if (view.volts[i] - seating->unloaded_v[i] < analysis::kDeadV) view.dead.push_back(static_cast<int>(i));
}

}  // namespace

std::optional<ArrayView> newest_array(const db::RunStore& store, const db::RunRecord& run) {
  const std::optional<db::NewestFrame> frame = db::newest_frame(store, run.run);
  const std::optional<Seating> seating = seating_of(store.checks(run.run));
  if (!frame && !seating) return std::nullopt;
  double scale = 0.0;
  try {
    scale = analysis::volts_per_count(run);
  } catch (const analysis::AnalysisError&) {
    return std::nullopt;
  }
  ArrayView view;
  view.full_scale_v = scale * kConverterRange;
  if (!frame) {
    view.title = fmt::format("seating check at {:.1f} psi", seating->pressure_psi);
    view.rows = seating->rows;
    view.columns = seating->columns;
    view.volts = seating->loaded_v;
    find_dead(view, seating, seating->pressure_psi);
    return view;
  }
  view.rows = frame->rows;
  view.columns = frame->columns;
  view.volts = mean_volts(*frame, scale);
  if (frame->force_n) {  // an object presses on a part of the array
    view.title = fmt::format("frame {} at {:.2f} N", frame->position, *frame->force_n);
  } else {
    view.title = fmt::format("frame {} at {:.1f} psi", frame->position, frame->reference_psi);
    find_dead(view, seating, frame->reference_psi);
  }
  return view;
}

}  // namespace tactbench::bench
