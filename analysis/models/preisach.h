// Preisach model with non-negative weights, which the paper does not compare (Mayergoyz, Mathematical Models of
// Hysteresis, 1991; the discrete weights by least squares after Hoffmann and Sprekels). Rate-independent, with
// return-point memory: inner loops close.
#pragma once

#include "analysis/models/model.h"

namespace tactbench::analysis {

// The input range is cut into n equal intervals. Cell (i, j), j <= i, holds relays that switch on in interval i and off
// in interval j: not at one point but spread along the cell's diagonal, on at low + (i + s) h and off at low + (j + s)
// h for s = 0..1. So each cell is a play operator that rises evenly over interval i and falls evenly over interval j,
// the output is continuous and piecewise linear in the input, and cells on the diagonal are reversible.
class PreisachModel final : public HysteresisModel {
 public:
  static constexpr const char* kName = "preisach";
  static constexpr double kFitShare = 5.0;
  static std::unique_ptr<HysteresisModel> from(const ModelSource& source);
  static std::unique_ptr<Identifier> prepare(const FitData& like, const IdentifyOptions& options);

  // weights[i (i + 1) / 2 + j] >= 0 of cell (i, j), in y. Throws std::invalid_argument when their number is not that
  // of a triangle, one is negative or not finite, or x_low >= x_high.
  PreisachModel(double x_low, double x_high, double y_low, std::vector<double> weights);

  [[nodiscard]] std::string name() const override { return kName; }
  [[nodiscard]] ModelMembers members() const override;
  [[nodiscard]] std::vector<ModelParameter> parameters() const override;  // "w(i,j)": those above 0, in y
  [[nodiscard]] double x_low() const override { return x_low_; }
  [[nodiscard]] double x_high() const override { return x_high_; }
  [[nodiscard]] int operations_per_sample() const override;
  [[nodiscard]] std::unique_ptr<ModelState> state() const override;

  static std::size_t cell(std::size_t i, std::size_t j) { return i * (i + 1) / 2 + j; }
  [[nodiscard]] double y_low() const { return y_low_; }
  [[nodiscard]] const std::vector<double>& weights() const { return weights_; }
  [[nodiscard]] std::size_t intervals() const { return n_; }
  // Everett's function: the output's rise when the input rises from `low`, a minimum, to `high`, and its fall on the
  // way back; both within the range, 0 when high <= low. A constant number of table accesses.
  [[nodiscard]] double everett(double high, double low) const;

 private:
  [[nodiscard]] double above(std::size_t i, std::size_t j) const { return above_[i * (n_ + 1) + j]; }
  double x_low_, x_high_, y_low_;
  std::vector<double> weights_;
  std::size_t n_ = 0;
  std::vector<double> above_;  // (i, j): the sum of all cells in rows below i and columns from j on
};

}  // namespace tactbench::analysis
