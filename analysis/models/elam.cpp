#include "analysis/models/elam.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace tactbench::analysis {
namespace {

bool saturated(const ElamModel& model, double rise) { return rise <= kSaturatedShare * (model.yu() - model.y0()); }

}  // namespace

ElamCurve::ElamCurve(const ElamModel& model, bool ascending, double x_turn, double y_turn)
    : ElamCurve(model, ascending, x_turn, y_turn, x_turn) {}

ElamCurve::ElamCurve(const ElamModel& model, bool ascending, double x_turn, double y_turn, double x_split_turn)
    : model_(&model), ascending_(ascending) {
  if (!std::isfinite(x_turn) || !std::isfinite(y_turn) || !std::isfinite(x_split_turn))
    throw std::invalid_argument("ELAM curve: the turning point is not finite");
  const double x0 = model.x0(), xu = model.xu(), y0 = model.y0(), yu = model.yu();
  const ElamParameters& p = model.parameters;
  x_turn_ = std::clamp(x_turn, x0, xu);
  y_turn_ = std::max(y_turn, y0);
  if (ascending) y_turn_ = std::min(y_turn_, yu);
  const bool exact = model.options.exact_outer;
  const double near = kOuterShare * (xu - x0);
  if (ascending) {
    const double length = xu - x_turn_;
    xs_ = x_turn_ + std::clamp(p.alpha_a1 * length + p.alpha_a0, 0.0, 1.0) * length;  // (21)
    ys_ = y_turn_ + p.beta_a * (yu - y_turn_);                                        // (22)
    xsp_ = model.ascending.inverse(ys_);
    xmp_ = model.ascending.inverse(y_turn_);
    ysp_ = ys_;
    // An external branch follows P_a itself exactly when its split lies on P_a.
    if (exact && x_turn_ - x0 <= near) xs_ = std::max(xsp_, x_turn_);
  } else {
    const double x_split = std::clamp(x_split_turn, x_turn_, xu);
    xs_ = std::min(x0 + p.alpha_d * (x_split - x0), x_turn_);  // (14)
    xsp_ = xs_;
    xmp_ = x_turn_;
    ysp_ = model.descending(xs_);
    // (15), or P_d's own share there.
    const double share = exact && xu - x_split <= near ? (ysp_ - y0) / (yu - y0) : p.beta_d;
    ys_ = y0 + share * (y_turn_ - y0);
  }
}

double ElamCurve::output(double x) const { return ascending_ ? ascending_output(x) : descending_output(x); }

CurvePiece ElamCurve::piece(double y) const { return ascending_ ? ascending_piece(y) : descending_piece(y); }

double ElamCurve::input(double y) const {
  const double low = ascending_ ? x_turn_ : model_->x0(), high = ascending_ ? model_->xu() : x_turn_;
  return std::clamp(piece(y).along(y), low, high);
}

double ElamCurve::descending_output(double x) const {
  const double x0 = model_->x0(), xu = model_->xu(), y0 = model_->y0(), yu = model_->yu();
  const PatternCurve& pattern = model_->descending;
  if (x >= x_turn_) return y_turn_;
  if (x <= x0) return y0;
  if (x >= xs_) {
    const double share = (x - xs_) / (x_turn_ - xs_);
    if (saturated(*model_, yu - ysp_)) return ys_ + (y_turn_ - ys_) * share;
    const double xp = xs_ + (xu - xs_) * share;                           // (16)
    return ys_ + (y_turn_ - ys_) * ((pattern(xp) - ysp_) / (yu - ysp_));  // (17)
  }
  if (saturated(*model_, ysp_ - y0)) return y0 + (ys_ - y0) * ((x - x0) / (xs_ - x0));
  return y0 + (ys_ - y0) * ((pattern(x) - y0) / (ysp_ - y0));  // (18), (19)
}

