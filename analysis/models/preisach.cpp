#include "analysis/models/preisach.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "analysis/models/invert.h"
#include "analysis/models/pattern_curve.h"

namespace tactbench::analysis {
namespace {

// The staircase: turning points in memory, minima rising and maxima falling, the first the low end of the range.
class PreisachState final : public ModelState {
 public:
  explicit PreisachState(const PreisachModel& model) : model_(&model) { reset(); }
  void reset() override {
    here_ = {model_->x_low(), model_->y_low()};
    corners_.assign(1, here_);
  }
  [[nodiscard]] double output_at(double x) const override { return way_to(x).y; }
  [[nodiscard]] double input_at(double y) const override {
    if (y == here_.y) return here_.x;
    const double way[] = {here_.x, y > here_.y ? model_->x_high() : model_->x_low()};
    return first_crossing([&](double x) { return output_at(x); }, way, y);
  }
  [[nodiscard]] std::unique_ptr<ModelState> clone() const override { return std::make_unique<PreisachState>(*this); }
  void go(double x) override {
    if (!std::isfinite(x)) throw std::invalid_argument("Preisach: the input is not a finite number");
    const Way way = way_to(x);
    if (way.turned && way.corners > corners_.size()) corners_.push_back(here_);
    corners_.resize(std::min(way.corners, corners_.size()));
    here_ = {std::clamp(x, model_->x_low(), model_->x_high()), way.y};
  }

 private:
  struct Point {
    double x = 0.0, y = 0.0;
  };
  struct Way {
    double y;
    std::size_t corners;  // that remain there
    bool turned;          // it starts a branch here
  };
  // Minima are even, maxima odd: on an odd number of corners the input rises.
  [[nodiscard]] Way way_to(double x) const {
    x = std::clamp(x, model_->x_low(), model_->x_high());
    const bool rises = corners_.size() % 2 == 1;
    if (x == here_.x) return {here_.y, corners_.size(), false};
    const bool up = x > here_.x, turned = up != rises;
    std::size_t count = corners_.size() + (turned ? 1 : 0);
    const auto corner = [&](std::size_t i) { return i < corners_.size() ? corners_[i] : here_; };
    // Wiping out: passing the extreme before the last removes both.
    while (count > (up ? 1U : 2U) && (up ? x >= corner(count - 2).x : x <= corner(count - 2).x)) count -= 2;
    if (!up && count == 2 && x <= corner(0).x) return {model_->y_low(), 1, turned};
    const Point last = corner(count - 1);
    const double y = up ? last.y + model_->everett(x, last.x) : last.y - model_->everett(last.x, x);
    return {y, count, turned};
  }
  const PreisachModel* model_;
  std::vector<Point> corners_;
  Point here_;
};

}  // namespace

PreisachModel::PreisachModel(double x_low, double x_high, double y_low, std::vector<double> weights)
    : x_low_(x_low), x_high_(x_high), y_low_(y_low), weights_(std::move(weights)) {
  if (!std::isfinite(x_low) || !std::isfinite(x_high) || !(x_low < x_high) || !std::isfinite(y_low))
    throw std::invalid_argument("Preisach model: x_low, x_high and y_low must be finite and x_low below x_high");
  while (cell(n_, 0) < weights_.size()) ++n_;
  if (weights_.empty() || cell(n_, 0) != weights_.size())
    throw std::invalid_argument("Preisach model: \"weights\" does not hold n (n + 1) / 2 numbers");
  for (const double weight : weights_)
    if (!std::isfinite(weight) || weight < 0.0)
      throw std::invalid_argument("Preisach model: a weight is negative or not finite");
  above_.assign((n_ + 1) * (n_ + 1), 0.0);
  for (std::size_t i = 0; i < n_; ++i) {
    double row = 0.0;
    for (std::size_t j = n_; j-- > 0;) {
      if (j <= i) row += weights_[cell(i, j)];
      above_[(i + 1) * (n_ + 1) + j] = above(i, j) + row;
    }
  }
}

std::vector<ModelParameter> PreisachModel::parameters() const {
  std::vector<ModelParameter> list;
  for (std::size_t i = 0; i < n_; ++i)
    for (std::size_t j = 0; j <= i; ++j)
      if (const double weight = weights_[cell(i, j)]; weight > 0.0)
        list.push_back({std::string("w(") + std::to_string(i) + "," + std::to_string(j) + ")", weight, "y", 0.0,
                        std::numeric_limits<double>::infinity()});
  return list;
}

// Compared with here and with the extreme before the last (2), cell and share (3), three table accesses to sums that
// are differences of the cumulated ones taken once a cell (3), two multiply-adds (4), the corner (3) and the sum (1).
int PreisachModel::operations_per_sample() const { return 16; }

std::unique_ptr<ModelState> PreisachModel::state() const { return std::make_unique<PreisachState>(*this); }

double PreisachModel::everett(double high, double low) const {
  if (high <= low) return 0.0;
  const double per_interval = static_cast<double>(n_) / (x_high_ - x_low_);
  const auto place = [&](double x) {
    const double at = (x - x_low_) * per_interval;
    const std::size_t interval = interval_of(at, n_);
    return std::pair{interval, at - static_cast<double>(interval)};
  };
  const auto [i, on] = place(high);
  const auto [j, off] = place(low);
  const double corner = weights_[cell(i, j)] * std::max(0.0, on - off);
  if (i == j) return corner;
  const double rows = above(i, j + 1);            // wholly above `low`, wholly below `high`
  const double row = above(i + 1, j + 1) - rows;  // switching on now
  const double column = above(i, j) - rows;       // of the interval that holds `low`
  return rows + row * on + column * (1.0 - off) + corner;
}

ModelMembers PreisachModel::members() const {
  return {{"x_low", x_low_}, {"x_high", x_high_}, {"y_low", y_low_}, {"weights", weights_}};
}

std::unique_ptr<HysteresisModel> PreisachModel::from(const ModelSource& source) {
  return std::make_unique<PreisachModel>(source.number("x_low"), source.number("x_high"), source.number("y_low"),
                                         source.numbers("weights"));
}

}  // namespace tactbench::analysis
