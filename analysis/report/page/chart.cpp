#include "analysis/report/page/chart.h"

#include <qrencode.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <stdexcept>

#include "analysis/report/page/html.h"
#include "analysis/report/page/page.h"

namespace tactbench::analysis {
namespace {

using html::Attribute;
using html::CssNumber;
using html::markup;
using html::Markup;
using html::Text;

constexpr double kTop = 6.0;

// About `wanted` round numbers (1, 2, 5 x 10^n) within [low, high].
std::vector<double> nice_ticks(double low, double high, int wanted) {
  if (!(high > low) || wanted < 1) return {low};
  const double rough = (high - low) / wanted;
  const double decade = std::pow(10.0, std::floor(std::log10(rough)));
  double step = 10.0 * decade;
  for (const double factor : {5.0, 2.0, 1.0})
    if (factor * decade >= rough * (1.0 - 1e-9)) step = factor * decade;
  std::vector<double> ticks;
  const auto first = static_cast<long long>(std::ceil(low / step - 1e-9));
  const auto last = static_cast<long long>(std::floor(high / step + 1e-9));
  for (long long i = first; i <= last; ++i) ticks.push_back(static_cast<double>(i) * step);
  return ticks;
}

struct Scale {
  double low = std::numeric_limits<double>::infinity(), high = -std::numeric_limits<double>::infinity();
  double from = 0.0, to = 1.0;  // pixels
  bool logarithmic = false;

  void include(double value) {
    if (!std::isfinite(value) || (logarithmic && value <= 0.0)) return;
    low = std::min(low, value);
    high = std::max(high, value);
  }
  [[nodiscard]] double place(double value) const { return logarithmic ? std::log10(std::max(value, 1e-12)) : value; }
  [[nodiscard]] double at(double value) const {
    const double share = (place(value) - place(low)) / (place(high) - place(low));
    return from + std::clamp(share, 0.0, 1.0) * (to - from);
  }
  [[nodiscard]] bool beyond(double value) const { return value < low || value > high; }
  [[nodiscard]] std::vector<double> ticks(int wanted) const {
    if (!logarithmic) return nice_ticks(low, high, wanted);
    std::vector<double> out;
    for (double decade = std::pow(10.0, std::floor(std::log10(low))); decade <= high; decade *= 10.0)
      for (const double factor : {1.0, 3.0})
        if (factor * decade >= low * 0.999 && factor * decade <= high * 1.001) out.push_back(factor * decade);
    return out;
  }
};

int decimals_of(const std::vector<double>& ticks) {
  double step = std::numeric_limits<double>::infinity();
  for (std::size_t i = 1; i < ticks.size(); ++i) step = std::min(step, ticks[i] - ticks[i - 1]);
  if (!ticks.empty() && ticks.front() > 0.0 && ticks.front() < step) step = ticks.front();  // of a logarithmic axis
  return std::isfinite(step) && step > 0.0 ? std::clamp(static_cast<int>(std::ceil(-std::log10(step) - 1e-9)), 0, 9)
                                           : 1;
}

Scale scale_of(const Axis& axis, const std::vector<double>& values, bool from_zero) {
  Scale scale;
  scale.logarithmic = axis.logarithmic;
  for (const double value : values) scale.include(value);
  if (from_zero) scale.include(0.0);
  if (scale.low > scale.high) scale.low = 0.0, scale.high = 1.0;
  if (scale.high - scale.low < 1e-12 * std::max(1.0, std::abs(scale.high))) scale.low -= 0.5, scale.high += 0.5;
  if (axis.logarithmic) {
    scale.low *= 0.8;
    scale.high *= 1.25;
  }
  scale.low = axis.low.value_or(scale.low);
  scale.high = axis.high.value_or(scale.high);
  return scale;
}

// number of characters, not bytes
std::size_t letters_in(const std::string& text) {
  return static_cast<std::size_t>(
      std::ranges::count_if(text, [](char c) { return (static_cast<unsigned char>(c) & 0xC0u) != 0x80u; }));
}

constexpr double kTextHeight = 11.0;

struct TextBox {
  double left, right, top, bottom;
  [[nodiscard]] bool overlaps(const TextBox& other) const {
    return left < other.right && other.left < right && top < other.bottom && other.top < bottom;
  }
  [[nodiscard]] bool holds(double x, double y) const { return x > left && x < right && y > top && y < bottom; }
};

// The line's height at x; NaN outside the line.
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

// Places the labels one after the other, each where it overlaps the fewest earlier labels and the fewest points of
// `lines`.
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

class ChartDrawing {
 public:
  explicit ChartDrawing(const Chart& chart) : chart_(chart) {
    std::vector<double> xs, ys;
    for (const Curve& curve : chart.curves) {
      xs.insert(xs.end(), curve.x.begin(), curve.x.end());
      ys.insert(ys.end(), curve.y.begin(), curve.y.end());
    }
    for (const Band& band : chart.bands) {
      xs.insert(xs.end(), band.x.begin(), band.x.end());
      for (const auto* edge : {&band.low, &band.high}) ys.insert(ys.end(), edge->begin(), edge->end());
    }
    for (const Bars& bars : chart.bars) {
      xs.insert(xs.end(), bars.edges.begin(), bars.edges.end());
      ys.insert(ys.end(), bars.counts.begin(), bars.counts.end());
    }
    for (const Rule& rule : chart.rules) (rule.upright ? xs : ys).push_back(rule.at);
    x_ = scale_of(chart.x, xs, false);
    y_ = scale_of(chart.y, ys, !chart.bars.empty());
    if (!chart.y.logarithmic && !chart.y.high) y_.high += 0.06 * (y_.high - y_.low);
    lay_out();
  }

