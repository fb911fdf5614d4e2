#include <algorithm>
#include <array>
#include <cmath>

#include "analysis/report/page/figure.h"
#include "analysis/report/page/gum_numbers.h"

namespace tactbench::analysis {
namespace {

using html::Attribute;
using html::CssNumber;
using html::markup;
using html::Markup;
using html::Text;

constexpr int kBins = 32;

struct Colour {
  double red, green, blue;
};

// Ten equidistant colours of cividis.
constexpr std::array<Colour, 10> kCividis = {{{0, 32, 77},
                                              {0, 51, 111},
                                              {57, 72, 107},
                                              {87, 92, 109},
                                              {112, 113, 115},
                                              {138, 135, 121},
                                              {166, 157, 117},
                                              {196, 181, 108},
                                              {228, 207, 91},
                                              {255, 234, 70}}};

Colour colour_at(double t) {
  const double position = std::clamp(t, 0.0, 1.0) * static_cast<double>(kCividis.size() - 1);
  const auto i = std::min(static_cast<std::size_t>(position), kCividis.size() - 2);
  const double part = position - static_cast<double>(i);
  const auto mix = [part](double from, double to) { return from + part * (to - from); };
  const Colour &a = kCividis[i], &b = kCividis[i + 1];
  return {mix(a.red, b.red), mix(a.green, b.green), mix(a.blue, b.blue)};
}

// WCAG 2 relative luminance.
double luminance(const Colour& colour) {
  const auto linear = [](double channel) {
    const double c = channel / 255.0;
    return c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4);
  };
  return 0.2126 * linear(colour.red) + 0.7152 * linear(colour.green) + 0.0722 * linear(colour.blue);
}

double share(const ColourScale& scale, double value) {
  if (!(scale.high > scale.low)) return 0.0;
  return std::clamp((value - scale.low) / (scale.high - scale.low), 0.0, 1.0);
}

// -1: no value.
int bin_of(const FrameMap& map, std::size_t cell) {
  if (cell >= map.values.size() || !std::isfinite(map.values[cell])) return -1;
  return std::min(kBins - 1, static_cast<int>(share(map.scale, map.values[cell]) * kBins));
}

std::vector<int> bins_of(const FrameMap& map) {
  std::vector<int> bins(static_cast<std::size_t>(map.rows * map.columns));
  for (std::size_t cell = 0; cell < bins.size(); ++cell) bins[cell] = bin_of(map, cell);
  return bins;
}

double middle_of(int bin) { return (bin + 0.5) / kBins; }

// The commonest colour lies under all cells: what shines through at the edges of cells is then not white.
int commonest_bin(const std::vector<int>& bins) {
  std::array<int, kBins> counts{};
  for (const int bin : bins)
    if (bin >= 0) ++counts[static_cast<std::size_t>(bin)];
  return static_cast<int>(std::max_element(counts.begin(), counts.end()) - counts.begin());
}

// M3 5h2.04v1.04h-2.04z: cells overlap by .04, without which a PDF shows hairlines between them.
void add_rectangle(html::PathData& path, int column, int row, int width) {
  path.literal("M").number(column).literal(" ").number(row);
  path.literal("h").number(width).literal(".04v1.04h-").number(width).literal(".04z");
}

// Cells in units of one; runs of one colour in a row are one rectangle.
Markup cells(const FrameMap& map) {
  std::array<html::PathData, kBins> paths;
  std::string blanks, crosses;
  const std::vector<int> bins = bins_of(map);
  for (int row = 0; row < map.rows; ++row) {
    for (int column = 0; column < map.columns;) {
      const auto cell = static_cast<std::size_t>(row * map.columns + column);
      const int bin = bins[cell];
      int run = 1;
      if (bin < 0) {
        blanks += fmt::format("M{} {}h1v1h-1z", column, row);
        crosses += fmt::format("M{} {}l.6 .6m0 -.6l-.6 .6", CssNumber(column + 0.2), CssNumber(row + 0.2));
      } else {
        while (column + run < map.columns && bins[cell + static_cast<std::size_t>(run)] == bin) ++run;
        add_rectangle(paths[static_cast<std::size_t>(bin)], column, row, run);
      }
      column += run;
    }
  }
  const int base = commonest_bin(bins);
  Markup out =
      markup("<path fill=\"{}\" d=\"M0 0h{}v{}H0z\"/>", Attribute(cividis(middle_of(base))), map.columns, map.rows);
  for (int bin = 0; bin < kBins; ++bin) {
    const html::PathData& path = paths[static_cast<std::size_t>(bin)];
    if (bin == base || path.value.empty()) continue;
    out += markup("<path fill=\"{}\" d=\"{}\"/>", Attribute(cividis(middle_of(bin))), path);
  }
  if (!blanks.empty()) {
    out += markup("<path fill=\"#ffffff\" d=\"{}\"/><path class=\"cross\" d=\"{}\"/>", Attribute(blanks),
                  Attribute(crosses));
  }
  return out;
}

double cell_size(const FrameMap& map) { return map.size / std::max({1, map.rows, map.columns}); }

// Coordinates are pixels, the cells are scaled: letters in units of cells would meet the browser's smallest font size.
Markup open_svg(const FrameMap& map) {
  const double cell = cell_size(map);
  const CssNumber width(cell * map.columns), height(cell * map.rows);
  return markup(
      "<svg role=\"img\" class=\"map\" viewBox=\"0 0 {0} {1}\" width=\"{0}\" height=\"{1}\"><title>{2}</title>"
      "<g transform=\"scale({3})\">{4}</g>",
      width, height, Text(map.title), CssNumber(cell, 4), cells(map));
}

}  // namespace

