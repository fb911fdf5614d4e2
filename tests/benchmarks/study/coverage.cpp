#include "tests/benchmarks/study/coverage.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <regex>

#include "analysis/identify/dynamic/dynamic_fit.h"
#include "analysis/report/gather.h"
#include "analysis/statistics/numbers/moments.h"
#include "analysis/statistics/uncertainty/uncertainty.h"
#include "bench/common/output_file.h"
#include "bench/config/config.h"
#include "bench/reporting/report_budget.h"
#include "bench/run/recipe_check.h"
#include "bench/simulation/counter_noise.h"
#include "tests/benchmarks/study/simulated_run.h"

namespace tactbench::bench {

namespace {

using namespace analysis;

enum CoverageStream : std::uint64_t { kArrayStream = 601, kInstrumentStream, kNoiseStream, kHistoryStream };
constexpr std::size_t kEvery = 4;  // taxels whose errors give the half-width

// Of one kind: errors of all sensors for which U is stated, and U of each.
struct Widths {
  std::vector<float> errors, expanded;
};

// The composite recipe with newly drawn histories: every seed=N in it is changed.
std::string drawn_anew(const std::string& recipe, std::uint64_t seed, const std::string& file) {
  std::string text = read_recipe_file(recipe).text, made;
  static const std::regex kSeed("seed=[0-9]+");
  std::uint64_t drawn = 0;
  auto from = text.cbegin();
  for (std::sregex_iterator found(text.begin(), text.end(), kSeed), end; found != end; ++found) {
    made.append(from, (*found)[0].first);
    made += fmt::format("seed={}", hash_of(seed, kHistoryStream, drawn++) % 2'000'000'000);
    from = (*found)[0].second;
  }
  made.append(from, text.cend());
  write_output(file, made, true);
  return file;
}

class SensorStudy {
 public:
  SensorStudy(const SimulatedSensor& sensor, const CoverageOptions& options, const std::string& folder)
      : sensor_(sensor),
        options_(options),
        seed_(hash_of(options.seed, static_cast<std::uint64_t>(sensor.kind), sensor.seed)),
        folder_(folder),
        store_(db::RunStore::open(fmt::format("{}/{}-{}.db", folder, keyword_of(sensor.kind), sensor.seed),
                                  db::Durability::kNormal)),
        runs_(store_) {}

  CoveredSensor carry_out(std::map<UseCondition, Widths>& widths) {
    const KnownRun calibration = run(options_.recipes), verification = run({options_.held_out});
    const SensorModel fit = fit_dynamic_single_run(calibration.data);
    const Uncertainty uncertainty = assessed(calibration.data.run, verification.data.run, fit);
    CoveredSensor out;
    out.seed = sensor_.seed;
    out.minutes = (calibration.process_s + verification.process_s) / 60.0;
    out.reference_off = reference_off(calibration, uncertainty.reference);
    for (std::size_t kind = 0; kind < kHistoryKinds; ++kind) {
      const ConditionUncertainty& stated = uncertainty.condition(static_cast<UseCondition>(kind));
      out.kinds.push_back({stated.condition, stated.not_valid, 0.0, 0.0, stated.factor, stated.median_psi});
    }
    for (int i = 0; i < options_.further; ++i) {
      const std::string recipe = drawn_anew(options_.held_out, hash_of(seed_, kHistoryStream, static_cast<unsigned>(i)),
                                            fmt::format("{}/further-{}-{}.toml", folder_, sensor_.seed, i));
      count(run({recipe}), calibration.data, fit, uncertainty, out, widths);
    }
    return out;
  }

 private:
  // On one rig, whose instruments have errors of their own.
  KnownRun run(const std::vector<std::string>& recipes) {
    const std::uint64_t instruments = 1 + hash_of(seed_, kInstrumentStream, 0) % 1'000'000;
    const auto noise = static_cast<unsigned>(hash_of(seed_, kNoiseStream, made_++) % 1'000'000'000);
    return simulate_run({recipes, {fmt::format("simulation.instrument_seed={}", instruments)}}, sensor_, noise, store_);
  }

  // As the report assesses it.
  Uncertainty assessed(std::int64_t calibration, std::int64_t verification, const SensorModel& fit) {
    ReportInput input;
    input.run = runs_.record(calibration);
    input.fit = fit;
    input.held_out.push_back({"", runs_.record(verification), {}});
    return assess_uncertainty(runs_.dataset(calibration), fit, input.run, budget_inputs(runs_, input, {}, {}));
  }

  static double reference_off(const KnownRun& run, const ReferenceUncertainty& reference) {
    double sum = 0.0, frames = 0.0;
    std::size_t at = 0;
    for (const SequenceData& sequence : run.data.sequences)
      for (const Repeat& repeat : sequence.repeats)
        for (const Sample& sample : repeat.steps) {
          const double truth = run.chamber_psi[at++];
          sum += (sample.reference_psi - truth) / reference.combined_u(truth);
          frames += 1.0;
        }
    return sum / frames;
  }

  // The readings of a further run against the pressures that are known and what is stated of them.
  static void count(const KnownRun& run, const Dataset& calibration, const SensorModel& fit,
                    const Uncertainty& uncertainty, CoveredSensor& out, std::map<UseCondition, Widths>& widths) {
    const FrameErrors errors = frame_errors(run.data, fit);
    const std::size_t width = fit.array().size();
    for (const KindHistories& one :
         kind_histories(run.data, errors, calibration, fit.pressure_psi.front(), fit.pressure_psi.back())) {
      const ConditionUncertainty& stated = uncertainty.condition(one.kind);
      if (!stated.valid()) continue;
      CoveredKind& covered = out.kinds[static_cast<std::size_t>(one.kind)];
      for (const std::size_t i : one.history.frames) {
        const FrameErrors::Frame& frame = errors.frames[i];
        for (std::size_t taxel = 0; taxel < width; ++taxel) {
          const double reading = frame.reference_psi + errors.error_psi[i * width + taxel];
          const auto [known, expanded] = reading_uncertainty(stated, taxel, reading, frame.up);
          if (std::isnan(expanded)) continue;
          const double error = std::abs(reading - known - run.chamber_psi[i]);
          covered.inside += error <= expanded ? 1.0 : 0.0;
          covered.readings += 1.0;
          if (taxel % kEvery != 0) continue;
          widths[one.kind].errors.push_back(static_cast<float>(error));
          widths[one.kind].expanded.push_back(static_cast<float>(expanded));
        }
      }
    }
  }

  SimulatedSensor sensor_;
  const CoverageOptions& options_;
  std::uint64_t seed_;
  std::string folder_;
  db::RunStore store_;
  Runs runs_;
  std::uint64_t made_ = 0;
};

double quantile(std::vector<float>& values, double share) {
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size()));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

CoverageOfKind over_sensors(UseCondition kind, const std::vector<CoveredSensor>& sensors, Widths& widths) {
  CoverageOfKind out;
  out.kind = kind;
  out.least = 100.0;
  double inside = 0.0, readings = 0.0;
  for (const CoveredSensor& sensor : sensors) {
    const CoveredKind& own = sensor.kinds[static_cast<std::size_t>(kind)];
    if (!own.not_valid.empty() || !(own.readings > 0.0)) continue;
    ++out.stated;
    out.outside += own.percent() < 90.0 || own.percent() > 99.0 ? 1 : 0;
    out.least = std::min(out.least, own.percent());
    out.most = std::max(out.most, own.percent());
    inside += own.inside;
    readings += own.readings;
  }
  if (out.stated == 0) return out;
  out.percent = 100.0 * inside / readings;
  out.median_u_psi = quantile(widths.expanded, 0.5);
  out.half_width_psi = quantile(widths.errors, 0.95);
  return out;
}

}  // namespace

std::vector<CoverageOfSpecimen> study_coverage(const CoverageOptions& options, const std::string& folder) {
  std::vector<CoverageOfSpecimen> study;
  for (const SpecimenKind specimen : options.specimens) {
    CoverageOfSpecimen out{keyword_of(specimen), {}, {}};
    std::map<UseCondition, Widths> widths;
    const auto stream = kArrayStream + 1000 * static_cast<std::uint64_t>(specimen);
    for (std::uint64_t n = 0; n < static_cast<std::uint64_t>(options.sensors); ++n) {
      const auto seed = static_cast<unsigned>(1 + hash_of(options.seed, stream, n) % 999'999);
      out.sensors.push_back(SensorStudy({specimen, seed}, options, folder).carry_out(widths));
      fmt::print(stderr, "{} {}: {} of {}\n", out.specimen, seed, n + 1, options.sensors);
    }
    for (std::size_t kind = 0; kind < kHistoryKinds; ++kind)
      out.kinds.push_back(
          over_sensors(static_cast<UseCondition>(kind), out.sensors, widths[static_cast<UseCondition>(kind)]));
    study.push_back(std::move(out));
  }
  return study;
}

std::string markdown_of(const std::vector<CoverageOfSpecimen>& study) {
  std::string text =
      "| specimen | kind of history | U stated, sensors | inside U, % | single sensors, % | outside 90 to 99 % | "
      "median U, "
      "psi | half-width of 95 %, psi | U / half-width |\n|---|---|---|---|---|---|---|---|---|\n";
  for (const CoverageOfSpecimen& specimen : study)
    for (const CoverageOfKind& kind : specimen.kinds) {
      text += fmt::format("| {} | {} | {} of {} ", specimen.specimen, analysis::name_of(kind.kind), kind.stated,
                          specimen.sensors.size());
      text += kind.stated == 0 ? std::string("| | | | | | |\n")
                               : fmt::format("| {:.1f} | {:.1f} to {:.1f} | {} | {:.2f} | {:.2f} | {:.2f} |\n",
                                             kind.percent, kind.least, kind.most, kind.outside, kind.median_u_psi,
                                             kind.half_width_psi, kind.median_u_psi / kind.half_width_psi);
    }
  text +=
      "\n| specimen | sensor | reference off, its own u | minutes | inside U, %: full sweeps | reversals | small | "
      "held "
      "|\n|---|---|---|---|---|---|---|---|\n";
  for (const CoverageOfSpecimen& specimen : study)
    for (const CoveredSensor& sensor : specimen.sensors) {
      text += fmt::format("| {} | {} | {:.1f} | {:.1f} ", specimen.specimen, sensor.seed, sensor.reference_off,
                          sensor.minutes);
      for (const CoveredKind& kind : sensor.kinds)
        text += kind.not_valid.empty()
                    ? fmt::format("| {:.1f} (k {:.2f}, U {:.2f}) ", kind.percent(), kind.factor, kind.median_psi)
                    : fmt::format("| {} ", kind.not_valid);
      text += "|\n";
    }
  return text;
}

}  // namespace tactbench::bench
