#include "tests/benchmarks/study/fixed.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <random>
#include <vector>

#include "analysis/dataset.h"
#include "analysis/export/quantise.h"
#include "analysis/identify/sensor_model.h"
#include "analysis/identify/stored/model_document.h"
#include "analysis/scanner_scale.h"
#include "bench/simulation/counter_noise.h"
#include "db/run_store.h"

namespace tactbench::bench {

std::string study_fixed(const FixedStudyOptions& options) {
  using namespace analysis;
  const SensorModel model = analysis::load_model(options.model, nullptr);
  const db::RunStore store = db::RunStore::open_read_only(options.store);
  const Dataset data = load_dataset(store, options.run);
  const double per_count = volts_per_count(store.run(options.run)),
               noisier = std::sqrt(static_cast<double>(model.scans));
  const auto fixed =
      std::make_shared<const FixedModel>(quantised(model, {per_count, options.rate_hz, 1, 0.0, options.conditioned_s}));
  const double sign = model.falling ? -1.0 : 1.0;
  std::vector<const Sample*> samples;
  std::vector<const double*> volts;
  for (const SequenceData& sequence : data.sequences)
    for (const Repeat& repeat : sequence.repeats)
      for (std::size_t i = 0; i < repeat.steps.size(); ++i) {
        samples.push_back(&repeat.steps[i]);
        volts.push_back(&repeat.volts[i * static_cast<std::size_t>(data.taxels())]);
      }
  double by_doubles = 0.0, by_integers = 0.0;
  std::vector<float> apart;
  for (std::size_t t = 0; t < model.array().size(); t += static_cast<std::size_t>(options.every)) {
    const ModelTaxel& taxel = model.array()[t];
    if (!taxel.fitted()) continue;
    const auto stream = compensator_of(model, taxel, noisier);
    stream->work(options.conditioned_s);
    FixedTaxel integers(fixed, t);
    std::mt19937 random(static_cast<unsigned>(hash_of(options.seed, 701, t)));
    std::normal_distribution<double> noise(0.0, noisier * taxel.noise);
    std::size_t j = 0;
    for (double now = samples.front()->time_s; now < samples.back()->time_s; now += 1.0 / options.rate_hz) {
      while (j + 2 < samples.size() && now > samples[j + 1]->time_s) ++j;
      const double share = (now - samples[j]->time_s) / (samples[j + 1]->time_s - samples[j]->time_s);
      const double truth = std::lerp(samples[j]->reference_psi, samples[j + 1]->reference_psi, share);
      const std::uint16_t count = count_of(*fixed, std::lerp(volts[j][t], volts[j + 1][t], share) + noise(random));
      const double reference = stream->step(sign * per_count * count, 1.0 / options.rate_hz).pressure_psi;
      const double pressure = fixed->pressure(integers.step(count).pressure);
      by_doubles += std::abs(reference - truth);
      by_integers += std::abs(pressure - truth);
      apart.push_back(static_cast<float>(std::abs(pressure - reference)));
    }
  }
  std::ranges::sort(apart);
  const auto count = static_cast<double>(apart.size()), range = fixed->per_pressure * fixed->highest;
  const auto at = [&](double share) {
    return 100.0 * static_cast<double>(apart[static_cast<std::size_t>(share * (count - 1.0))]) / range;
  };
  const auto far =
      static_cast<double>(apart.end() - std::ranges::upper_bound(apart, static_cast<float>(0.003 * range)));
  return fmt::format(
      "| {} of run {}, {:g} frames/s | {:.3f} | {:.3f} | {:.4f} | {:.3f} | {:.2f} | {:.2f} | {:.1f} | {:.2f} |\n",
      model.model, options.run, options.rate_hz, by_doubles / count, by_integers / count, by_integers / by_doubles,
      at(0.5), at(0.9), at(0.99), at(0.999), 100.0 * far / count);
}

}  // namespace tactbench::bench
