#include "analysis/identify/elam/elam.h"

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <stdexcept>
#include <utility>

#include "analysis/algebra/dense.h"
#include "analysis/identify/elam/lanes.h"
#include "analysis/identify/elam/search.h"

namespace tactbench::analysis {
namespace {

// Puts the samples at the same place together and returns what J gains by them whatever the model's value there.
double merge(CurveSamples& curve) {
  std::vector<std::size_t> order(curve.x.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::ranges::stable_sort(order, {}, [&](std::size_t i) { return curve.x[i]; });
  CurveSamples merged{curve.x_turn, curve.y_turn, {}, {}, {}};
  double constant = 0.0;
  for (const std::size_t i : order) {
    if (merged.x.empty() || curve.x[i] != merged.x.back()) {
      merged.x.push_back(curve.x[i]);
      merged.y.push_back(curve.y[i]);
      merged.weight.push_back(1.0);
      continue;
    }
    double &mean = merged.y.back(), &weight = merged.weight.back();
    const double off = curve.y[i] - mean;
    constant += off * off * weight / (weight + 1.0);
    weight += 1.0;
    mean += off / weight;
  }
  curve = std::move(merged);
  return constant;
}

}  // namespace

TurningPoint turning_point(const ElamModel& model, const TaxelBranch& branch) {
  const double x = branch.pressure_psi.front(), near = kOuterShare * (model.xu() - model.x0());
  if (branch.ascending && x - model.x0() <= near) return {model.x0(), model.y0()};
  if (!branch.ascending && model.xu() - x <= near) return {model.xu(), model.yu()};
  return {x, branch.volts.front()};
}

ElamSamples collect_samples(const ElamModel& model, std::span<const TaxelBranch> branches) {
  ElamSamples samples;
  std::map<std::pair<double, double>, std::size_t> ascending, descending;  // places of curves by turning point
  for (const TaxelBranch& branch : branches) {
    const TurningPoint turn = turning_point(model, branch);
    std::vector<CurveSamples>& curves = branch.ascending ? samples.ascending : samples.descending;
    const auto [place, is_new] =
        (branch.ascending ? ascending : descending).try_emplace({turn.x, turn.y}, curves.size());
    if (is_new) curves.push_back({turn.x, turn.y, {}, {}, {}});
    CurveSamples& curve = curves[place->second];
    curve.x.insert(curve.x.end(), branch.pressure_psi.begin() + 1, branch.pressure_psi.end());
    curve.y.insert(curve.y.end(), branch.volts.begin() + 1, branch.volts.end());
  }
  for (CurveSamples& curve : samples.ascending) samples.ascending_constant += merge(curve);
  for (CurveSamples& curve : samples.descending) samples.descending_constant += merge(curve);
  return samples;
}

void thin(std::vector<CurveSamples>& curves, std::size_t most) {
  std::size_t count = 0;
  for (const CurveSamples& curve : curves) count += curve.x.size();
  if (count <= most) return;
  // Multiples of the golden section, modulo 1, are even over any stretch and in step with no period of the data.
  constexpr double kGolden = 0.6180339887498949;
  const double share = static_cast<double>(most) / static_cast<double>(count);
  std::size_t number = 0;
  for (CurveSamples& curve : curves) {
    std::size_t kept = 0;
    for (std::size_t i = 0; i < curve.x.size(); ++i) {
      if (std::fmod(kGolden * static_cast<double>(++number), 1.0) >= share) continue;
      curve.x[kept] = curve.x[i];
      curve.y[kept] = curve.y[i];
      curve.weight[kept++] = curve.weight[i];
    }
    for (std::vector<double>* list : {&curve.x, &curve.y, &curve.weight}) list->resize(kept);
  }
  std::erase_if(curves, [](const CurveSamples& curve) { return curve.x.empty(); });
}

std::array<double, 3> direction_of(const ElamParameters& p, bool ascending, double length) {
  if (!ascending) return {p.alpha_d, p.beta_d, 0.0};
  return {p.alpha_a0, p.alpha_a0 + p.alpha_a1 * length, p.beta_a};
}

void set_direction(ElamParameters& p, bool ascending, double length, const double* at) {
  if (ascending) {
    p.alpha_a0 = at[0];
    p.alpha_a1 = (at[1] - at[0]) / length;
    p.beta_a = at[2];
  } else {
    p.alpha_d = at[0];
    p.beta_d = at[1];
  }
}

namespace {

constexpr double kAnywhere = 1.0 / 12.0;  // variance of a value drawn from 0..1
// A parameter, of residuals squared: a split at an unknown place gains more by chance than a fixed one (Andrews,
// Econometrica 1993: 11.8 for two parameters at 95 %).
constexpr double kByChance = 6.0;
constexpr double kSameJ = 1e-7;          // share
constexpr double kSmallestError = 1e-4;  // of full scale: what is taken as a sample's error at least
constexpr double kStep = 1e-5;           // of a parameter, for derivatives
constexpr int kNearer = 16;              // places on the way to the pattern

// One direction's parameters, each in 0..1: alpha_d, beta_d, or phi(0), phi(X), beta_a.
class Halved {
 public:
  using At = Eigen::VectorXd;
  Halved(ElamModel& model, std::span<const CurveSamples> curves, double constant, bool ascending)
      : model_(model), curves_(curves), constant_(constant), ascending_(ascending) {
    for (const CurveSamples& curve : curves) {
      rows_ += static_cast<Eigen::Index>(curve.x.size());
      for (const double weight : curve.weight) samples_ += weight;
    }
  }
  [[nodiscard]] Eigen::Index size() const { return ascending_ ? 3 : 2; }
  [[nodiscard]] At here() const {
    const std::array<double, 3> row = direction_of(model_.parameters, ascending_, length());
    return At::Map(row.data(), size());
  }
  // The pattern's own split at this share of the input range.
  [[nodiscard]] At own_split(double share) const {
    const PatternCurve& pattern = ascending_ ? model_.ascending : model_.descending;
    const double beta = (pattern(model_.x0() + share * length()) - model_.y0()) / (model_.yu() - model_.y0());
    At at = At::Constant(size(), share);
    at[size() - 1] = std::clamp(beta, 0.0, 1.0);
    return at;
  }
  void put(const At& at) { set_direction(model_.parameters, ascending_, length(), at.data()); }
  [[nodiscard]] double j(const At& at) { return constant_ + residuals(at).squaredNorm(); }
  // Directions with the variance that the samples leave in each.
  struct Spread {
    Eigen::MatrixXd directions;
    Eigen::VectorXd variances;
    bool all = false;
    [[nodiscard]] bool open(Eigen::Index parameter) const {
      return all || directions.row(parameter).cwiseAbs2().dot(variances) > kAnywhere;
    }
    [[nodiscard]] bool any_open() const {
      for (Eigen::Index k = 0; k < directions.rows(); ++k)
        if (open(k)) return true;
      return false;
    }
  };
  [[nodiscard]] Spread spread(const At& at, double j) {
    Eigen::MatrixXd slopes(rows_, size());
    for (Eigen::Index k = 0; k < size(); ++k) {
      At low = at, high = at;
      low[k] = std::max(low[k] - kStep, 0.0);
      high[k] = std::min(high[k] + kStep, 1.0);
      slopes.col(k) = (residuals(high) - residuals(low)) / (high[k] - low[k]);
    }
    const Eigen::MatrixXd normal = gram_of(slopes);
    const SymmetricEigen eigen = eigen_of(normal);
    const double least = kSmallestError * (model_.yu() - model_.y0());
    const double variance = sample_variance(j);
    const double smallest = 1e-14 * std::max(normal.trace(), least * least);
    return {eigen.vectors, (variance / eigen.values.array().max(smallest)).matrix()};
  }
  // J changes by no more than one standard error's worth as the split runs along the pattern. Derivatives do not show
  // it: at the pattern's corners those to either side differ.
  [[nodiscard]] bool open_along_pattern(double j) {
    const double most = this->j(own_split(0.5)) + sample_variance(j), way = std::sqrt(kAnywhere);
    return this->j(own_split(0.5 - way)) <= most && this->j(own_split(0.5 + way)) <= most;
  }
  [[nodiscard]] double as_good(double j) const {
    const double least = kSmallestError * (model_.yu() - model_.y0());
    const double k = static_cast<double>(size());
    return std::max(j, samples_ * least * least) * (1.0 + kByChance * k / std::max(samples_ - k, 1.0));
  }

