// Identification of the models beside ELAM on the rebuilt taxel, each set of the paper, beside plain versions in the
// same run.
#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include <Eigen/Dense>
#include <filesystem>
#include <fstream>

#include "analysis/identify/identifier.h"
#include "analysis/models/mpi.h"
#include "analysis/models/poly.h"
#include "tests/analysis/support/fit_samples.h"
#include "tests/benchmarks/speed/figures.h"

using namespace synthetic;

namespace {

FitData taxel(bool ascending) {
  return paper_data(ascending ? kAscendingTurns : kDescendingTurns, ascending ? 0.0205 : 0.032, 1);
}

void fitted(benchmark::State& state, const char* name) {
  const FitData data = taxel(state.range(0) != 0);
  const auto prepared = prepare(name, data);
  double j = 0.0;
  for (auto _ : state) {
    j = prepared->fit(data).j;
    benchmark::ClobberMemory();
  }
  state.counters["J"] = j;
}

void prepared_and_fitted(benchmark::State& state, const char* name) {
  const FitData data = taxel(state.range(0) != 0);
  double j = 0.0;
  for (auto _ : state) {
    j = identify(name, data).j;
    benchmark::ClobberMemory();
  }
  state.counters["J"] = j;
}

// MPI as one would write it down: for each tau of a fine grid the four linear parameters by QR.
void plain_mpi(benchmark::State& state) {
  const FitData data = taxel(state.range(0) != 0);
  const History& history = data.histories.front();
  const auto rows = static_cast<Eigen::Index>(history.x.size()) - 1;
  double best = 0.0;
  for (auto _ : state) {
    best = std::numeric_limits<double>::infinity();
    for (int k = 0; k <= 1000; ++k) {
      const MpiModel::Operators density = MpiModel::densities(-kMpiTau + 2.0 * kMpiTau * k / 1000.0);
      const double largest = *std::ranges::max_element(density);
      Eigen::MatrixXd basis(rows, 4);
      Eigen::VectorXd target(rows);
      MpiModel::Operators operators{};
      for (Eigen::Index r = 0; r < rows; ++r) {
        const double u = history.x[static_cast<std::size_t>(r) + 1] / 60.0;
        operators = MpiModel::moved(operators, u);
        double plays = 0.0;
        for (std::size_t i = 0; i < operators.size(); ++i) plays += density[i] / largest * operators[i];
        basis.row(r) << u, u * u, u * u * u, plays;
        target[r] = history.y[static_cast<std::size_t>(r) + 1];
      }
      const Eigen::VectorXd c = basis.householderQr().solve(target);
      best = std::min(best, (basis * c - target).squaredNorm());
    }
    benchmark::DoNotOptimize(best);
  }
  state.counters["J"] = best;
}

// POLY likewise: powers of t, QR, branch by branch.
void plain_poly(benchmark::State& state) {
  const FitData data = taxel(state.range(0) != 0);
  const History& history = data.histories.front();
  double j = 0.0;
  for (auto _ : state) {
    j = 0.0;
    for (const bool ascending : {true, false}) {
      std::vector<double> rows, target;
      for (const Branch& branch : history.branches) {
        if (branch.ascending != ascending) continue;
        const auto first = static_cast<std::size_t>(branch.first), last = static_cast<std::size_t>(branch.last);
        const double x1 = history.x[first], y1 = x1 == 0.0 ? 0.0 : x1 == 60.0 ? 3.49 : history.y[first];
        for (std::size_t i = first + 1; i <= last; ++i) {
          const double t = ascending ? (history.x[i] - x1) / (60.0 - x1) : history.x[i] / x1;
          const double height = ascending ? 3.49 - y1 : y1, base = ascending ? y1 : 0.0;
          for (int k = 2; k <= 6; ++k) rows.push_back(height * (std::pow(t, k) - t));
          target.push_back(history.y[i] - base - height * t);
        }
      }
      const Eigen::Map<const Eigen::Matrix<double, Eigen::Dynamic, 5, Eigen::RowMajor>> basis(
          rows.data(), static_cast<Eigen::Index>(target.size()), 5);
      const Eigen::Map<const Eigen::VectorXd> wanted(target.data(), static_cast<Eigen::Index>(target.size()));
      const Eigen::VectorXd c = basis.householderQr().solve(wanted);
      j += (basis * c - wanted).squaredNorm();
    }
    benchmark::DoNotOptimize(j);
  }
  state.counters["J"] = j;
}

// All taxels of an array share their inputs: one preparation, 256 fits.
void array_of_256(benchmark::State& state, const char* name) {
  std::vector<FitData> taxels;
  for (unsigned seed = 1; seed <= 256; ++seed) taxels.push_back(paper_both(0.032, 0.0205, seed));
  for (auto _ : state) {
    const auto prepared = prepare(name, taxels.front());
    for (const FitData& data : taxels) benchmark::DoNotOptimize(prepared->fit(data).j);
  }
}

BENCHMARK_CAPTURE(fitted, gpi, "gpi")->Name("models/fitted_gpi")->Arg(0)->Arg(1)->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(fitted, mpi, "mpi")->Name("models/fitted_mpi")->Arg(0)->Arg(1)->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(prepared_and_fitted, mpi, "mpi")
    ->Name("models/prepared_and_fitted_mpi")
    ->Arg(0)
    ->Arg(1)
    ->Unit(benchmark::kMicrosecond);
BENCHMARK(plain_mpi)->Name("models/plain_mpi")->Arg(0)->Arg(1)->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(fitted, poly, "poly")->Name("models/fitted_poly")->Arg(0)->Arg(1)->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(prepared_and_fitted, poly, "poly")
    ->Name("models/prepared_and_fitted_poly")
    ->Arg(0)
    ->Arg(1)
    ->Unit(benchmark::kMicrosecond);
BENCHMARK(plain_poly)->Name("models/plain_poly")->Arg(0)->Arg(1)->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(fitted, preisach, "preisach")
    ->Name("models/fitted_preisach")
    ->Arg(0)
    ->Arg(1)
    ->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(fitted, monotone, "monotone")
    ->Name("models/fitted_monotone")
    ->Arg(0)
    ->Arg(1)
    ->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(array_of_256, preisach, "preisach")
    ->Name("models/array_of_256_preisach")
    ->Unit(benchmark::kMillisecond);

}  // namespace

void tactbench::speed::write_tables(const std::string& folder) {
  for (const bool ascending : {false, true}) {
    const FitData data = taxel(ascending);
    const History& history = data.histories.front();
    std::ofstream file(std::filesystem::path(folder) / (ascending ? "ascending.csv" : "descending.csv"));
    file << "input,output\n";
    for (std::size_t i = 0; i < history.x.size(); ++i) file << fmt::format("{},{}\n", history.x[i], history.y[i]);
    if (!file.flush()) throw std::runtime_error("the tables could not be written to " + folder);
  }
}
