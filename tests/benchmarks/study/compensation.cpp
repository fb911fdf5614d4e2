#include "tests/benchmarks/study/compensation.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <map>
#include <memory>
#include <set>
#include <stdexcept>

#include "analysis/error.h"
#include "analysis/identify/dynamic/dynamic_fit.h"
#include "analysis/identify/sensor_model.h"
#include "analysis/workers.h"
#include "bench/cli/calibrate/calibration.h"
#include "bench/simulation/counter_noise.h"
#include "tests/benchmarks/study/draw_seed.h"
#include "tests/benchmarks/study/histories.h"

namespace tactbench::bench {

namespace {

using namespace analysis;

constexpr double kBinPsi = 0.02;  // of the histogram
constexpr std::size_t kBins = 5000;
enum DrawStream : std::uint64_t { kSensorStream = 301, kKindStream = 401, kRunStream = 501 };

// Converts a taxel's outputs into pressures. A scan has more noise than the mean of those that a frame has.
std::unique_ptr<Compensator> stream_of(const SensorModel& model, const ModelTaxel& taxel) {
  return compensator_of(model, taxel, std::sqrt(static_cast<double>(model.scans)));
}

std::vector<std::string> split(const std::string& text, char at) {
  std::vector<std::string> parts = {""};
  for (const char letter : text) letter == at ? parts.emplace_back() : parts.back() += letter;
  return parts;
}

// The route that `calibrate` goes first; it names no runs of lag and creep.
std::vector<Route> routes_of(const CompensationOptions& options) {
  std::vector<Route> routes = {{"default", {{CalibrateOptions().recipes, {}}}}};
  if (options.routes.empty()) {
    routes.push_back(route_of("production, rate, creep=production:rate:creep-levels"));
    routes.push_back(route_of("Table 1=descending+ascending"));
  }
  for (const std::string& text : options.routes) routes.push_back(route_of(text));
  return routes;
}

std::string key_of(const SimulatedRun& run) { return fmt::format("{} {}", run.recipes, run.set); }

// Runs and models of one sensor, made once however many routes want them.
class StudiedSensor {
 public:
  StudiedSensor(const SimulatedSensor& sensor, std::uint64_t seed, const std::vector<std::size_t>& taxels,
                const std::string& folder)
      : sensor_(sensor),
        seed_(seed),
        taxels_(taxels),
        store_(db::RunStore::open(fmt::format("{}/{}-{}.db", folder, keyword_of(sensor.kind), sensor.seed),
                                  db::Durability::kNormal)) {}