CurvePiece ElamCurve::descending_piece(double y) const {
  const double x0 = model_->x0(), xu = model_->xu(), y0 = model_->y0(), yu = model_->yu();
  const PatternCurve& pattern = model_->descending;
  if (y >= y_turn_) return {y_turn_, kFarOutput, y_turn_, x_turn_, 0.0};
  if (y <= y0) return {-kFarOutput, y0, y0, x0, 0.0};
  if (y >= ys_) {
    const double rise = yu - ysp_;
    if (saturated(*model_, rise)) return {ys_, y_turn_, ys_, xs_, (x_turn_ - xs_) / (y_turn_ - ys_)};
    const double per = rise / (y_turn_ - ys_), scale = (x_turn_ - xs_) / (xu - xs_);  // (31), (32)
    const CurvePiece p = pattern.piece(ysp_ + per * (y - ys_));
    const double from = std::max(p.low, ysp_);
    return {std::min(ys_ + (from - ysp_) / per, y), std::clamp(ys_ + (p.high - ysp_) / per, y, y_turn_),
            ys_ + (from - ysp_) / per, xs_ + scale * (p.along(from) - xs_), scale * p.slope * per};
  }
  if (saturated(*model_, ysp_ - y0)) return {y0, ys_, y0, x0, (xs_ - x0) / (ys_ - y0)};
  const double per = (ysp_ - y0) / (ys_ - y0);  // (33) as [A5], (34)
  const CurvePiece p = pattern.piece(y0 + per * (y - y0));
  return {std::min(y0 + (p.low - y0) / per, y), std::clamp(y0 + (p.high - y0) / per, y, ys_), y0 + (p.low - y0) / per,
          p.x_a, p.slope * per};
}

double ElamCurve::ascending_output(double x) const {
  const double xu = model_->xu(), yu = model_->yu();
  const PatternCurve& pattern = model_->ascending;
  if (x <= x_turn_) return y_turn_;
  if (x >= xu) return yu;
  if (x <= xs_) return pattern(xmp_ + (xsp_ - xmp_) * ((x - x_turn_) / (xs_ - x_turn_)));  // (25), (26)
  return pattern(xsp_ + (xu - xsp_) * ((x - xs_) / (xu - xs_)));                           // (23), (24)
}

CurvePiece ElamCurve::ascending_piece(double y) const {
  const double xu = model_->xu(), yu = model_->yu();
  if (y <= y_turn_) return {-kFarOutput, y_turn_, y_turn_, x_turn_, 0.0};
  if (y >= yu) return {yu, kFarOutput, yu, xu, 0.0};
  const bool lower = y <= ys_;
  if (lower && xsp_ <= xmp_) return {y_turn_, ys_, ys_, xs_, 0.0};
  if (!lower && xu <= xsp_) return {ys_, yu, ys_, xu, 0.0};
  const CurvePiece p = model_->ascending.piece(y);  // (35), (37)
  const double from = std::max(p.low, lower ? y_turn_ : ys_), to = std::min(p.high, lower ? ys_ : yu);
  const double scale = lower ? (xs_ - x_turn_) / (xsp_ - xmp_) : (xu - xs_) / (xu - xsp_);
  const double x = lower ? x_turn_ + scale * (p.along(from) - xmp_)  // (36)
                         : xs_ + scale * (p.along(from) - xsp_);     // (38)
  return {std::min(from, y), std::max(to, y), from, x, scale * p.slope};
}

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

namespace {

std::array<double, 5> values_of(const ElamParameters& p) {
  return {p.alpha_d, p.beta_d, p.alpha_a1, p.alpha_a0, p.beta_a};
}

// A curve that rises less than this share of the span between two points cannot be scaled to others: linear [A12].
constexpr double kSmallestRise = 1e-6;
constexpr std::array<const char*, 4> kSideMembers = {"pieces/descending_low", "pieces/descending_high",
                                                     "pieces/ascending_low", "pieces/ascending_high"};

bool beyond(bool ascending, double value, double end) { return ascending ? value > end : value < end; }

struct ElamPoint {
  double x = 0.0, y = 0.0;
};

ElamPoint low_end(const ElamModel& model) { return {model.x0(), model.y0()}; }
ElamPoint high_end(const ElamModel& model) { return {model.xu(), model.yu()}; }

// A target curve from a turning point to the point where it closes a loop or ends. Its ordinates are scaled so that it
// meets both points; where it already does it is the plain curve.
class ElamSegment {
 public:
  ElamSegment(const ElamModel& model, const ElamPieces& pieces, bool ascending, ElamPoint from, ElamPoint to);
  [[nodiscard]] bool ascending() const { return curve_.ascending(); }
  [[nodiscard]] ElamPoint to() const { return to_; }
  [[nodiscard]] double output(double x) const;
  [[nodiscard]] double input(double y) const;
  void go_on_from(ElamPoint here);  // the rest of it now runs from here to the same end

