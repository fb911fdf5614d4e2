#include "bench/reporting/report_budget.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "analysis/counted.h"
#include "bench/common/utc.h"
#include "bench/config/config.h"
#include "bench/reporting/report_results.h"
#include "bench/run/run_record.h"

namespace tactbench::bench {

namespace {

constexpr double kSameStateSeconds = 86400.0;
constexpr double kStoredDigitC = 0.001;  // readings are stored with three decimals

// Runs without a typed role, each once, the report's own left out.
std::vector<std::int64_t> plain_runs(const analysis::ReportInput& input, std::vector<std::int64_t> runs,
                                     const std::vector<std::string>& studies) {
  std::vector<std::int64_t> turned_or_mounted = {input.run.run};
  for (const StudyRun& study : study_runs_of(studies)) {
    if (study.role.empty())
      runs.push_back(study.run);
    else
      turned_or_mounted.push_back(study.run);
  }
  std::vector<std::int64_t> plain;
  for (const std::int64_t run : runs)
    if (std::ranges::find(turned_or_mounted, run) == turned_or_mounted.end() &&
        std::ranges::find(plain, run) == plain.end())
      plain.push_back(run);
  return plain;
}

// Only runs in the chamber; a run under an indenter has no frames at a pressure level.
std::vector<analysis::Dataset> datasets_of(analysis::Runs& runs, const std::vector<std::int64_t>& numbers) {
  std::vector<analysis::Dataset> datasets;
  for (const std::int64_t run : numbers)
    if (runs.press_runs(run).empty()) datasets.push_back(runs.dataset(run));
  return datasets;
}

analysis::TemperatureEffect temperature_of(analysis::Runs& runs, const analysis::ReportInput& input,
                                           const analysis::Dataset& calibration,
                                           const std::vector<analysis::Dataset>& others) {
  std::vector<analysis::Dataset> same_state;
  std::string apart;
  for (const analysis::Dataset& other : others) {
    const std::string why = other_state(input.run, runs.record(other.run));
    if (why.empty()) {
      same_state.push_back(other);
    } else if (analysis::at_another_temperature(calibration.temperatures_c, other.temperatures_c)) {
      apart = fmt::format(
          "a run at {:.1f} °C was given, but {}: this effect cannot be separated from that of the temperature",
          analysis::mean_temperature_c(other), why);
    }
  }
  analysis::TemperatureEffect effect = analysis::temperature_effect_of(
      calibration, same_state, input.fit, thermometer_step_c(input.run),
      analysis::instrument_uncertainty(input.run, "temperature_c", input.laboratory.instruments).u());
  if (!effect.assessed() && !apart.empty()) effect.not_assessed = apart;
  return effect;
}

// A held-out run is evidence for the one difference between its state and the calibration's. A run on another day may
// also be warmer, which is normal. A re-mounted run in another state is evidence for neither.
void add_history_run(const db::RunRecord& calibration_record, const db::RunRecord& record,
                     const analysis::Dataset& calibration, const analysis::Dataset& run, analysis::HistoryRuns& out) {
  const bool warm = temperature_differs(calibration_record, record, calibration, run);
  const StateChange change = state_change(calibration_record, record);
  if (change.unknown) return;
  if (change.later && !change.mounted) out.later.push_back(&run);
  if (change.mounted && !change.later && !warm) out.mounted.push_back(&run);
  if (!change.any()) (warm ? out.warm : out.same).push_back(&run);
}

analysis::HistoryRuns history_runs_of(analysis::Runs& runs, const analysis::ReportInput& input,
                                      const std::vector<std::int64_t>& plain, const std::vector<std::string>& studies) {
  std::vector<std::int64_t> held_out;
  for (const analysis::HeldOut& each : input.held_out) held_out.push_back(each.run.run);
  analysis::HistoryRuns out = held_out_histories(runs, input.run.run, held_out);
  for (const StudyRun& study : study_runs_of(studies))
    if (study.role == "mount") out.mounted.push_back(&runs.dataset(study.run));
  for (const std::int64_t run : plain)
    if (runs.press_runs(run).empty() && !state_change(input.run, runs.record(run)).any())
      out.paced.push_back(&runs.dataset(run));
  return out;
}

}  // namespace

analysis::HistoryRuns held_out_histories(analysis::Runs& runs, std::int64_t calibration,
                                         const std::vector<std::int64_t>& held_out) {
  analysis::HistoryRuns out;
  for (const std::int64_t run : held_out)
    if (run != calibration && runs.press_runs(run).empty())
      add_history_run(runs.record(calibration), runs.record(run), runs.dataset(calibration), runs.dataset(run), out);
  return out;
}

namespace {

// Adds the budget rows of re-mounting, common to all taxels and per taxel: the sensor is calibrated in one mount and
// used in another, so that a reading errs by the difference of two mounts, sqrt(2) times the variation of one mount.
// Adds nothing if mounts were not assessed.
void add_mounts(const analysis::Remount& found, analysis::UncertaintyInputs& inputs) {
  if (!found.assessed()) return;
  const auto between_two = [](double share, int degrees) {
    return analysis::GivenUncertainty{0.0, std::numbers::sqrt2 * share, double(degrees),
                                      "runs of the re-mounted sensor"};
  };
  inputs.mounting = between_two(found.common_share, found.degrees);
  inputs.mounting_per_taxel = between_two(found.per_taxel_share, found.per_taxel_degrees);
}

}  // namespace

analysis::UncertaintyInputs budget_inputs(analysis::Runs& runs, const analysis::ReportInput& input,
                                          const std::vector<std::int64_t>& further,
                                          const std::vector<std::string>& studies) {
  const analysis::Studies& found = input.more.studies;
  analysis::UncertaintyInputs inputs;
  inputs.notes = input.laboratory.instruments;
  if (found.uniformity.assessed())
    inputs.uniformity = {found.uniformity.u_offset_psi, found.uniformity.u_share, found.uniformity.degrees,
                         "runs of the sensor turned in the chamber"};
  add_mounts(found.remount, inputs);
  const analysis::Dataset& calibration = runs.dataset(input.run.run);
  std::vector<analysis::Dataset> datasets = datasets_of(runs, plain_runs(input, further, studies));
  inputs.temperature = temperature_of(runs, input, calibration, datasets);
  inputs.history = history_runs_of(runs, input, plain_runs(input, further, studies), studies);
  datasets.push_back(calibration);  // it may include holds
  inputs.creep = analysis::creep_effect_of(calibration, datasets, input.fit);
  return inputs;
}

StateChange state_change(const db::RunRecord& run, const db::RunRecord& other) {
  StateChange change;
  const double apart =
      seconds_between(run.started_utc, other.started_utc) + seconds_between(other.started_utc, run.started_utc);
  if (apart > kSameStateSeconds) {
    change.later = true;
    change.text =
        fmt::format("it was made {} apart from this one", analysis::counted(std::lround(apart / 86400.0), "day"));
  }
  if (run.origin != "simulated") return change;
  const auto add = [&](bool StateChange::*what, const std::string& text) {
    change.*what = true;
    if (change.text.empty()) change.text = text;
  };
  // For a simulated sensor the configuration states these facts.
  const std::optional<BenchConfig> ours = stored_bench(run), theirs = stored_bench(other);
  if (!ours || !theirs || !ours->simulation || !theirs->simulation) {
    add(&StateChange::unknown, "its bench file, which states mount and age, can no longer be read");
    return change;
  }
  const SpecimenOptions &a = ours->simulation->plant.specimen, &b = theirs->simulation->plant.specimen;
  if (a.kind != b.kind) add(&StateChange::unknown, "its simulated sensor is another specimen");
  if (a.age_months != b.age_months)
    add(&StateChange::later,
        std::abs(a.age_months - b.age_months) == 1.0
            ? std::string("the sensor's age differs by a month")
            : fmt::format("the sensor's age differs by {:g} months", std::abs(a.age_months - b.age_months)));
  if (a.mount_seed != b.mount_seed || a.mount_turn != b.mount_turn || a.edge_outside_lines != b.edge_outside_lines ||
      a.edge_outside != b.edge_outside)
    add(&StateChange::mounted, "the sensor was re-mounted");
  return change;
}

bool temperature_differs(const db::RunRecord& run, const db::RunRecord& other, const analysis::Dataset& ours,
                         const analysis::Dataset& theirs) {
  if (analysis::at_another_temperature(ours.temperatures_c, theirs.temperatures_c)) return true;
  if (run.origin != "simulated") return false;
  const std::optional<BenchConfig> one = stored_bench(run), two = stored_bench(other);
  return one && two && one->simulation && two->simulation &&
         std::abs(one->simulation->plant.specimen.temperature_c - two->simulation->plant.specimen.temperature_c) >=
             analysis::kOtherTemperatureK;
}

std::string other_state(const db::RunRecord& run, const db::RunRecord& other) { return state_change(run, other).text; }

double thermometer_step_c(const db::RunRecord& run) {
  const std::optional<BenchConfig> bench = stored_bench(run);
  double step = kStoredDigitC;
  if (!bench) return step;
  for (const EnvironmentSensor& sensor : bench->environment) {
    const devices::LinearScale& scale = sensor.place.scale;
    if (sensor.quantity != "temperature_c" || sensor.place.format.type == devices::RegisterType::kF32 ||
        scale.raw_high == scale.raw_low)
      continue;
    step = std::max(step, std::abs((scale.high - scale.low) / (scale.raw_high - scale.raw_low)));
  }
  return step;
}

}  // namespace tactbench::bench