  const KnownRun& run(const SimulatedRun& made) {
    const auto found = runs_.find(key_of(made));
    if (found != runs_.end()) return found->second;
    const auto noise_seed = static_cast<unsigned>(hash_of(seed_, kRunStream, runs_.size()) % 1'000'000'000);
    return runs_.emplace(key_of(made), simulate_run(made, sensor_, noise_seed, store_)).first->second;
  }

  // Nothing where the model cannot be fitted to what the route measured.
  std::optional<SensorModel> fit(const std::string& name, const Route& route) {
    const Dataset& fitted = run(route.runs.front()).data;
    try {
      if (name != kDynamicModel) return fit_models(name, some_taxels(histories_of(fitted)), {}, {});
      if (route.runs.size() == 1) return fit_dynamic_single_run(fitted);
      return fit_dynamic(fitted, run(route.runs[1]).data, run(route.runs.back()).data);
    } catch (const AnalysisError& error) {
      fmt::print(stderr, "{}: no {}: {}\n", route.name, name, error.what());
      return std::nullopt;
    }
  }

  double minutes(const Route& route) {
    double sum = 0.0;
    for (const SimulatedRun& made : route.runs) sum += run(made).process_s / 60.0;
    return sum;
  }

  [[nodiscard]] Recording record(const HistoryKind& kind, std::uint64_t draw) const {
    const BenchConfig bench = simulated_request({{}, kind.set}, sensor_, 1).bench;
    return bench::record(kind, bench.simulation->plant, hash_of(draw, sensor_.seed, 0), taxels_);
  }

 private:
  [[nodiscard]] Histories some_taxels(Histories histories) const {
    std::erase_if(histories.taxels, [&](const TaxelHistories& taxel) {
      return taxel.taxel == kMeanTaxel || !std::ranges::binary_search(taxels_, static_cast<std::size_t>(taxel.taxel));
    });
    return histories;
  }

  SimulatedSensor sensor_;
  std::uint64_t seed_;
  const std::vector<std::size_t>& taxels_;
  db::RunStore store_;
  std::map<std::string, KnownRun> runs_;
};

void add_errors(const SensorModel& model, const HistoryKind& kind, const Recording& recording,
                const std::vector<std::size_t>& taxels, StudiedErrors& errors) {
  for (std::size_t k = 0; k < taxels.size(); ++k) {
    const ModelTaxel& taxel = model.taxel(static_cast<int>(taxels[k]));
    if (!taxel.fitted()) continue;
    const auto stream = stream_of(model, taxel);
    kind.unknown_start ? stream->start(Start::kUnknown) : stream->work(recording.worked_s);
    for (std::size_t i = 0; i < recording.psi.size(); ++i) {
      const Compensated now = stream->step(recording.volts[i * taxels.size() + k], recording.seconds[i]);
      errors.add(std::abs(now.pressure_psi - recording.psi[i]), now);
    }
  }
}

// From edge to edge, not along a column.
std::vector<std::size_t> every_so_many(int every, const SimulatedSensor& sensor) {
  const BenchConfig bench = simulated_request({{}, {}}, sensor, 1).bench;
  std::vector<std::size_t> taxels;
  for (int i = 0; i * every + i % every < bench.scanner.rows * bench.scanner.columns; ++i)
    taxels.push_back(static_cast<std::size_t>(i * every + i % every));
  return taxels;
}

}  // namespace

void StudiedErrors::add(double error, const Compensated& now) {
  const double width = 2.0 * now.uncertainty_psi;
  error_.add(error);
  covered_ += error <= width ? 1.0 : 0.0;
  if (std::isfinite(width)) {
    width_ += width;
    stated_ += 1.0;
  }
  unknown_ += now.unknown ? 1.0 : 0.0;
  flat_ += now.flat ? 1.0 : 0.0;
  out_of_range_ += now.out_of_range ? 1.0 : 0.0;
  if (histogram_.empty()) histogram_.resize(kBins);
  ++histogram_[std::min(kBins - 1, static_cast<std::size_t>(error / kBinPsi))];
}

double StudiedErrors::quantile(double share) const {
  double left = share * error_.samples;
  for (std::size_t bin = 0; bin < histogram_.size(); ++bin)
    if ((left -= histogram_[bin]) <= 0.0) return (static_cast<double>(bin) + 1.0) * kBinPsi;
  return error_.max;
}

double RouteErrors::worst() const {
  double most = 0.0;
  for (std::size_t k = 0; k < kinds.size(); ++k)
    if (history_kinds()[k].known_here()) most = std::max(most, kinds[k].error().mean());
  return most;
}

double RouteErrors::mean() const {
  double sum = 0.0;
  for (const StudiedErrors& kind : kinds) sum += kind.error().mean() / static_cast<double>(kinds.size());
  return sum;
}

Route route_of(const std::string& text) {
  const std::size_t named = text.find('=');
  if (named == std::string::npos || named == 0)
    throw std::invalid_argument("'" + text + "' is no route: NAME=RECIPE+RECIPE[:RATE[:CREEP]][,KEY=VALUE...]");
  std::vector<std::string> settings = split(text.substr(named + 1), ',');
  Route route{text.substr(0, named), {}};
  for (const std::string& recipes : split(settings.front(), ':')) route.runs.push_back({split(recipes, '+'), {}});
  route.runs.front().set.assign(settings.begin() + 1, settings.end());
  return route;
}

namespace {

// Which errors of `study` are of these; new where there are none yet.
std::size_t place_of(CompensationStudy& study, const std::string& specimen, const Route& route,
                     const std::string& model) {
  for (std::size_t at = 0; at < study.errors.size(); ++at) {
    const RouteErrors& errors = study.errors[at];
    if (errors.specimen == specimen && errors.route == route.name && errors.model == model) return at;
  }
  study.errors.push_back({specimen, route.name, model, 0, 0.0, std::vector<StudiedErrors>(history_kinds().size())});
  return study.errors.size() - 1;
}

void add_sensor(const SimulatedSensor& sensor, const CompensationOptions& options, std::uint64_t seed,
                const std::string& folder, CompensationStudy& study) {
  const std::vector<std::size_t> taxels = every_so_many(options.every, sensor);
  StudiedSensor studied(sensor, seed, taxels, folder);
  std::vector<std::pair<std::size_t, SensorModel>> models;  // and where their errors go
  std::set<std::string> made;
  for (const Route& route : routes_of(options))
    for (const std::string& name : options.models) {
      // Only the dynamic model makes something of further runs.
      std::string what = name + key_of(route.runs.front());
      for (std::size_t i = 1; i < route.runs.size() && name == kDynamicModel; ++i) what += key_of(route.runs[i]);
      if (!made.insert(what).second) continue;
      std::optional<SensorModel> model = studied.fit(name, route);
      if (!model) continue;
      const std::size_t place = place_of(study, keyword_of(sensor.kind), route, name);
      study.errors[place].minutes = studied.minutes(route);
      study.errors[place].taxels += static_cast<int>(std::ranges::count_if(
          taxels, [&](std::size_t taxel) { return model->taxel(static_cast<int>(taxel)).fitted(); }));
      models.emplace_back(place, std::move(*model));
    }
  const std::vector<HistoryKind>& kinds = history_kinds();
  for_each_index(kinds.size(), 0, [&](std::size_t k) {
    const Recording recording = studied.record(kinds[k], study.draws[k]);
    for (const auto& [place, model] : models)
      add_errors(model, kinds[k], recording, taxels, study.errors[place].kinds[k]);
  });
}

}  // namespace

CompensationStudy study_compensation(const CompensationOptions& options, const std::string& folder) {
  const auto [seed, commit] = draw_seed(options.seed);
  CompensationStudy study{fmt::format("{:016x}", seed), commit, {}, {}, {}};
  for (std::size_t k = 0; k < history_kinds().size(); ++k)
    study.draws.push_back(hash_of(seed, kKindStream, k) % 2'000'000'000);
  const std::vector<std::string> words = specimen_kind_names();
  for (std::size_t word = 0; word < words.size(); ++word) {
    if (!options.specimens.empty() && std::ranges::find(options.specimens, words[word]) == options.specimens.end())
      continue;
    std::vector<unsigned> seeds = options.sensor_seeds;
    for (std::uint64_t n = 0; options.sensor_seeds.empty() && n < static_cast<std::uint64_t>(options.sensors); ++n)
      seeds.push_back(static_cast<unsigned>(1 + hash_of(seed, kSensorStream + word, n) % 999'999));
    study.sensors.push_back({words[word], seeds});
    for (const unsigned sensor_seed : seeds) {
      const auto begun = std::chrono::steady_clock::now();
      add_sensor({static_cast<SpecimenKind>(word), sensor_seed}, options, seed, folder, study);
      fmt::print(stderr, "{} {}: {:.0f} s\n", words[word], sensor_seed,
                 std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count());
    }
  }
  return study;
}

}  // namespace tactbench::bench
