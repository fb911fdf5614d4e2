#include "analysis/models/elam_pieces.h"

#include <algorithm>
#include <cmath>

namespace tactbench::analysis {

ElamPiecedCurve::ElamPiecedCurve(const ElamModel& model, const ElamPieces& pieces, bool ascending, double x_turn,
                                 double y_turn)
    : curve_(model, ascending, x_turn, y_turn) {
  const double from_end = ascending ? curve_.turn_x() - model.x0() : model.xu() - curve_.turn_x();
  const bool outer = from_end <= kOuterShare * (model.xu() - model.x0());
  if (pieces.splits() == 1 || (model.options.exact_outer && outer)) return;
  const double xs = curve_.split_x(), ys = curve_.split_y(), x = curve_.turn_x(), y = curve_.turn_y();
  if (ascending) {
    plain_[0] = sized_[0] = x;
    divide(pieces.ascending_low, xs, [&](double share) { return curve_.input(y + (ys - y) * share); });
    divide(pieces.ascending_high, model.xu(),
           [&](double share) { return curve_.input(ys + (model.yu() - ys) * share); });
  } else {
    plain_[0] = sized_[0] = model.y0();
    divide(pieces.descending_low, ys,
           [&](double share) { return curve_.output(model.x0() + (xs - model.x0()) * share); });
    divide(pieces.descending_high, y, [&](double share) { return curve_.output(xs + (x - xs) * share); });
  }
}

// Adds the knots of the next side, which ends at `end`; place(share) is an inner one's place on the paper's curve.
template <class Place>
void ElamPiecedCurve::divide(const std::vector<double>& logs, double end, const Place& place) {
  const std::size_t first = last_, count = logs.size() + 1;
  const double start = plain_[first];
  for (std::size_t i = 1; i <= count; ++i) {
    const double before = plain_[last_], weight = i == 1 ? 1.0 : std::exp(logs[i - 2]);
    const double at = i == count ? end : place(static_cast<double>(i) / static_cast<double>(count));
    plain_[last_ + 1] = std::clamp(at, before, std::max(before, end));
    sized_[last_ + 1] = sized_[last_] + weight * (plain_[last_ + 1] - before);
    ++last_;
  }
  const double size = sized_[last_] - start;
  for (std::size_t i = first + 1; i < last_ && size > 0.0; ++i)
    sized_[i] = std::min(start + (sized_[i] - start) * ((end - start) / size), end);
  sized_[last_] = plain_[last_];
}

double ElamPiecedCurve::mapped(double value, const Knots& from, const Knots& to) const {
  std::size_t i = 1;
  while (i < last_ && value > from[i]) ++i;
  if (value >= from[i]) return to[i];
  if (value <= from[i - 1]) return to[i - 1];
  return to[i - 1] + (to[i] - to[i - 1]) * ((value - from[i - 1]) / (from[i] - from[i - 1]));
}

double ElamPiecedCurve::output(double x) const {
  if (last_ == 0) return curve_.output(x);
  return ascending() ? curve_.output(mapped(x, sized_, plain_)) : mapped(curve_.output(x), plain_, sized_);
}

double ElamPiecedCurve::input(double y) const {
  if (last_ == 0) return curve_.input(y);
  return ascending() ? mapped(curve_.input(y), plain_, sized_) : curve_.input(mapped(y, sized_, plain_));
}

}  // namespace tactbench::analysis
