#include "bench/benchmarks/report.h"

#include <fstream>

#include "analysis/report/gather.h"
#include "analysis/report/runs.h"
#include "bench/benchmarks/synthetic_array.h"

namespace tactbench::bench {

namespace {

// 60 times less than matplotlib took for the same plots where the goals were measured: the one goal here that depends
// on the machine.
constexpr double kGoalMs = 2960.0 / 60.0;
constexpr double kGoalRatio = 20.0;  // rendering and writing, against writing the same bytes

void write_bytes(const std::string& path, const std::string& bytes) {
  std::ofstream(path, std::ios::binary).write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
}

}  // namespace

std::vector<Figure> benchmark_report(int rounds, const std::string& folder, const ReportSizes& sizes) {
  const analysis::Dataset dataset = synthetic_dataset(sizes.side, sizes.side, sizes.repeats);
  db::RunStore store = db::RunStore::open(folder + "/report.db", db::Durability::kNormal);
  analysis::ReportInput input;
  const std::int64_t run = store_run(store, dataset);
  input.fit = analysis::fit_array(dataset);
  input.evaluation = analysis::evaluate(dataset, input.fit);
  analysis::Runs runs(store);
  analysis::gather_run(input, runs, run);
  input.uncertainty = analysis::assess_uncertainty(dataset, input.fit, input.run);
  // Fit and comparison come before: only the page's own cost is measured here.
  input.more = analysis::results_of(dataset, input.fit, input.evaluation, nullptr, {});
  const std::string bytes = analysis::render_report(input).html;
  const std::vector<double> taken =
      best_seconds(rounds,
                   {[&] { write_bytes(folder + "/floor.html", bytes); },
                    [&] { write_bytes(folder + "/report.html", analysis::render_report(input).html); }},
                   By::kProcessor);
  return figures_of(ReportTimes{static_cast<double>(bytes.size()), taken[0], taken[1]});
}

std::vector<Figure> figures_of(const ReportTimes& times) {
  FigureList figures("report");
  figures.add("size", 1e-6 * times.bytes, "MB");
  figures.add("write_alone", 1e3 * times.write_s, "ms");
  figures.add_at_most("rendered_and_written", 1e3 * times.rendered_s, kGoalMs, "ms");
  figures.add_at_most("over_write_alone", times.rendered_s / times.write_s, kGoalRatio, "x");
  return figures.take();
}

}  // namespace tactbench::bench
