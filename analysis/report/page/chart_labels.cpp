#include "analysis/report/page/chart_labels.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace tactbench::analysis {

namespace {

using html::Attribute;
using html::CssNumber;
using html::markup;
using html::Markup;
using html::Text;

constexpr double kTextHeight = 11.0;

struct TextBox {
  double left, right, top, bottom;
  [[nodiscard]] bool overlaps(const TextBox& other) const {
    return left < other.right && other.left < right && top < other.bottom && other.top < bottom;
  }
  [[nodiscard]] bool holds(double x, double y) const { return x > left && x < right && y > top && y < bottom; }
};

// The line's height at x; NaN beside it.
double height_at(const LinePoints& line, double x) {
  for (std::size_t i = 1; i < line.size(); ++i) {
    const auto& [x0, y0] = line[i - 1];
    const auto& [x1, y1] = line[i];
    if (x < std::min(x0, x1) || x > std::max(x0, x1) || x0 == x1) continue;
    return y0 + (y1 - y0) * (x - x0) / (x1 - x0);
  }
  return std::numeric_limits<double>::quiet_NaN();
}

double cost_of(const TextBox& box, const std::vector<TextBox>& taken, const std::vector<LinePoints>& lines,
               const PlotArea& area) {
  double cost = 0.0;
  if (box.left < area.left || box.right > area.right || box.top < area.top || box.bottom > area.bottom) cost += 1000.0;
  for (const TextBox& other : taken) cost += box.overlaps(other) ? 500.0 : 0.0;
  for (const LinePoints& line : lines)
    for (double x = box.left; x <= box.right; x += 3.0) cost += box.holds(x, height_at(line, x)) ? 1.0 : 0.0;
  return cost;
}

Markup label_svg(const LineLabel& label, const TextBox& box) {
  return markup("<text class=\"label\" x=\"{}\" y=\"{}\" fill=\"{}\">{}</text>", CssNumber(box.left + 1, 1),
                CssNumber(box.bottom - 2.5, 1), Attribute(label.colour), Text(label.text));
}

}  // namespace

std::size_t letters_in(const std::string& text) {
  return static_cast<std::size_t>(
      std::ranges::count_if(text, [](char c) { return (static_cast<unsigned char>(c) & 0xC0u) != 0x80u; }));
}

Markup labels_inside(const std::vector<LineLabel>& labels, const std::vector<LinePoints>& lines, const PlotArea& area) {
  Markup out;
  std::vector<TextBox> taken;
  for (const LineLabel& label : labels) {
    const double width = kLetterWidth * static_cast<double>(letters_in(label.text)) + 2.0;
    TextBox best{};
    double least = std::numeric_limits<double>::infinity();
    const auto consider = [&](double left, double top) {
      const TextBox box{left, left + width, top, top + kTextHeight};
      const double cost = cost_of(box, taken, lines, area);
      if (cost >= least) return;
      least = cost;
      best = box;
    };
    if (label.upright) {
      for (double y = area.top + 1.0; y < area.bottom - kTextHeight; y += kTextHeight)
        for (const double left : {label.line.front().first + 3.0, label.line.front().first - width - 3.0})
          consider(left, y);
    } else {
      for (int step = 0; step < 13; ++step) {  // from the right, where curves spread
        const double left = area.right - 3.0 - width - (area.right - area.left - width) * step / 12.5;
        for (const double gap : {2.0, 5.0, 9.0}) {
          double above = std::numeric_limits<double>::infinity(), below = -above;
          for (double x = left; x <= left + width; x += 3.0) {
            const double y = height_at(label.line, x);
            if (!std::isfinite(y)) continue;
            above = std::min(above, y);
            below = std::max(below, y);
          }
          if (!std::isfinite(above)) continue;
          consider(left, above - gap - kTextHeight);
          consider(left, below + gap);
        }
      }
    }
    if (!std::isfinite(least)) continue;
    taken.push_back(best);
    out += label_svg(label, best);
  }
  return out;
}

Markup labels_at_ends(const std::vector<LineLabel>& labels, const PlotArea& area) {
  struct End {
    const LineLabel* label;
    double from, y;
  };
  std::vector<End> ends;
  for (const LineLabel& label : labels) {
    double y = 0.5 * (area.top + area.bottom), farthest = -1.0;
    for (const auto& [px, py] : label.line)
      if (std::isfinite(py) && px >= farthest) farthest = px, y = py;
    ends.push_back({&label, y, y});
  }
  std::ranges::stable_sort(ends, {}, &End::from);
  for (std::size_t i = 1; i < ends.size(); ++i) ends[i].y = std::max(ends[i].y, ends[i - 1].y + kTextHeight + 1.0);
  const double beyond = ends.empty() ? 0.0 : ends.back().y - (area.bottom - 2.0);
  if (beyond > 0.0) {
    ends.back().y -= beyond;
    for (std::size_t i = ends.size() - 1; i-- > 0;) ends[i].y = std::min(ends[i].y, ends[i + 1].y - kTextHeight - 1.0);
  }
  Markup out;
  for (const End& end : ends) {
    out += markup("<path fill=\"none\" stroke=\"{}\" stroke-width=\".7\" d=\"M{} {}L{} {}\"/>",
                  Attribute(end.label->colour), CssNumber(area.right + 1, 1), CssNumber(end.from, 1),
                  CssNumber(area.right + 8, 1), CssNumber(end.y, 1));
    out += label_svg(*end.label, {area.right + 9, 0.0, 0.0, end.y + 6.0});
  }
  return out;
}

}  // namespace tactbench::analysis