 private:
  [[nodiscard]] double length() const { return model_.xu() - model_.x0(); }
  [[nodiscard]] double sample_variance(double j) const {
    const double least = kSmallestError * (model_.yu() - model_.y0());
    return std::max(j / std::max(samples_ - static_cast<double>(size()), 1.0), least * least);
  }
  [[nodiscard]] Eigen::VectorXd residuals(const At& at) {
    put(at);
    Eigen::VectorXd off(rows_);
    Eigen::Index row = 0;
    for (const CurveSamples& samples : curves_) {
      const ElamCurve curve(model_, ascending_, samples.x_turn, samples.y_turn);
      for (std::size_t i = 0; i < samples.x.size(); ++i)
        off[row++] = std::sqrt(samples.weight[i]) * (curve.output(samples.x[i]) - samples.y[i]);
    }
    return off;
  }
  ElamModel& model_;
  std::span<const CurveSamples> curves_;
  double constant_;
  bool ascending_;
  Eigen::Index rows_ = 0;
  double samples_ = 0.0;
};

}  // namespace

unsigned settle_undetermined(ElamModel& model, std::span<const CurveSamples> curves, double constant, bool ascending) {
  const ElamParameters before = model.parameters;
  Halved half(model, curves, constant, ascending);
  const Halved::At found = half.here(), middle = half.own_split(0.5);
  const double j = half.j(found);
  Halved::At taken = found;
  Halved::Spread spread;
  const bool as_good = half.j(middle) <= half.as_good(j);
  if (as_good) {
    spread = half.spread(middle, j);
    spread.all = half.open_along_pattern(j);
  }
  if (as_good && spread.any_open()) {
    taken = middle;
  } else {
    spread = half.spread(found, j);
    const Eigen::VectorXd open = (spread.variances.array() > kAnywhere).cast<double>().matrix();
    const Halved::At way =
        spread.directions * open.cwiseProduct(spread.directions.transpose() * (middle - found)).eval();
    for (int k = kNearer; spread.any_open() && k > 0; --k) {
      const Halved::At to = (found + way * k / kNearer).cwiseMax(0.0).cwiseMin(1.0);
      if (half.j(to) > j * (1.0 + kSameJ)) continue;
      taken = to;
      break;
    }
  }
  half.put(taken);
  if (taken == found) model.parameters = before;  // bit for bit
  // phi(0) is alpha_a0 and stands at bit 3, phi(X) stands for alpha_a1.
  constexpr unsigned kBits[2][3] = {{0, 1, 1}, {3, 2, 4}};
  unsigned bits = 0;
  for (Eigen::Index k = 0; k < half.size(); ++k)
    if (spread.open(k)) bits |= 1U << kBits[ascending ? 1 : 0][k];
  return bits;
}

namespace {

void check(const PatternCurve& ascending, const PatternCurve& descending, std::span<const TaxelBranch> branches) {
  if (ascending.x().size() < 2 || descending.x().size() < 2 || ascending.x().front() != descending.x().front() ||
      ascending.x().back() != descending.x().back() || ascending.y().front() != descending.y().front() ||
      ascending.y().back() != descending.y().back())
    throw std::invalid_argument("the two pattern curves do not meet at both ends");
  bool up = false, down = false;
  for (const TaxelBranch& branch : branches) {
    if (branch.volts.size() < 2 || branch.volts.size() != branch.pressure_psi.size())
      throw std::invalid_argument("a branch needs at least two samples, with a pressure each");
    const auto finite = [](double value) { return std::isfinite(value); };
    if (!std::ranges::all_of(branch.volts, finite) || !std::ranges::all_of(branch.pressure_psi, finite))
      throw std::invalid_argument("a branch holds a value that is not finite");
    (branch.ascending ? up : down) = true;
  }
  if (!up || !down) throw std::invalid_argument("branches of both directions are needed");
}

}  // namespace

unsigned bounds_met(const ElamModel& model) {
  constexpr double kNear = 1e-9;
  const ElamParameters& p = model.parameters;
  const double v = p.alpha_a1 * (model.xu() - model.x0()) + p.alpha_a0;  // phi(X); phi(0) is alpha_a0
  const double values[] = {p.alpha_d, p.beta_d, v, p.alpha_a0, p.beta_a};
  unsigned bits = 0;
  for (unsigned i = 0; i < 5; ++i)
    if (values[i] <= kNear || values[i] >= 1.0 - kNear) bits |= 1U << i;
  return bits;
}

ElamSamples searched_samples(const ElamModel& model, std::span<const TaxelBranch> branches) {
  check(model.ascending, model.descending, branches);
  ElamSamples samples = collect_samples(model, branches);
  // With exact_outer no parameter moves the external branches: they are scored, not searched.
  if (model.options.exact_outer) {
    std::erase_if(samples.descending, [&](const CurveSamples& c) { return c.x_turn == model.xu(); });
    std::erase_if(samples.ascending, [&](const CurveSamples& c) { return c.x_turn == model.x0(); });
  }
  thin(samples.descending, kSearchedSamples);
  thin(samples.ascending, kSearchedSamples);
  return samples;
}

ElamFit scored(const ElamModel& model, std::span<const TaxelBranch> branches) {
  ElamFit fit;
  fit.model = model;
  fit.full_scale_v = std::max(std::abs(model.y0()), std::abs(model.yu()));
  fit.at_bound = bounds_met(model);
  std::size_t count = 0;
  for (const TaxelBranch& branch : branches) {
    const TurningPoint turn = turning_point(model, branch);
    const ElamCurve curve(model, branch.ascending, turn.x, turn.y);
    for (std::size_t i = 1; i < branch.volts.size(); ++i, ++count) {
      const double error = curve.output(branch.pressure_psi[i]) - branch.volts[i];
      fit.j_v2 += error * error;            // (1)
      fit.mean_error_v += std::abs(error);  // (49)
      fit.max_error_v = std::max(fit.max_error_v, std::abs(error));
    }
  }
  fit.mean_error_v /= static_cast<double>(count);
  return fit;
}

std::vector<std::string> undetermined_names(const ElamFit& fit) {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < kElamParameterNames.size(); ++i)
    if (((fit.undetermined >> i) & 1U) != 0) names.emplace_back(kElamParameterNames[i]);
  return names;
}

ElamFit identify_elam(const PatternCurve& ascending, const PatternCurve& descending,
                      std::span<const TaxelBranch> branches, const ElamOptions& options, bool settle) {
  ElamModel model{ascending, descending, {}, options};
  const ElamSamples samples = searched_samples(model, branches);
  fit_descending(model, samples.descending);
  fit_ascending(model, samples.ascending);
  unsigned undetermined = 0;
  if (settle) {
    undetermined = settle_undetermined(model, samples.descending, samples.descending_constant, false);
    undetermined |= settle_undetermined(model, samples.ascending, samples.ascending_constant, true);
  }
  ElamFit fit = scored(model, branches);
  fit.undetermined = undetermined;
  return fit;
}

// Further split points a branch, from the optimum with one: for each way to share them between the two sides of the
// paper's split, Levenberg-Marquardt with numeric derivatives in the paper's parameters and the pieces' sizes.

namespace {

constexpr int kSteps = 30;
constexpr double kDifference = 1e-6;  // of a parameter, for derivatives
constexpr double kSettled = 1e-9;     // gain of a step, of J

// One direction's parameters in one row: the paper's, each in [0, 1], then the logarithms of the pieces' sizes.
class Direction {
 public:
  Direction(const ElamModel& model, std::span<const CurveSamples> curves, bool ascending, std::size_t low,
            std::size_t high)
      : model_(model), curves_(curves), ascending_(ascending), low_(low), high_(high) {
    for (const CurveSamples& curve : curves) samples_ += static_cast<Eigen::Index>(curve.x.size());
  }
  [[nodiscard]] Eigen::Index own() const { return ascending_ ? 3 : 2; }  // the paper's parameters
  [[nodiscard]] Eigen::VectorXd start() const {
    const std::array<double, 3> row = direction_of(model_.parameters, ascending_, length());
    Eigen::VectorXd at = Eigen::VectorXd::Zero(own() + static_cast<Eigen::Index>(low_ + high_));
    at.head(own()) = Eigen::VectorXd::Map(row.data(), own());
    return clipped(at);
  }
  [[nodiscard]] Eigen::VectorXd clipped(Eigen::VectorXd at) const {
    at.head(own()) = at.head(own()).cwiseMax(0.0).cwiseMin(1.0);
    const Eigen::Index pieces = at.size() - own();
    at.tail(pieces) = at.tail(pieces).cwiseMax(-kMaxPieceLog).cwiseMin(kMaxPieceLog);
    return at;
  }
  void put(const Eigen::VectorXd& at, ElamModel& model, ElamPieces& pieces) const {
    set_direction(model.parameters, ascending_, length(), at.data());
    const double* logs = at.data() + own();
    (ascending_ ? pieces.ascending_low : pieces.descending_low).assign(logs, logs + low_);
    (ascending_ ? pieces.ascending_high : pieces.descending_high).assign(logs + low_, logs + low_ + high_);
  }
  [[nodiscard]] Eigen::VectorXd residuals(const Eigen::VectorXd& at, ElamModel& model) const {
    ElamPieces pieces;
    pieces.descending_low.resize(low_ + high_);  // so many splits, whichever direction is looked at
    put(at, model, pieces);
    Eigen::VectorXd off(samples_);
    Eigen::Index k = 0;
    for (const CurveSamples& samples : curves_) {
      const ElamPiecedCurve curve(model, pieces, ascending_, samples.x_turn, samples.y_turn);
      for (std::size_t i = 0; i < samples.x.size(); ++i)
        off[k++] = std::sqrt(samples.weight[i]) * (curve.output(samples.x[i]) - samples.y[i]);
    }
    return off;
  }
  [[nodiscard]] ElamModel model() const { return model_; }
  [[nodiscard]] Eigen::Index samples() const { return samples_; }