  ElamPoint origin;  // the turning point at which the loop that a branch leaves here closes

 private:
  enum class Kind { kPlain, kScaled, kStraight };
  ElamPiecedCurve curve_;
  ElamPoint from_, to_;
  Kind kind_ = Kind::kPlain;
  double base_ = 0.0, scale_ = 1.0;  // kScaled: the curve's ordinate at from_; ordinates per the curve's
  double smallest_rise_;             // of the curve that can be scaled
};

class ElamState final : public ModelState {
 public:
  ElamState(const ElamModel& model, const ElamPieces& pieces, bool memory);  // keeps pointers to both
  void reset() override;
  [[nodiscard]] double output_at(double x) const override;
  [[nodiscard]] double input_at(double y) const override;
  [[nodiscard]] std::unique_ptr<ModelState> clone() const override { return std::make_unique<ElamState>(*this); }
  void go(double x) override;
  void measured(double y) override;

 private:
  [[nodiscard]] ElamSegment outer(bool ascending) const;
  [[nodiscard]] ElamSegment turned(bool ascending) const;
  [[nodiscard]] bool goes_on(bool ascending) const { return ascending == segments_.back().ascending() && !anchored_; }
  [[nodiscard]] double follow(bool up, double value, double ElamPoint::*along,
                              double (ElamSegment::*read)(double) const) const;
  const ElamModel* model_;
  const ElamPieces* pieces_;
  bool memory_;
  std::vector<ElamSegment> segments_;  // directions alternate; the last is the current one
  ElamPoint here_;
  bool anchored_ = false;  // a measured point: any continuation is a new branch
};

ElamSegment::ElamSegment(const ElamModel& model, const ElamPieces& pieces, bool ascending, ElamPoint from, ElamPoint to)
    : origin(from),
      curve_(model, pieces, ascending, from.x, from.y),
      to_(to),
      smallest_rise_(kSmallestRise * (model.yu() - model.y0())) {
  go_on_from({curve_.turn_x(), curve_.turn_y()});
}

void ElamSegment::go_on_from(ElamPoint here) {
  from_ = here;
  base_ = curve_.output(from_.x);
  const double end = curve_.output(to_.x);
  if (base_ == from_.y && end == to_.y) {
    kind_ = Kind::kPlain;
    return;
  }
  // A start measured beyond the end: flat, never in the wrong direction.
  if (beyond(ascending(), from_.y, to_.y)) from_.y = to_.y;
  const bool scaled = std::abs(end - base_) > smallest_rise_;
  kind_ = scaled ? Kind::kScaled : Kind::kStraight;
  scale_ = scaled ? (to_.y - from_.y) / (end - base_) : 0.0;
}

double ElamSegment::output(double x) const {
  if (kind_ == Kind::kPlain) return curve_.output(x);
  if (x == to_.x || from_.x == to_.x || beyond(ascending(), x, to_.x)) return to_.y;
  if (kind_ == Kind::kStraight) return from_.y + (to_.y - from_.y) * ((x - from_.x) / (to_.x - from_.x));
  const auto [low, high] = std::minmax(from_.y, to_.y);
  return std::clamp(from_.y + (curve_.output(x) - base_) * scale_, low, high);
}

double ElamSegment::input(double y) const {
  if (kind_ == Kind::kPlain) return curve_.input(y);
  if (y == to_.y || beyond(ascending(), y, to_.y)) return to_.x;
  if (from_.y == to_.y) return from_.x;
  const auto [low, high] = std::minmax(from_.x, to_.x);
  if (kind_ == Kind::kStraight)
    return std::clamp(from_.x + (to_.x - from_.x) * ((y - from_.y) / (to_.y - from_.y)), low, high);
  return std::clamp(curve_.input(base_ + (y - from_.y) / scale_), low, high);
}

ElamState::ElamState(const ElamModel& model, const ElamPieces& pieces, bool memory)
    : model_(&model), pieces_(&pieces), memory_(memory) {
  reset();
}

// The branch from here to the end of the range.
ElamSegment ElamState::outer(bool ascending) const {
  return {*model_, *pieces_, ascending, here_, ascending ? high_end(*model_) : low_end(*model_)};
}

void ElamState::reset() {
  here_ = low_end(*model_);
  anchored_ = false;
  segments_.assign(1, outer(true));
}

// The branch that starts here: to the end of the range, or with memory to where it closes the loop.
ElamSegment ElamState::turned(bool ascending) const {
  const ElamSegment& last = segments_.back();
  if (!memory_) return outer(ascending);
  if (ascending != last.ascending()) return {*model_, *pieces_, ascending, here_, last.origin};
  ElamSegment again(*model_, *pieces_, ascending, here_, last.to());
  again.origin = last.origin;
  return again;
}

// `read` of the segment on which `value` lies on the way up or down from here, along closed loops to the outer ones.
double ElamState::follow(bool up, double value, double ElamPoint::*along,
                         double (ElamSegment::*read)(double) const) const {
  std::size_t count = segments_.size();
  if (!goes_on(up)) {
    const ElamSegment fresh = turned(up);
    if (up != segments_.back().ascending() && memory_) ++count;
    if (count <= 2 || !beyond(up, value, fresh.to().*along)) return (fresh.*read)(value);
    count -= 2;
  }
  while (count > 2 && beyond(up, value, segments_[count - 1].to().*along)) count -= 2;
  return (segments_[count - 1].*read)(value);
}

double ElamState::output_at(double x) const {
  x = std::clamp(x, model_->x0(), model_->xu());
  if (x == here_.x) return here_.y;
  const bool up = x > here_.x;
  const double y = follow(up, x, &ElamPoint::x, &ElamSegment::output);
  return up ? std::max(y, std::min(here_.y, model_->yu())) : std::min(y, here_.y);
}

double ElamState::input_at(double y) const {
  if (y == here_.y) return here_.x;
  const bool up = y > here_.y;
  const double x = follow(up, y, &ElamPoint::y, &ElamSegment::input);
  return up ? std::max(x, here_.x) : std::min(x, here_.x);
}

void ElamState::go(double x) {
  if (!std::isfinite(x)) throw std::invalid_argument("ELAM: the input is not a finite number");
  x = std::clamp(x, model_->x0(), model_->xu());
  if (x == here_.x) return;
  const bool up = x > here_.x;
  const double y = output_at(x);
  if (!goes_on(up)) {
    const ElamSegment fresh = turned(up);
    ElamSegment& last = segments_.back();
    if (!memory_ || up == last.ascending()) {
      last = fresh;
    } else {
      // A return to the branch that is left here continues from here.
      if (last.output(here_.x) != here_.y) last.go_on_from(here_);
      segments_.push_back(fresh);
    }
  }
  anchored_ = false;
  const auto closed = [&] { return segments_.size() > 2 && !beyond(up, segments_.back().to().x, x); };
  while (closed()) segments_.erase(segments_.end() - 2, segments_.end());
  here_ = {x, y};
  // At an end of the range older turning points are forgotten.
  if (x <= model_->x0()) segments_.assign(1, outer(true));
  if (x >= model_->xu()) segments_.assign(1, outer(false));
}

void ElamState::measured(double y) {
  if (!std::isfinite(y)) throw std::invalid_argument("ELAM: the measured output is not a finite number");
  const double near = kOuterShare * (model_->xu() - model_->x0());
  const bool low = here_.x - model_->x0() <= near, high = model_->xu() - here_.x <= near;
  if (low || high) {
    const ElamPoint from = low ? low_end(*model_) : high_end(*model_), to = low ? high_end(*model_) : low_end(*model_);
    segments_.assign(1, ElamSegment(*model_, *pieces_, low, from, to));
    here_.y = segments_.back().output(here_.x);
    anchored_ = false;
    return;
  }
  here_.y = std::max(y, model_->y0());
  if (memory_) {
    // Kept inside the remembered loop, which could not close otherwise.
    const double a = segments_.back().origin.y, b = segments_.back().to().y;
    here_.y = std::clamp(y, std::min(a, b), std::max(a, b));
  }
  anchored_ = true;
}

}  // namespace