  Markup svg() {
    Markup out = markup(
        "<svg role=\"img\" class=\"chart\" viewBox=\"0 0 {0} {1}\" width=\"{0}\" height=\"{1}\"><title>{2}</title>",
        CssNumber(chart_.width), CssNumber(chart_.height), Text(chart_.title));
    if (!chart_.heading.empty())
      out += markup("<text class=\"head\" x=\"{}\" y=\"10\" fill=\"{}\">{}</text>", CssNumber(x_.from, 1),
                    Attribute(chart_.heading_stroke.colour), Text(chart_.heading));
    for (const ShadedSpan& stretch : chart_.stretches) out += stretch_of(stretch);
    out += axes();
    for (const Bars& bars : chart_.bars) out += bars_svg(bars);
    for (const Band& band : chart_.bands) out += band_svg(band);
    for (const Rule& rule : chart_.rules) out += rule_svg(rule);
    for (const Curve& curve : chart_.curves) out += curve_svg(curve);
    out += labels();
    out += markup("</svg>");
    return out;
  }

 private:
  void lay_out() {
    const auto widest = [](const std::vector<double>& ticks, double factor) {
      std::size_t letters = 1;
      std::vector<double> shown;
      for (const double tick : ticks) shown.push_back(tick * factor);
      for (const double tick : shown) letters = std::max(letters, letters_in(fixed_text(tick, decimals_of(shown))));
      return kLetterWidth * static_cast<double>(letters);
    };
    x_.from = (chart_.y.label.empty() ? 4.0 : 17.0) + widest(y_.ticks(wanted_up()), 1.0) + 6.0;
    x_.to = chart_.width - (chart_.x.second_unit.empty() ? 8.0 : 18.0);  // half of the last tick's label
    if (!chart_.y.second_unit.empty())
      x_.to = chart_.width - 22.0 - widest(second_axis_ticks(y_, chart_.y, wanted_up()), 1.0);
    if (chart_.labels_at_ends) {
      std::size_t letters = 0;
      for (const Curve& curve : chart_.curves) letters = std::max(letters, letters_in(curve.label));
      x_.to = chart_.width - 14.0 - kLetterWidth * static_cast<double>(letters);
    }
    const bool stretched = !chart_.stretches.empty();
    y_.to = kTop + (chart_.heading.empty() ? 0.0 : 10.0) + (stretched ? 12.0 : 0.0);
    y_.from =
        chart_.height - 16.0 - (chart_.x.second_unit.empty() ? 0.0 : 12.0) - (chart_.x.label.empty() ? 0.0 : 14.0);
  }
  [[nodiscard]] int wanted_up() const { return chart_.height < 150 ? 4 : 7; }
  [[nodiscard]] int wanted_along() const { return x_.to - x_.from < 200 ? 4 : 6; }
  static std::vector<double> second_axis_ticks(const Scale& scale, const Axis& axis, int wanted) {
    return nice_ticks(scale.low * axis.second_unit_factor, scale.high * axis.second_unit_factor, wanted);
  }