 private:
  [[nodiscard]] double length() const { return model_.xu() - model_.x0(); }
  const ElamModel& model_;
  std::span<const CurveSamples> curves_;
  bool ascending_;
  std::size_t low_, high_;
  Eigen::Index samples_ = 0;
};

struct Found {
  double j = std::numeric_limits<double>::infinity();
  Eigen::VectorXd at;
};

Found descend(const Direction& direction) {
  ElamModel model = direction.model();
  Eigen::VectorXd at = direction.start();
  Eigen::VectorXd off = direction.residuals(at, model);
  Found found{off.squaredNorm(), at};
  Eigen::MatrixXd slopes(direction.samples(), at.size());
  double damping = 1e-3;
  for (int step = 0; step < kSteps; ++step) {
    for (Eigen::Index k = 0; k < at.size(); ++k) {
      Eigen::VectorXd moved = at;
      const double by = at[k] > 0.5 ? -kDifference : kDifference;  // inside the bounds
      moved[k] += by;
      slopes.col(k) = (direction.residuals(moved, model) - off) / by;
    }
    const Eigen::MatrixXd normal = gram_of(slopes);
    const Eigen::VectorXd along = slopes.transpose() * off;
    const double before = found.j;
    while (damping < 1e6) {
      Eigen::MatrixXd damped = normal;
      damped.diagonal() += damping * (normal.diagonal().array() + 1e-9 * normal.diagonal().maxCoeff()).matrix();
      const Eigen::VectorXd tried = direction.clipped(at - solve(damped, along));
      if (!tried.allFinite()) break;
      const Eigen::VectorXd there = direction.residuals(tried, model);
      if (there.squaredNorm() < found.j) {
        found = {there.squaredNorm(), tried};
        at = tried;
        off = there;
        damping = std::max(damping * 0.1, 1e-9);
        break;
      }
      damping *= 8.0;
    }
    if (before - found.j <= kSettled * before) break;
  }
  return found;
}

}  // namespace

ElamPieces fit_pieces(ElamModel& model, const ElamSamples& samples, int splits) {
  ElamPieces pieces;
  const auto more = static_cast<std::size_t>(splits - 1);
  for (const bool ascending : {false, true}) {
    const std::vector<CurveSamples>& curves = ascending ? samples.ascending : samples.descending;
    const ElamModel start = model;
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t low = 0; low <= more; ++low) {
      const Direction direction(start, curves, ascending, low, more - low);
      const Found found = descend(direction);
      if (found.j >= least) continue;
      least = found.j;
      direction.put(found.at, model, pieces);
    }
  }
  return pieces;
}

}  // namespace tactbench::analysis