ElamHysteresis::ElamHysteresis(ElamModel model, bool memory, ElamPieces pieces)
    : model_(std::move(model)), memory_(memory), pieces_(std::move(pieces)) {
  const PatternCurve &up = model_.ascending, &down = model_.descending;
  if (up.x().size() < 2 || !std::ranges::equal(up.x(), down.x()) || up.y().front() != down.y().front() ||
      up.y().back() != down.y().back())
    throw std::invalid_argument("ELAM model: the two patterns do not share their grid and their ends");
  if (!std::ranges::all_of(values_of(model_.parameters), [](double value) { return std::isfinite(value); }))
    throw std::invalid_argument("ELAM model: a parameter is not finite");
  for (const auto side : kElamSides)
    if (!std::ranges::all_of(pieces_.*side, [](double value) { return std::abs(value) <= kMaxPieceLog; }))
      throw std::invalid_argument("ELAM model: the size of a piece is not within e^±2");
  const int up_splits = 1 + static_cast<int>(pieces_.ascending_low.size() + pieces_.ascending_high.size());
  if (pieces_.splits() > kMaxSplits || pieces_.splits() != up_splits)
    throw std::invalid_argument(std::string("ELAM model: ") + std::to_string(pieces_.splits()) +
                                " split points down and " + std::to_string(up_splits) +
                                " up are not the same number up to " + std::to_string(kMaxSplits));
}