  [[nodiscard]] Markup axes() const {
    Markup out;
    const auto xs = x_.ticks(wanted_along()), ys = y_.ticks(wanted_up());
    const CssNumber left(x_.from, 1), right(x_.to, 1), top(y_.to, 1), bottom(y_.from, 1);
    for (const double tick : ys) {
      const double y = y_.at(tick);
      out += markup("<path class=\"{}\" d=\"M{} {}H{}\"/><text class=\"end\" x=\"{}\" y=\"{}\">{}</text>",
                    Attribute(tick == 0.0 ? "zero" : "grid"), left, CssNumber(y, 1), right, CssNumber(x_.from - 4, 1),
                    CssNumber(y + 3.5, 1), Text(fixed_text(tick, decimals_of(ys))));
    }
    for (const double tick : xs)
      out += markup("<path class=\"axis\" d=\"M{0} {1}v3\"/><text class=\"mid\" x=\"{0}\" y=\"{2}\">{3}</text>",
                    CssNumber(x_.at(tick), 1), bottom, CssNumber(y_.from + 13, 1),
                    Text(fixed_text(tick, decimals_of(xs))));
    double below = y_.from + 13;
    if (!chart_.x.second_unit.empty()) {
      below += 12.0;
      const auto ticks = second_axis_ticks(x_, chart_.x, wanted_along());
      for (const double tick : ticks) {
        const bool last = tick == ticks.back();
        out += markup("<text class=\"mid quiet\" x=\"{}\" y=\"{}\">{}{}</text>",
                      CssNumber(x_.at(tick / chart_.x.second_unit_factor), 1), CssNumber(below, 1),
                      Text(fixed_text(tick, decimals_of(ticks))), Text(last ? "\u00A0" + chart_.x.second_unit : ""));
      }
    }
    if (!chart_.x.label.empty())
      out += markup("<text class=\"mid\" x=\"{}\" y=\"{}\">{}</text>", CssNumber(0.5 * (x_.from + x_.to), 1),
                    CssNumber(below + 14, 1), Text(chart_.x.label));
    const CssNumber middle(0.5 * (y_.from + y_.to), 1);
    if (!chart_.y.label.empty())
      out += markup("<text class=\"mid\" transform=\"translate(10 {}) rotate(-90)\">{}</text>", middle,
                    Text(chart_.y.label));
    out += markup("<path class=\"axis\" d=\"M{} {}V{}H{}\"/>", left, top, bottom, right);
    if (chart_.y.second_unit.empty()) return out;
    const auto ticks = second_axis_ticks(y_, chart_.y, wanted_up());
    for (const double tick : ticks)
      out += markup("<path class=\"axis\" d=\"M{} {}h3\"/><text x=\"{}\" y=\"{}\">{}</text>", right,
                    CssNumber(y_.at(tick / chart_.y.second_unit_factor), 1), CssNumber(x_.to + 5, 1),
                    CssNumber(y_.at(tick / chart_.y.second_unit_factor) + 3.5, 1),
                    Text(fixed_text(tick, decimals_of(ticks))));
    out += markup(
        "<path class=\"axis\" d=\"M{} {}V{}\"/><text class=\"mid\" transform=\"translate({} {}) "
        "rotate(-90)\">{}</text>",
        right, top, bottom, CssNumber(chart_.width - 3, 1), middle, Text(chart_.y.second_unit));
    return out;
  }

  [[nodiscard]] Markup stretch_of(const ShadedSpan& stretch) const {
    const double from = x_.at(stretch.from), to = std::max(x_.at(stretch.to), from + 1.5);
    const double half = 0.5 * kLetterWidth * static_cast<double>(letters_in(stretch.label));
    const double middle = std::clamp(0.5 * (from + to), x_.from + half, std::max(x_.from + half, x_.to - half));
    return markup("<path fill=\"#dff0e3\" d=\"M{} {}H{}V{}H{}z\"/><text class=\"mid good\" x=\"{}\" y=\"{}\">{}</text>",
                  CssNumber(from, 1), CssNumber(y_.to, 1), CssNumber(to, 1), CssNumber(y_.from, 1), CssNumber(from, 1),
                  CssNumber(middle, 1), CssNumber(y_.to - 3, 1), Text(stretch.label));
  }

