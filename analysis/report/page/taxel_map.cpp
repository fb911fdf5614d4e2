#include "analysis/report/page/taxel_map.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "analysis/report/page/html.h"

namespace tactbench::analysis {

namespace {

using html::Attribute;
using html::CssNumber;
using html::markup;
using html::Markup;
using html::Text;

constexpr int kShades = 24;
constexpr double kMargin = 18.0;  // for the counts of rows and columns

// 0 white .. 1 blue, which black letters stay readable on (7:1); below 0 brown.
std::string shade(double t) {
  const std::array<double, 3> end = t < 0.0 ? std::array{214.0, 150.0, 90.0} : std::array{96.0, 160.0, 222.0};
  const double part = std::min(std::abs(t), 1.0);
  std::string out = "#";
  for (const double channel : end)
    out += fmt::format("{:02x}", static_cast<unsigned>(std::lround(255.0 + part * (channel - 255.0))));
  return out;
}

double share_of(const TaxelMap& map, double value) {
  double share = map.logarithmic ? std::log(std::max(value, 1e-9) / map.low) / std::log(map.high / map.low)
                                 : (value - map.low) / (map.high - map.low);
  share = std::isfinite(share) ? std::clamp(share, 0.0, 1.0) : 0.0;
  return map.two_sided ? 2.0 * share - 1.0 : share;
}

int shade_of(const TaxelMap& map, double value) {
  return static_cast<int>(std::lround(kShades * share_of(map, value)));
}

}  // namespace

Markup taxel_map_svg(const TaxelMap& map) {
  const double cell = map.size / std::max({1, map.rows, map.columns}), edge = map.counted ? kMargin : 0.0;
  const double right = edge + cell * map.columns, bottom = edge + cell * map.rows;
  Markup out =
      markup("<svg role=\"img\" class=\"map\" viewBox=\"0 0 {0} {1}\" width=\"{0}\" height=\"{1}\"><title>{2}</title>",
             CssNumber(right + 1), CssNumber(bottom + 1), Text(map.title));
  std::array<std::string, 2 * kShades + 1> paths;
  std::string crosses;
  Markup numbers;
  for (int row = 0; row < map.rows; ++row)
    for (int column = 0; column < map.columns; ++column) {
      const auto taxel = static_cast<std::size_t>(row * map.columns + column);
      const double value = taxel < map.values.size() ? map.values[taxel] : std::nan("");
      const double x = edge + cell * column, y = edge + cell * row;
      const CssNumber left(x + 0.4), top(y + 0.4), side(cell - 0.8), arm(cell - 4.0);
      if (!std::isfinite(value)) {
        crosses +=
            fmt::format("M{} {}l{} {}m0 -{}l-{} {}", CssNumber(x + 2), CssNumber(y + 2), arm, arm, arm, arm, arm);
        continue;
      }
      paths[static_cast<std::size_t>(kShades + shade_of(map, value))] +=
          fmt::format("M{} {}h{}v{}h-{}z", left, top, side, side, side);
      if (map.numbered)
        numbers += markup("<text class=\"{}\" x=\"{}\" y=\"{}\">{}</text>",
                          Attribute(value > map.bold_above ? "cell b" : "cell"), CssNumber(x + 0.5 * cell, 1),
                          CssNumber(y + 0.5 * cell + 2.8, 1), Text(two_digits_text(value)));
    }
  for (std::size_t i = 0; i < paths.size(); ++i)
    if (!paths[i].empty())
      out += markup("<path fill=\"{}\" d=\"{}\"/>", Attribute(shade((static_cast<double>(i) - kShades) / kShades)),
                    Attribute(paths[i]));
  if (!crosses.empty()) out += markup("<path class=\"cross\" d=\"{}\"/>", Attribute(crosses));
  out += numbers;
  out += markup("<path class=\"axis\" d=\"M{0} {0}H{1}V{2}H{0}z\"/>", CssNumber(edge), CssNumber(right),
                CssNumber(bottom));
  if (map.counted) {
    for (int column = 0; column < map.columns; column += 5)
      out += markup("<text class=\"mid quiet\" x=\"{}\" y=\"{}\">{}</text>", CssNumber(edge + cell * (column + 0.5), 1),
                    CssNumber(edge - 5), column);
    for (int row = 0; row < map.rows; row += 5)
      out += markup("<text class=\"end quiet\" x=\"{}\" y=\"{}\">{}</text>", CssNumber(edge - 4),
                    CssNumber(edge + cell * (row + 0.5) + 3.5, 1), row);
  }
  out += markup("</svg>");
  return out;
}

Markup colour_scale_svg(const TaxelMap& map, const std::vector<std::pair<double, std::string>>& marks, double width) {
  const double left = 24.0, right = width - 24.0;
  Markup out =
      markup("<svg role=\"img\" class=\"map\" viewBox=\"0 0 {0} 26\" width=\"{0}\" height=\"26\"><title>{1}</title>",
             CssNumber(width), Text("Colour scale: " + map.title));
  const int first = map.two_sided ? -kShades : 0, steps = kShades - first;
  for (int i = 0; i <= steps; ++i)  // each reaches to the end and is covered by the next: no seams
    out +=
        markup("<path fill=\"{}\" d=\"M{} 2H{}v9H{}z\"/>", Attribute(shade(static_cast<double>(first + i) / kShades)),
               CssNumber(left + (right - left) * i / (steps + 1), 1), CssNumber(right),
               CssNumber(left + (right - left) * i / (steps + 1), 1));
  out += markup("<path class=\"axis\" d=\"M{0} 2H{1}v9H{0}z\"/>", CssNumber(left), CssNumber(right));
  for (const auto& [value, text] : marks) {
    const double share = share_of(map, value), place = map.two_sided ? 0.5 + 0.5 * share : share;
    const double x = left + place * (right - left);
    out += markup("<path class=\"axis\" d=\"M{0} 11v3\"/><text class=\"mid\" x=\"{0}\" y=\"23\">{1}</text>",
                  CssNumber(x, 1), Text(text));
  }
  out += markup("</svg>");
  return out;
}

}  // namespace tactbench::analysis