std::vector<ModelParameter> ElamHysteresis::parameters() const {
  const ElamParameters& p = model_.parameters;
  const double steepest = 1.0 / (model_.xu() - model_.x0());
  std::vector<ModelParameter> list = {{kElamParameterNames[0], p.alpha_d, "1", 0.0, 1.0},
                                      {kElamParameterNames[1], p.beta_d, "1", 0.0, 1.0},
                                      {kElamParameterNames[2], p.alpha_a1, "1/x", -steepest, steepest},
                                      {kElamParameterNames[3], p.alpha_a0, "1", 0.0, 1.0},
                                      {kElamParameterNames[4], p.beta_a, "1", 0.0, 1.0}};
  for (std::size_t i = 0; i < kElamSides.size(); ++i) {
    const char* direction = i < 2 ? "d" : "a";
    std::size_t number = i % 2 == 0 ? 0 : (pieces_.*kElamSides[i - 1]).size();
    for (const double value : pieces_.*kElamSides[i])
      list.push_back(
          {std::string("log_") + direction + std::to_string(++number), value, "1", -kMaxPieceLog, kMaxPieceLog});
  }
  return list;
}

// Direction and split compared, Eq. (16) or (23) as one multiply-add, one table access, its multiply-add, Eq. (17) or
// the closing scale as another. Further pieces: a comparison each, and one more map.
int ElamHysteresis::operations_per_sample() const { return pieces_.splits() == 1 ? 9 : 11 + pieces_.splits(); }

std::unique_ptr<ModelState> ElamHysteresis::state() const {
  return std::make_unique<ElamState>(model_, pieces_, memory_);
}

ModelMembers ElamHysteresis::members() const {
  const auto list = [](std::span<const double> values) { return std::vector(values.begin(), values.end()); };
  ModelMembers members = {{"x", list(model_.ascending.x())},
                          {"ascending", list(model_.ascending.y())},
                          {"descending", list(model_.descending.y())}};
  const std::vector<ModelParameter> all = parameters();
  for (std::size_t i = 0; i < kElamParameterNames.size(); ++i)
    members.emplace_back("parameters/" + all[i].name, all[i].value);
  const int splits = pieces_.splits();
  members.emplace_back("options/exact_outer", model_.options.exact_outer);
  members.emplace_back("options/memory", memory_);
  members.emplace_back("options/splits", splits);
  for (std::size_t i = 0; splits > 1 && i < kElamSides.size(); ++i)
    members.emplace_back(kSideMembers[i], pieces_.*kElamSides[i]);
  return members;
}

std::unique_ptr<HysteresisModel> ElamHysteresis::from(const ModelSource& source) {
  const auto p = [&](const char* name) { return source.parameter(name); };
  ElamPieces pieces;
  const double splits = source.number("options/splits");
  for (std::size_t i = 0; splits != 1.0 && i < kElamSides.size(); ++i)
    pieces.*kElamSides[i] = source.numbers(kSideMembers[i]);
  if (splits != pieces.splits())
    throw std::invalid_argument("model: \"splits\" is not the number of split points in \"pieces\"");
  ElamModel model{curve_from(source, "ascending"),
                  curve_from(source, "descending"),
                  {p("alpha_d"), p("beta_d"), p("alpha_a1"), p("alpha_a0"), p("beta_a")},
                  {source.flag("options/exact_outer")}};
  return std::make_unique<ElamHysteresis>(std::move(model), source.flag("options/memory"), std::move(pieces));
}

}  // namespace tactbench::analysis