  [[nodiscard]] Markup bars_svg(const Bars& bars) const {
    html::PathData d;
    for (std::size_t i = 0; i < bars.counts.size(); ++i) {
      if (bars.counts[i] <= 0.0) continue;
      d.value += fmt::format("M{} {}V{}H{}V{}z", CssNumber(x_.at(bars.edges[i]) + 0.5, 1), CssNumber(y_.from, 1),
                             CssNumber(y_.at(bars.counts[i]), 1), CssNumber(x_.at(bars.edges[i + 1]) - 0.5, 1),
                             CssNumber(y_.from, 1));
    }
    return markup("<path fill=\"#6b7d8c\" d=\"{}\"/>", d);
  }

  [[nodiscard]] Markup band_svg(const Band& band) {
    std::string there, back;
    Markup marks;
    for (std::size_t i = 0; i < band.x.size(); ++i) {
      if (!std::isfinite(band.low[i]) || !std::isfinite(band.high[i])) continue;
      const CssNumber x(x_.at(band.x[i]), 1);
      there += fmt::format("{}{} {}", there.empty() ? "M" : "L", x, CssNumber(y_.at(band.high[i]), 1));
      back = fmt::format("L{} {}", x, CssNumber(y_.at(band.low[i]), 1)) + back;
      if (y_.beyond(band.high[i])) marks += markup("<path d=\"M{} {}l-3 5h6z\"/>", x, CssNumber(y_.to, 1));
      if (y_.beyond(band.low[i])) marks += markup("<path d=\"M{} {}l-3 -5h6z\"/>", x, CssNumber(y_.from, 1));
    }
    if (there.empty()) return {};
    if (!band.label.empty()) inside_.push_back({band.label, "#1a2026", line_of(band.x, band.high)});
    Markup path;
    path.value = there + back + "z";
    return markup("<path fill=\"{}\" d=\"{}\"/><g class=\"beyond\">{}</g>", Attribute(band.fill), path, marks);
  }

  [[nodiscard]] Markup rule_svg(const Rule& rule) {
    if ((rule.upright ? x_ : y_).beyond(rule.at)) return {};
    const double at = (rule.upright ? x_ : y_).at(rule.at);
    Markup path = rule.upright ? markup("M{} {}V{}", CssNumber(at, 1), CssNumber(y_.from, 1), CssNumber(y_.to, 1))
                               : markup("M{} {}H{}", CssNumber(x_.from, 1), CssNumber(at, 1), CssNumber(x_.to, 1));
    if (!rule.label.empty()) {
      if (rule.upright)
        inside_.push_back({rule.label, rule.stroke.colour, {{at, y_.to + 14}, {at, y_.from}}, true});
      else
        inside_.push_back({rule.label, rule.stroke.colour, {{x_.from, at}, {x_.to, at}}});
    }
    return stroked(path, rule.stroke, false);
  }

  [[nodiscard]] Markup curve_svg(const Curve& curve) {
    const LinePoints line = line_of(curve.x, curve.y);
    Markup path;
    bool pen_down = false;
    for (const auto& [x, y] : line) {
      if (!std::isfinite(y)) {
        pen_down = false;
        continue;
      }
      path += markup("{}{} {}", Text(pen_down && !curve.points ? "L" : "M"), CssNumber(x, 1), CssNumber(y, 1));
      if (curve.points) path += markup("h0");  // a round cap on a line of no length is a dot
      pen_down = true;
    }
    if (path.value.empty()) return {};
    if (!curve.label.empty())
      (chart_.labels_at_ends ? ends_ : inside_).push_back({curve.label, curve.stroke.colour, line});
    return stroked(path, curve.stroke, curve.points);
  }

