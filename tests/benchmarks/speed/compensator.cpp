// Frames of corrected pressures: ELAM's compensator and the dynamic one, by vector level, beside a bare scalar form,
// and a pass that only scales counts.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "analysis/compensate/dynamic_frame_compensator.h"
#include "analysis/compensate/frame_compensator.h"
#include "analysis/models/preisach.h"
#include "tests/benchmarks/speed/figures.h"
#include "tests/benchmarks/speed/synthetic_array.h"

namespace tactbench::speed {
namespace {

using namespace analysis;

constexpr std::size_t kTaxels = 256, kSlowFrames = 20000, kTurningFrames = 1000, kGrowthFrames = 1500;
constexpr double kVoltsPerCount = 5.0 / 65536.0, kNoise = 0.004;
constexpr double kTurns[] = {0.0, 60.0, 10.0, 50.0, 0.0, 0.0};  // psi, of slow frames

// Counts of frames x taxels. Slow: all taxels in phase along kTurns, 4 mV of noise. Turning: drawn anew for each frame
// and taxel, so that two thirds of the taxels turn in each frame.
template <class Setup>
struct Stream {
  Setup setup;
  std::vector<std::uint16_t> counts;
  [[nodiscard]] std::size_t width() const { return setup.taxels.size(); }
  [[nodiscard]] std::size_t frames() const { return counts.size() / width(); }
  [[nodiscard]] std::span<const std::uint16_t> frame(std::size_t f) const {
    return std::span(counts).subspan(f * width(), width());
  }
};
struct ElamStream : Stream<FrameSetup> {
  std::vector<ElamModel> models;
};
using DynamicStream = Stream<DynamicSetup>;

std::uint16_t counts_of(double volts) {
  return static_cast<std::uint16_t>(std::clamp(std::lround(volts / kVoltsPerCount), 0L, 65535L));
}

// `output` of taxel and pressure, without noise.
template <class Output>
std::vector<std::uint16_t> slow_counts(Output output) {
  std::mt19937 random(7);
  std::normal_distribution<double> noise(0.0, kNoise);
  std::vector<std::uint16_t> counts;
  for (std::size_t f = 0; f < kSlowFrames; ++f) {
    const double phase = 4.0 * static_cast<double>(f) / kSlowFrames;
    const auto leg = static_cast<std::size_t>(phase);
    const double x = kTurns[leg] + (kTurns[leg + 1] - kTurns[leg]) * (phase - static_cast<double>(leg));
    for (std::size_t t = 0; t < kTaxels; ++t) counts.push_back(counts_of(output(t, x) + noise(random)));
  }
  return counts;
}

ElamStream elam_taxels() {
  ElamStream stream;
  std::mt19937 random(5);
  stream.setup.volts_per_count = kVoltsPerCount;
  stream.setup.start_unknown = false;
  for (std::size_t t = 0; t < kTaxels; ++t) {
    const ElamModel model = taxel_like_the_paper(random);
    const auto x = model.ascending.x(), up = model.ascending.y(), down = model.descending.y();
    stream.setup.pressure_psi.assign(x.begin(), x.end());
    stream.setup.taxels.push_back({true,
                                   {up.begin(), up.end()},
                                   {down.begin(), down.end()},
                                   model.parameters,
                                   kNoise,
                                   false,
                                   std::vector<double>(40, 0.5)});
    stream.models.push_back(model);
  }
  return stream;
}

const ElamStream& elam_slow() {
  static const ElamStream made = [] {
    ElamStream stream = elam_taxels();
    std::vector<ElamCurve> curves;
    for (const ElamModel& model : stream.models) curves.emplace_back(model, true, model.x0(), model.y0());
    std::vector<double> last(kTaxels, 0.0);
    stream.counts = slow_counts([&](std::size_t t, double x) {
      const bool up = x > last[t];
      if (x != last[t] && up != curves[t].ascending())
        curves[t] = ElamCurve(stream.models[t], up, last[t], curves[t].output(last[t]));
      last[t] = x;
      return curves[t].output(x);
    });
    return stream;
  }();
  return made;
}

const ElamStream& elam_turning() {
  static const ElamStream made = [] {
    ElamStream stream = elam_taxels();
    std::mt19937 random(9);
    std::uniform_real_distribution<double> uniform;
    for (std::size_t f = 0; f < kTurningFrames; ++f)
      for (const ElamModel& model : stream.models)
        stream.counts.push_back(counts_of(model.y0() + (model.yu() - model.y0()) * uniform(random)));
    return stream;
  }();
  return made;
}

// The slow array laid down `times` times.
ElamStream tiled(std::size_t times) {
  ElamStream stream = elam_slow();
  stream.counts.clear();
  for (std::size_t i = 1; i < times; ++i)
    stream.setup.taxels.insert(stream.setup.taxels.end(), elam_slow().setup.taxels.begin(),
                               elam_slow().setup.taxels.end());
  for (std::size_t f = 0; f < kGrowthFrames; ++f)
    for (std::size_t i = 0; i < times; ++i)
      stream.counts.insert(stream.counts.end(), elam_slow().frame(f).begin(), elam_slow().frame(f).end());
  return stream;
}

// Films of Preisach densities that fall off from the diagonal, in 20 intervals up to 60 psi, with a divider of about 4
// V, lag and creep.
DynamicStream dynamic_taxels(std::vector<PreisachModel>& films) {
  DynamicStream stream;
  std::mt19937 random(5);
  std::uniform_real_distribution<double> uniform;
  constexpr std::size_t n = 20;
  stream.setup.x_high = 60.0;
  stream.setup.intervals = n;
  stream.setup.volts_per_count = kVoltsPerCount;
  stream.setup.start_unknown = false;
  stream.setup.dynamics.creep_share = {0.015, 0.012, 0.01};
  for (std::size_t t = 0; t < kTaxels; ++t) {
    std::vector<double> weights;
    double sum = 0.0;
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t j = 0; j <= i; ++j) {
        weights.push_back((0.2 + uniform(random)) * std::exp(-8.0 * static_cast<double>(i - j) / n));
        sum += weights.back();
      }
    for (double& weight : weights) weight *= 20.0 / sum;
    films.emplace_back(0.0, 60.0, 0.0, weights);
    DynamicTaxel taxel;
    taxel.usable = true;
    taxel.divider = {0.02, 1.0 / (3.9 + 0.3 * uniform(random))};
    for (std::size_t i = 0; i <= n; ++i)
      for (std::size_t j = 0; j <= i; ++j)
        taxel.everett.push_back(
            films.back().everett(60.0 * static_cast<double>(i) / n, 60.0 * static_cast<double>(j) / n));
    taxel.lag_share = 0.07;
    taxel.noise_v = kNoise;
    stream.setup.taxels.push_back(std::move(taxel));
  }
  return stream;
}

const DynamicStream& dynamic_slow() {  // its outputs are without lag and creep
  static const DynamicStream made = [] {
    std::vector<PreisachModel> films;
    DynamicStream stream = dynamic_taxels(films);
    std::vector<std::unique_ptr<ModelState>> states;
    for (const PreisachModel& film : films) states.push_back(film.state());
    stream.counts = slow_counts([&](std::size_t t, double x) {
      states[t]->go(x);
      return stream.setup.taxels[t].divider.output(states[t]->output_at(x));
    });
    return stream;
  }();
  return made;
}

const DynamicStream& dynamic_turning() {
  static const DynamicStream made = [] {
    std::vector<PreisachModel> films;
    DynamicStream stream = dynamic_taxels(films);
    std::mt19937 random(9);
    std::uniform_real_distribution<double> uniform;
    for (std::size_t i = 0; i < kTurningFrames * kTaxels; ++i)
      stream.counts.push_back(counts_of(3.2 * uniform(random)));
    return stream;
  }();
  return made;
}

// What a form of the compensator makes of a frame.
struct Results {
  std::vector<float> pressure, uncertainty;
  std::vector<std::uint16_t> status;
  explicit Results(std::size_t taxels) : pressure(taxels), uncertainty(taxels), status(taxels) {}
};

template <class Act>
void each_frame(benchmark::State& state, std::size_t frames, Act act) {
  std::size_t f = 0;
  for (auto _ : state) {
    act(f);
    f = f + 1 == frames ? 0 : f + 1;
  }
}

template <class Compensator, class Of>
void by_vectors(benchmark::State& state, const Of& stream, Dispatch level) {
  Compensator compensator(stream.setup);
  compensator.set_dispatch(level);
  if constexpr (requires { compensator.set_interval(0.01); }) {
    compensator.set_interval(0.01);
    state.counters["bytes_per_taxel [bytes]"] = static_cast<double>(compensator.bytes_per_taxel());
  }
  Results results(stream.width());
  each_frame(state, stream.frames(), [&](std::size_t f) {
    compensator.frame(stream.frame(f), {results.pressure, results.uncertainty, results.status});
    benchmark::DoNotOptimize(results.pressure.data());
  });
}

// The simplest form: a fixed dead band, a search in the curve, no flags, no uncertainty, no averaging.
void bare(benchmark::State& state, const ElamStream& stream) {
  struct Taxel {
    ElamCurve curve;
    double extreme;
  };
  std::vector<Taxel> taxels;
  for (const ElamModel& model : stream.models) taxels.push_back({{model, true, model.x0(), model.y0()}, model.y0()});
  each_frame(state, stream.frames(), [&](std::size_t f) {
    for (std::size_t t = 0; t < taxels.size(); ++t) {
      Taxel& own = taxels[t];
      const double volts = stream.frame(f)[t] * kVoltsPerCount;
      const double ahead = own.curve.ascending() ? volts - own.extreme : own.extreme - volts;
      if (ahead < -6.0 * kNoise)
        own.curve = ElamCurve(stream.models[t], !own.curve.ascending(), own.curve.input(own.extreme), own.extreme);
      if (ahead < -6.0 * kNoise || ahead >= 0.0) own.extreme = volts;
      benchmark::DoNotOptimize(own.curve.input(volts));
    }
  });
}

void scale(benchmark::State& state) {
  const ElamStream& stream = elam_slow();
  std::vector<float> to(stream.width());
  each_frame(state, stream.frames(), [&](std::size_t f) {
    const std::span<const std::uint16_t> counts = stream.frame(f);
    for (std::size_t t = 0; t < counts.size(); ++t) to[t] = static_cast<float>(counts[t]) * 1e-3F;
    benchmark::DoNotOptimize(to.data());
    benchmark::ClobberMemory();
  });
}

void growth(benchmark::State& state) {
  by_vectors<FrameCompensator<float>>(state, tiled(static_cast<std::size_t>(state.range(0)) / kTaxels),
                                      best_dispatch());
  state.SetItemsProcessed(state.iterations() * state.range(0));
}

const bool registered = [] {
  const auto add = [](const std::string& name, auto act) {
    benchmark::RegisterBenchmark(("compensate/" + name).c_str(), act)->Unit(benchmark::kMicrosecond);
  };
  add("scale", scale);
  add("slow_bare", [](benchmark::State& state) { bare(state, elam_slow()); });
  add("turning_bare", [](benchmark::State& state) { bare(state, elam_turning()); });
  for (const Dispatch level : {Dispatch::kBase, Dispatch::kAvx2, Dispatch::kAvx512}) {
    if (level > best_dispatch()) continue;
    const std::string word = to_string(level);
    using Elam = FrameCompensator<float>;
    using Dynamic = DynamicFrameCompensator<float>;
    add("slow_" + word, [level](benchmark::State& state) { by_vectors<Elam>(state, elam_slow(), level); });
    add("turning_" + word, [level](benchmark::State& state) { by_vectors<Elam>(state, elam_turning(), level); });
    add("dynamic_slow_" + word,
        [level](benchmark::State& state) { by_vectors<Dynamic>(state, dynamic_slow(), level); });
    add("dynamic_turning_" + word,
        [level](benchmark::State& state) { by_vectors<Dynamic>(state, dynamic_turning(), level); });
  }
  const std::string best = to_string(best_dispatch());
  return declare({{"compensate_speedup_over_bare", "compensate/slow_bare", {"compensate/slow_" + best}, 0.0, 3.0},
                  {"compensate_over_scale_only", "compensate/slow_" + best, {"compensate/scale"}, 25.0},
                  {"compensate_turning_over_bare", "compensate/turning_" + best, {"compensate/turning_bare"}, 2.5}});
}();
BENCHMARK(growth)->Name("compensate/growth_per_taxel")->Arg(256)->Arg(1024)->Arg(4096);

}  // namespace
}  // namespace tactbench::speed