std::string cividis(double t) {
  const Colour c = colour_at(t);
  return fmt::format("#{:02x}{:02x}{:02x}", static_cast<unsigned>(std::lround(c.red)),
                     static_cast<unsigned>(std::lround(c.green)), static_cast<unsigned>(std::lround(c.blue)));
}

Markup frame_map(const FrameMap& map) {
  Markup out = open_svg(map);
  out += markup("</svg>");
  return out;
}

Markup numbered_map(const FrameMap& map, int digits) {
  Markup out = open_svg(map);
  const double size = cell_size(map);
  for (int row = 0; row < map.rows; ++row) {
    for (int column = 0; column < map.columns; ++column) {
      const auto cell = static_cast<std::size_t>(row * map.columns + column);
      const int bin = bin_of(map, cell);
      if (bin < 0) continue;
      // Black on colours above 0.18 of luminance, else white: at least 4.5:1 either way.
      const bool dark = luminance(colour_at(middle_of(bin))) < 0.18;
      out +=
          markup("<text class=\"cell\" x=\"{}\" y=\"{}\" fill=\"{}\">{}</text>", CssNumber(size * (column + 0.5), 1),
                 CssNumber(size * (row + 0.5) + 3.2, 1), Attribute(dark ? "#ffffff" : "#000000"),
                 digits == kTwoSignificant ? gum_uncertainty(map.values[cell]) : html::fixed(map.values[cell], digits));
    }
  }
  out += markup("</svg>");
  return out;
}

Markup colour_bar(const Text& low, const Text& high, const std::string& title) {
  // Each colour reaches to the right end and is covered by the next: no seams.
  Markup cells_of_bar;
  for (int bin = 0; bin < kBins; ++bin) {
    cells_of_bar +=
        markup("<path fill=\"{}\" d=\"M{} 0H160v10H{}z\"/>", Attribute(cividis(middle_of(bin))), 5 * bin, 5 * bin);
  }
  return markup(
      "<p class=\"scale\">{} <svg role=\"img\" viewBox=\"0 0 160 10\" width=\"160\" "
      "height=\"10\"><title>{}</title>{}"
      "</svg> {}</p>",
      low, Text(title), cells_of_bar, high);
}

Markup colour_bar(const ColourScale& scale, const std::string& title, const std::string& unit, int digits) {
  const auto end = [&](double value) { return Text(html::fixed(value, digits).value + " " + unit); };
  return colour_bar(end(scale.low), end(scale.high), title);
}

}  // namespace tactbench::analysis
