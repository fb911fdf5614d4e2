#include "bench/monitor/heat_map.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <numeric>

#include "analysis/counted.h"
#include "analysis/error.h"
#include "analysis/identify/histories.h"
#include "analysis/json_io.h"
#include "analysis/scanner_scale.h"
#include "db/run_reader.h"

namespace tactbench::bench {
namespace {

constexpr std::size_t kIndent = 2;
constexpr std::size_t kGap = 3;         // between map and text
constexpr std::size_t kBesideMap = 34;  // columns of the text
constexpr std::size_t kNamed = 3;       // taxels listed by name, per kind

struct Cell {
  double volts = 0.0;
  bool dead = false;  // all its taxels
};

struct Grid {
  std::size_t rows = 0, columns = 0, taxels = 1;  // taxels: in each direction of a cell
  std::vector<Cell> cells;
};

std::size_t parts(std::size_t whole, std::size_t part) { return (whole + part - 1) / part; }

Grid grid_of(const ArrayView& view, std::size_t taxels) {
  const auto rows = static_cast<std::size_t>(view.rows), columns = static_cast<std::size_t>(view.columns);
  Grid grid{parts(rows, taxels), parts(columns, taxels), taxels, {}};
  std::vector<bool> dead(rows * columns, false);
  for (const int taxel : view.dead) dead[static_cast<std::size_t>(taxel)] = true;
  for (std::size_t row = 0; row < rows; row += taxels) {
    for (std::size_t column = 0; column < columns; column += taxels) {
      Cell cell{0.0, true};
      std::size_t count = 0;
      for (std::size_t r = row; r < std::min(rows, row + taxels); ++r) {
        for (std::size_t c = column; c < std::min(columns, column + taxels); ++c, ++count) {
          cell.volts += view.volts[r * columns + c];
          cell.dead = cell.dead && dead[r * columns + c];
        }
      }
      cell.volts /= static_cast<double>(count);
      grid.cells.push_back(cell);
    }
  }
  return grid;
}

std::string shade_text(std::size_t shade, Shades shades) {
  return std::string(2, shades == Shades::kColours ? ' ' : kShadeCharacters[shade]);
}

Span painted_shade(std::size_t shade, Shades shades) {
  return {shade_text(shade, shades), shades == Shades::kColours ? kShadeColours[shade] : -1};
}

std::string place(const ArrayView& view, int taxel) {
  return fmt::format("row {}, column {}", taxel / view.columns, taxel % view.columns);
}

// The text next to the map's rows.
std::vector<PaintedLine> map_and_list(const ArrayView& view, Shades shades, std::size_t taxels) {
  const double top = scale_top_v(view);
  std::vector<PaintedLine> lines;
  for (std::size_t shade = kShades; shade-- > 0;) {
    const double from = top * static_cast<double>(shade) / kShades;
    lines.push_back({painted_shade(shade, shades), {fmt::format(" from {:.2f} V", from)}});
  }
  std::vector<int> order(view.volts.size());
  std::iota(order.begin(), order.end(), 0);
  const auto named = std::min(kNamed, order.size());
  std::partial_sort(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(named), order.end(), [&](int a, int b) {
    const double one = view.volts[static_cast<std::size_t>(a)], other = view.volts[static_cast<std::size_t>(b)];
    return one != other ? one > other : a < b;
  });
  for (std::size_t i = 0; i < named; ++i) {
    lines.push_back({{fmt::format("{:<8}{}  {:.2f} V", i == 0 ? "hottest" : "", place(view, order[i]),
                                  view.volts[static_cast<std::size_t>(order[i])])}});
  }
  if (!view.dead_are_known) {
    lines.push_back({{"dead    not judged"}});
  } else if (view.dead.empty()) {
    lines.push_back({{"dead    none"}});
  }
  for (std::size_t i = 0; i < std::min(view.dead.size(), kNamed); ++i) {
    const std::size_t more = view.dead.size() - kNamed;
    const bool cut = i + 1 == kNamed && view.dead.size() > kNamed;
    lines.push_back({{fmt::format("{:<8}{}{}", i == 0 ? "dead" : "", place(view, view.dead[i]),
                                  cut ? fmt::format(", {} more", more) : "")}});
  }
  if (taxels > 1) lines.push_back({{fmt::format("cell    mean of {0} x {0} taxels", taxels)}});
  return lines;
}

}  // namespace

Shades shades_of_terminal() {
  const auto set = [](const char* name) {
    const char* value = std::getenv(name);
    return std::string(value != nullptr ? value : "");
  };
  if (!set("NO_COLOR").empty()) return Shades::kCharacters;
  const bool many = set("TERM").find("256color") != std::string::npos || !set("COLORTERM").empty();
  return many ? Shades::kColours : Shades::kCharacters;
}

std::size_t shade_of(double volts, double top_v) {
  const double share = volts / top_v * kShades;
  if (!(share > 0.0)) return 0;
  return std::min(kShades - 1, static_cast<std::size_t>(std::min(share, 1.0 * kShades)));
}

double scale_top_v(const ArrayView& view) {
  const double highest = view.volts.empty() ? 0.0 : *std::max_element(view.volts.begin(), view.volts.end());
  return std::max({highest, 0.1 * view.full_scale_v, 1e-9});
}

std::vector<PaintedLine> heat_map(const ArrayView& view, Shades shades, std::size_t columns, std::size_t rows) {
  if (view.volts.empty() || rows < 2 || columns < kIndent + 3) return {};
  std::size_t taxels = 1;
  const auto high = static_cast<std::size_t>(view.rows), wide = static_cast<std::size_t>(view.columns);
  while (parts(high, taxels) > rows - 1 || kIndent + 2 * parts(wide, taxels) > columns - 1) ++taxels;
  const Grid grid = grid_of(view, taxels);
  const double top = scale_top_v(view);
  const std::size_t map_columns = kIndent + 2 * grid.columns;
  std::vector<PaintedLine> text = map_and_list(view, shades, taxels);
  if (map_columns + kGap + kBesideMap >= columns) text.clear();
  std::vector<PaintedLine> lines{
      {{fmt::format("  array     {}, {} x {} taxels", view.title, view.rows, view.columns)}}};
  const std::size_t count = std::min(rows - 1, std::max(grid.rows, text.size()));
  for (std::size_t row = 0; row < count; ++row) {
    PaintedLine& line = lines.emplace_back(PaintedLine{{std::string(kIndent, ' ')}});
    for (std::size_t column = 0; column < grid.columns && row < grid.rows; ++column) {
      const Cell& cell = grid.cells[row * grid.columns + column];
      Span span = painted_shade(shade_of(cell.volts, top), shades);
      if (cell.dead) span = {"xx", -1};
      if (line.size() > 1 && line.back().colour == span.colour) {
        line.back().text += span.text;
      } else {
        line.push_back(std::move(span));
      }
    }
    if (row >= text.size()) continue;
    const std::size_t blanks = kGap + (row < grid.rows ? 0 : 2 * grid.columns);
    line.push_back({std::string(blanks, ' ')});
    line.insert(line.end(), text[row].begin(), text[row].end());
  }
  return lines;
}

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

std::optional<ArrayBasis> array_basis(const db::RunReader& store, const db::RunRecord& run) try {
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

std::optional<ArrayView> newest_array(const db::RunReader& store, const db::RunRecord& run,
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