  static Markup stroked(const Markup& path, const Stroke& stroke, bool points) {
    const Markup dashes =
        *stroke.dashes == '\0' ? Markup() : markup(" stroke-dasharray=\"{}\"", Attribute(stroke.dashes));
    return markup("<path fill=\"none\" stroke=\"{}\" stroke-width=\"{}\"{}{} d=\"{}\"/>", Attribute(stroke.colour),
                  CssNumber(points ? 3.0 : stroke.width), points ? markup(" stroke-linecap=\"round\"") : Markup(),
                  dashes, path);
  }

  [[nodiscard]] LinePoints line_of(const std::vector<double>& x, const std::vector<double>& y) const {
    LinePoints line;
    for (std::size_t i = 0; i < std::min(x.size(), y.size()); ++i)
      line.emplace_back(x_.at(x[i]), std::isfinite(y[i]) ? y_.at(y[i]) : std::numeric_limits<double>::quiet_NaN());
    return line;
  }

  [[nodiscard]] Markup labels() const {
    const PlotArea area{x_.from, x_.to, y_.to, y_.from};
    std::vector<LinePoints> lines;
    for (const Curve& curve : chart_.curves) lines.push_back(line_of(curve.x, curve.y));
    for (const Band& band : chart_.bands)
      for (const auto* edge : {&band.low, &band.high}) lines.push_back(line_of(band.x, *edge));
    for (const Rule& rule : chart_.rules)
      if (!rule.upright) lines.push_back({{x_.from, y_.at(rule.at)}, {x_.to, y_.at(rule.at)}});
    Markup out = labels_inside(inside_, lines, area);
    out += labels_at_ends(ends_, area);
    return out;
  }

  const Chart& chart_;
  Scale x_, y_;
  std::vector<LineLabel> inside_, ends_;
};

}  // namespace

Bars bars_of(const std::vector<double>& values, double low, double high, int bins) {
  Bars bars{{}, std::vector<double>(static_cast<std::size_t>(bins), 0.0)};
  for (int i = 0; i <= bins; ++i) bars.edges.push_back(low + (high - low) * i / bins);
  for (const double value : values) {
    if (!std::isfinite(value)) continue;
    const double bin = std::clamp((value - low) / (high - low) * bins, 0.0, bins - 1.0);
    bars.counts[static_cast<std::size_t>(bin)] += 1.0;
  }
  return bars;
}

Markup chart_svg(const Chart& chart) { return ChartDrawing(chart).svg(); }

std::string svg_file(const Chart& chart) {
  std::string svg = chart_svg(chart).value;
  const std::string_view start = "<svg ", title_end = "</title>";
  svg.insert(svg.find(title_end) + title_end.size(),
             "<style>" + chart_rules().value + "</style><rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>");
  return svg.insert(start.size(), "xmlns=\"http://www.w3.org/2000/svg\" ") + "\n";
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

html::Markup qr_code_svg(const std::string& text, const std::string& title, double size) {
  const std::unique_ptr<QRcode, decltype(&QRcode_free)> code(
      QRcode_encodeData(static_cast<int>(text.size()), reinterpret_cast<const unsigned char*>(text.data()), 0,
                        QR_ECLEVEL_M),
      QRcode_free);
  if (!code) throw std::invalid_argument("a QR code holds 1 to 2331 bytes");
  constexpr int kQuiet = 4;
  html::PathData dark;  // a rectangle for each row's run of dark modules
  for (int row = 0; row < code->width; ++row)
    for (int begin = 0, end = 0; begin < code->width; begin = end + 1) {
      const auto is_dark = [&](int column) { return (code->data[row * code->width + column] & 1) != 0; };
      for (end = begin; end < code->width && is_dark(end);) ++end;
      if (end > begin)
        dark.literal("M")
            .number(begin + kQuiet)
            .literal(" ")
            .number(row + kQuiet)
            .literal("h")
            .number(end - begin)
            .literal("v1h")
            .number(begin - end)
            .literal("z");
    }
  return html::markup(
      "<svg role=\"img\" viewBox=\"0 0 {0} {0}\" width=\"{1}\" height=\"{1}\"><title>{2}"
      "</title><path d=\"{3}\" fill=\"#000\"/></svg>",
      code->width + 2 * kQuiet, html::CssNumber(size), html::Text(title), dark);
}

}  // namespace tactbench::analysis
