#include "bench/monitor/heat_map.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <numeric>

#include "analysis/counted.h"

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
std::vector<PaintedLine> beside(const ArrayView& view, Shades shades, std::size_t taxels) {
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
  std::vector<PaintedLine> text = beside(view, shades, taxels);
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

}  // namespace tactbench::bench
