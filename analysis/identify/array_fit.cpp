#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <span>
#include <stdexcept>

#include "analysis/identify/elam/identify.h"
#include "analysis/statistics/numbers/moments.h"
#include "analysis/workers.h"

namespace tactbench::analysis {
namespace {

// One taxel's view of the common data.
struct TaxelData {
  std::vector<double> ascending_v, descending_v;
  std::vector<TaxelBranch> branches;
};

TaxelData taxel_data(const std::vector<TaxelTable>& sequences, const ExternalLoop& loop, std::size_t width,
                     std::size_t taxel) {
  TaxelData data;
  data.ascending_v.reserve(loop.pressure_psi.size());
  data.descending_v.reserve(loop.pressure_psi.size());
  for (std::size_t i = 0; i < loop.pressure_psi.size(); ++i) {
    data.ascending_v.push_back(loop.ascending[i * width + taxel]);
    data.descending_v.push_back(loop.descending[i * width + taxel]);
  }
  for (const TaxelTable& sequence : sequences) {
    for (const Branch& branch : sequence.branches) {
      TaxelBranch own;
      own.ascending = branch.ascending;
      own.pressure_psi.assign(sequence.pressure_psi.begin() + branch.first,
                              sequence.pressure_psi.begin() + branch.last + 1);
      own.volts.reserve(own.pressure_psi.size());
      for (auto i = static_cast<std::size_t>(branch.first); i <= static_cast<std::size_t>(branch.last); ++i)
        own.volts.push_back(sequence.values[i * width + taxel]);
      data.branches.push_back(std::move(own));
    }
  }
  return data;
}

std::pair<double, double> range_of(const TaxelData& data) {
  double low = data.branches.front().volts.front(), high = low;
  for (const TaxelBranch& branch : data.branches) {
    const auto [a, b] = std::ranges::minmax_element(branch.volts);
    low = std::min(low, *a);
    high = std::max(high, *b);
  }
  return {low, high};
}

TaxelFit fit_taxel(const TaxelData& data, const std::vector<double>& grid, double noise, bool at_limit,
                   const ArrayFitOptions& options) {
  TaxelFit result;
  result.noise_v = noise;
  const auto [low, high] = range_of(data);
  if (at_limit) {  // also one that stands there for ever
    result.status = TaxelStatus::kSaturated;
    return result;
  }
  if (high - low < options.dead_v) {
    result.status = std::abs(high) < options.dead_v ? TaxelStatus::kDead : TaxelStatus::kStuck;
    return result;
  }
  // Both patterns start and end in the mean of the two measured ends [A11].
  const double y0 = 0.5 * (data.ascending_v.front() + data.descending_v.front());
  const double yu = 0.5 * (data.ascending_v.back() + data.descending_v.back());
  if (yu - y0 < options.dead_v) return result;  // it moves, but not with pressure
  const PatternCurve ascending(grid, data.ascending_v, y0, yu), descending(grid, data.descending_v, y0, yu);
  result.fit = identify_elam(ascending, descending, data.branches, options.elam);
  if (result.fit.mean_error_v <= options.unfit_share * result.fit.full_scale_v) result.status = TaxelStatus::kFitted;
  return result;
}

// The mean of all outputs falls from the lowest pressure to the highest.
bool falls(const ExternalLoop& loop, std::size_t width, double dead_v) {
  const std::size_t last = (loop.pressure_psi.size() - 1) * width;
  const auto mean_at = [&](const std::vector<double>& volts, std::size_t first) {
    return mean_of(std::span<const double>(volts).subspan(first, width));
  };
  const double start = 0.5 * (mean_at(loop.ascending, 0) + mean_at(loop.descending, 0));
  const double end = 0.5 * (mean_at(loop.ascending, last) + mean_at(loop.descending, last));
  return start - end >= dead_v;
}

void negate(std::vector<double>& values) {
  for (double& value : values) value = -value;
}

std::vector<std::size_t> fitted_of(const ArrayFit& fit) {
  std::vector<std::size_t> fitted;
  for (std::size_t taxel = 0; taxel < fit.taxels.size(); ++taxel)
    if (fit.taxels[taxel].status == TaxelStatus::kFitted) fitted.push_back(taxel);
  return fitted;
}

// The mean over the fitted taxels as one more taxel.
TaxelFit fit_mean(const std::vector<TaxelTable>& sequences, const ExternalLoop& loop, std::size_t width,
                  const ArrayFit& fit, const ArrayFitOptions& options) {
  const std::vector<std::size_t> fitted = fitted_of(fit);
  double variance = 0.0;
  for (const std::size_t taxel : fitted) variance += fit.taxels[taxel].noise_v * fit.taxels[taxel].noise_v;
  if (fitted.empty())
    throw AnalysisError("TB-ANALYSIS-NO-TAXEL", fmt::format("run {}: no taxel could be fitted", fit.run),
                        "look at the frames: dead, stuck and saturated taxels are left out");
  const auto mean = [&](const std::vector<double>& volts) {
    std::vector<double> result(volts.size() / width, 0.0);
    for (std::size_t i = 0; i < result.size(); ++i)
      result[i] = mean_of_chosen(std::span<const double>(volts).subspan(i * width, width),
                                 std::span<const std::size_t>(fitted));
    return result;
  };
  std::vector<TaxelTable> means;
  for (const TaxelTable& sequence : sequences)
    means.push_back({sequence.pressure_psi, mean(sequence.values), sequence.branches});
  const ExternalLoop mean_loop{loop.pressure_psi, mean(loop.ascending), mean(loop.descending)};
  const double noise = std::sqrt(variance) / static_cast<double>(fitted.size());
  return fit_taxel(taxel_data(means, mean_loop, 1, 0), loop.pressure_psi, noise, false, options);
}

}  // namespace

const char* to_string(TaxelStatus status) {
  switch (status) {
    case TaxelStatus::kFitted:
      return "fitted";
    case TaxelStatus::kDead:
      return "dead";
    case TaxelStatus::kStuck:
      return "stuck";
    case TaxelStatus::kSaturated:
      return "saturated";
    case TaxelStatus::kUnfit:
      return "unfit";
  }
  return "unfit";
}

Dataset as_modelled(Dataset dataset, const ArrayFit& fit) {
  if (!fit.falling) return dataset;
  for (SequenceData& sequence : dataset.sequences)
    for (Repeat& repeat : sequence.repeats) negate(repeat.volts);
  return dataset;
}

ArrayFit fit_array(const Dataset& dataset, const ArrayFitOptions& options) {
  const auto width = static_cast<std::size_t>(dataset.taxels());
  std::vector<TaxelTable> sequences(dataset.sequences.size());
  for_each_index(sequences.size(), options.threads, [&](std::size_t i) {
    sequences[i] = bring_to_common(dataset.sequences[i], dataset.taxels(), options.common);
  });
  ExternalLoop loop = external_loop(sequences, dataset.taxels());
  ArrayFit fit;
  fit.rows = dataset.rows;
  fit.columns = dataset.columns;
  fit.falling = falls(loop, width, options.dead_v);
  if (fit.falling) {
    for (TaxelTable& sequence : sequences) negate(sequence.values);
    negate(loop.ascending);
    negate(loop.descending);
  }
  fit.run = dataset.run;
  fit.origin = dataset.origin;
  fit.sensor_serial = dataset.sensor_serial;
  fit.scanner_serial = dataset.scanner_serial;
  fit.pressure_psi = loop.pressure_psi;
  fit.taxels.resize(width);
  for_each_index(width, options.threads, [&](std::size_t taxel) {
    fit.taxels[taxel] = fit_taxel(taxel_data(sequences, loop, width, taxel), loop.pressure_psi, dataset.noise_v[taxel],
                                  dataset.at_limit[taxel], options);
  });
  fit.mean_taxel = fit_mean(sequences, loop, width, fit, options);
  fit.full_scale_v = fit.mean_taxel.fit.full_scale_v;
  fit.repeats = repeat_drifts(dataset, fitted_of(fit), options.common);
  return fit;
}

}  // namespace tactbench::analysis
