#include "bench/reporting/report_results.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <optional>
#include <utility>

#include "analysis/identify/sensor_model.h"
#include "analysis/identify/stored/model_document.h"
#include "analysis/report/data/traceability.h"
#include "analysis/statistics/uncertainty/instruments.h"
#include "bench/common/error.h"
#include "bench/config/config.h"
#include "bench/reporting/evidence.h"
#include "bench/reporting/judgement.h"
#include "bench/reporting/sensor_state.h"
#include "bench/reporting/study_roles.h"
#include "sequences/recipe.h"

namespace tactbench::bench {

namespace {

constexpr std::array<const char*, 5> kStudyRoles = {"mount", "0", "90", "180", "270"};

std::optional<sequences::Recipe> recipe_of(const db::SequenceRecord& sequence, std::int64_t run) {
  if (sequence.recipe_toml.empty()) return std::nullopt;
  return sequences::parse_recipe(sequences::TomlDocument::from_text(
      sequence.recipe_toml, fmt::format("recipe '{}' of run {}", sequence.name, run)));
}

bool studies_pace(const sequences::Recipe& recipe) {
  return recipe.kind == sequences::RecipeKind::kLevels &&
         (recipe.dwell_s.size() > 1 || recipe.ramp_psi_per_s.size() > 1 || recipe.frames_per_level > 1);
}

analysis::ArrayGeometry geometry_of(const db::RunRecord& run) {
  if (run.sensor_toml.empty()) return {};
  const SensorType type = parse_sensor_type(run.sensor_toml, fmt::format("sensor type of run {}", run.run));
  return {type.pitch_mm, type.taxel_area_mm2};
}

[[noreturn]] void refuse_own(const StudyRun& study) {
  throw Error("TB-REPORT-STUDY",
              fmt::format("run {} is the run of the report, with which the others are compared", study.run),
              fmt::format("--studies {}{}{}", study.run, study.role.empty() ? "" : ":", study.role),
              "name only the further runs");
}

class StudyGatherer {
 public:
  StudyGatherer(analysis::ReportInput& input, analysis::Runs& runs) : input_(input), runs_(runs) {}

  void take(const StudyRun& study) {
    const bool own = study.run == input_.run.run;
    if (own && study.role == "0") return;  // counted in any case
    if (own && !study.role.empty()) refuse_own(study);
    const db::RunRecord& record = runs_.record(study.run);
    check_role(study, input_.run, record, purpose_of(record));
    if (study.role == "mount") {
      mounts_.push_back({study.run, analysis::sweep_estimates(runs_.dataset(study.run), input_.fit)});
      return;
    }
    if (!study.role.empty()) {
      const int angle = std::stoi(study.role);
      turned_.push_back({study.run, angle, analysis::sweep_estimates(runs_.dataset(study.run), input_.fit)});
      return;
    }
    const bool pressed = take_presses(record);
    const bool paced = take_paces(record);
    if (pressed || paced) return;
    // Plain loops at another temperature serve the temperature study.
    if (analysis::at_another_temperature(runs_.temperatures_c(input_.run.run), runs_.temperatures_c(study.run))) return;
    if (own) refuse_own(study);
    throw Error("TB-REPORT-STUDY", fmt::format("run {} has plain loops, whose purpose is not recorded", study.run),
                fmt::format("--studies {}", study.run),
                fmt::format("{0}:mount if the sensor was re-mounted, {0}:90 if it was turned in the chamber by 90 "
                            "degrees counter-clockwise; a run at another temperature is recognised by its thermometer, "
                            "{1:g} K or more from run {2}; to check models on another run: --held-out {0}",
                            study.run, analysis::kOtherTemperatureK, input_.run.run));
  }

  bool take_presses(const db::RunRecord& record) {
    const std::vector<analysis::PressRun>& stored = runs_.press_runs(record.run);
    for (analysis::PressRun press : stored) {
      for (const db::SequenceRecord& sequence : record.sequences) {
        if (sequence.name != press.sequence) continue;
        if (const auto recipe = recipe_of(sequence, record.run)) press.object = recipe->press.object;
      }
      geometry_ = geometry_of(record);
      presses_.push_back(std::move(press));
    }
    return !stored.empty();
  }

  void finish() {
    analysis::ReportResults& more = input_.more;
    // A registration holds until the sensor is mounted again: the latest one given serves runs without their own.
    std::vector<analysis::MountTransform> mount;
    for (const analysis::PressRun& press : presses_)
      if (!press.mount.empty()) mount = press.mount;
    for (analysis::PressRun& press : presses_) {
      if (press.mount.empty()) press.mount = mount;
      if (press.object == "point") {
        analysis::Crosstalk crosstalk =
            analysis::crosstalk_of(press.run, analysis::point_frames(press), press.rows, press.columns);
        // The touches of a registration are a poor grid: of several runs the one with most positions.
        const analysis::Crosstalk& before = more.studies.crosstalk;
        if (!before.assessed() || crosstalk.positions > before.positions) more.studies.crosstalk = std::move(crosstalk);
      }
      more.contacts.push_back(analysis::contact_result(press, input_.fit, geometry_));
      more.contacts.back().force_traceability =
          analysis::force_traceability(runs_.record(press.run), input_.laboratory.instruments).statement;
      more.contacts.back().force_uncertainty =
          analysis::instrument_uncertainty(runs_.record(press.run), "force sensor", input_.laboratory.instruments);
    }
    if (mounts_.empty() && turned_.empty()) return;
    const analysis::SweepEstimates own = analysis::sweep_estimates(runs_.dataset(input_.run.run), input_.fit);
    if (!mounts_.empty()) {
      mounts_.insert(mounts_.begin(), {input_.run.run, own});
      more.studies.remount = analysis::remount_of(mounts_);
    }
    if (!turned_.empty()) {
      turned_.insert(turned_.begin(), {input_.run.run, 0, own});
      more.studies.uniformity = analysis::uniformity_of(turned_, input_.fit.rows, input_.fit.columns);
    }
  }

 private:
  // A run with plain loops and other recipes, such as `production`, counts as a run of loops.
  static StudyPurpose purpose_of(const db::RunRecord& record) {
    bool plain = record.sequences.empty();
    for (const db::SequenceRecord& sequence : record.sequences) {
      const auto recipe = recipe_of(sequence, record.run);
      if (recipe && recipe->kind == sequences::RecipeKind::kPress) return StudyPurpose::kPresses;
      plain = plain || !recipe || !studies_pace(*recipe);
    }
    return plain ? StudyPurpose::kPlainLoops : StudyPurpose::kPaces;
  }

  bool take_paces(const db::RunRecord& record) {
    if (purpose_of(record) != StudyPurpose::kPaces) return false;
    analysis::RateHold& study = input_.more.studies.rate_hold;
    study.not_assessed.clear();
    for (analysis::RateHoldRun& run : analysis::rate_hold_of(runs_.dataset(record.run), input_.fit))
      study.runs.push_back(std::move(run));
    return true;
  }

  analysis::ReportInput& input_;
  analysis::Runs& runs_;
  std::vector<analysis::MountedRun> mounts_;
  std::vector<analysis::TurnedRun> turned_;
  std::vector<analysis::PressRun> presses_;
  analysis::ArrayGeometry geometry_;
};

}  // namespace

std::vector<StudyRun> study_runs_of(const std::vector<std::string>& words) {
  std::vector<StudyRun> out;
  for (const std::string& word : words) {
    const std::size_t colon = word.find(':');
    const std::string_view number = std::string_view(word).substr(0, colon);
    StudyRun study;
    study.role = colon == std::string::npos ? "" : word.substr(colon + 1);
    const auto [end, error] = std::from_chars(number.data(), number.data() + number.size(), study.run);
    const bool is_number = error == std::errc() && end == number.data() + number.size() && !number.empty();
    const bool is_role = colon == std::string::npos || std::ranges::find(kStudyRoles, study.role) != kStudyRoles.end();
    if (!is_number || !is_role)
      throw Error("TB-USAGE", fmt::format("'{}' is not a run with a role", word), "--studies",
                  "RUN, RUN:mount, RUN:0, RUN:90, RUN:180 or RUN:270");
    const auto same = [&](const StudyRun& other) { return other.run == study.run && other.role == study.role; };
    if (std::ranges::any_of(out, same))
      throw Error("TB-USAGE", fmt::format("'{}' is named twice", word), "--studies",
                  "name each run once: counted twice, it would look like a repetition");
    out.push_back(std::move(study));
  }
  return out;
}

void add_results(analysis::ReportInput& input, analysis::Runs& runs, const ReportExtras& extras) {
  const std::vector<StudyRun> studies = study_runs_of(extras.studies);
  const bool evaluated = !input.evaluation.levels.empty();  // a run under an object has no full loop
  if (input.fit.taxels.empty() || (!evaluated && !extras.previous.empty())) {
    if (studies.empty() && extras.previous.empty()) return;
    throw Error("TB-REPORT-STUDY", "studies and earlier models need models of the report's run",
                fmt::format("run {}", input.run.run), fmt::format("fit it first: tactbench fit {}", input.run.run));
  }
  std::optional<analysis::SensorModel> previous;
  if (!extras.previous.empty()) previous = analysis::load_model(extras.previous, &runs.store());
  if (evaluated && previous)
    input.more.previous = analysis::as_found_with(runs.dataset(input.run.run), input.fit, *previous, extras.previous);
  StudyGatherer gatherer(input, runs);
  (void)gatherer.take_presses(input.run);
  for (const StudyRun& study : studies) gatherer.take(study);
  gatherer.finish();
}

namespace {

bool passed(const db::RunStore& store, std::int64_t run) { return analysis::passes(standing(store, run).verdict); }

// The start of the sensor's newest run before `run` with a passing verdict on it or its models; empty: none.
std::string last_pass_utc(const db::RunStore& store, const db::RunRecord& run) {
  std::string last;
  for (const db::RunRecord& other : store.runs({.sensor_serial = run.sensor_serial}))
    if (other.sensor_serial == run.sensor_serial && other.origin == run.origin &&
        std::pair(other.started_utc, other.run) < std::pair(run.started_utc, run.run) && other.started_utc > last &&
        !other.is_void() && passed(store, other.run))
      last = other.started_utc;
  return last;
}

std::string day_of_utc(const std::string& utc) { return utc.substr(0, std::min<std::size_t>(10, utc.size())); }

}  // namespace

std::string models_before(analysis::Runs& runs, std::int64_t run) {
  const db::RunStore& store = runs.store();
  const db::RunRecord record = runs.record(run);
  std::vector<db::RunRecord> of_sensor = store.runs({.sensor_serial = record.sensor_serial});
  std::erase_if(of_sensor, &db::RunRecord::is_void);
  const std::optional<db::FitRecord> fit = earlier_models(store, of_sensor, record);
  if (!fit) return {};
  const analysis::SensorModel models = analysis::load_fit(*fit);
  const std::vector<std::int64_t> sources = source_runs(store, models);
  if (models.fitted().empty() || std::ranges::find(sources, run) != sources.end()) return {};
  try {
    analysis::check_same_sensor(runs.dataset(run), models);
  } catch (const analysis::AnalysisError&) {
    return {};
  }
  return fmt::format("{}:{}", fit->run, fit->fit);
}

void judge_as_found(analysis::Runs& runs, analysis::ReportInput& input, const std::string& previous,
                    const analysis::Limits& limits) {
  if (!input.more.previous || input.judgement.figures.empty()) return;
  analysis::AsFound& found = *input.more.previous;
  // The earlier models' own run may lie in another store: scatter and budgets are those of this run.
  analysis::SensorModel models = analysis::load_model(previous, &runs.store());
  models.run = input.run.run;
  analysis::Evidence evidence;
  analysis::EvidenceRun& own = evidence.runs.emplace_back();
  own.run = found.evaluation.run;
  own.reference = analysis::reference_uncertainty(input.run, input.laboratory.instruments);
  analysis::ModelRunResults of_models;
  own.figures = judged_figures(runs, models, found.evaluation, limits, own.reference, of_models);
  found.judgement = judge(evidence, limits);
  const auto overall = found.judgement.overall;
  if (overall != analysis::Verdict::kFail && overall != analysis::Verdict::kConditionalFail) return;
  const std::string last = last_pass_utc(runs.store(), input.run);
  found.doubt = last.empty()
                    ? std::string(
                          "As found, the sensor does not conform, and the store has no earlier calibration of it that "
                          "passed: all measurements made with the earlier models are in doubt.")
                    : fmt::format(
                          "As found, the sensor does not conform: measurements made with the earlier models since {}, "
                          "the last calibration of this sensor that passed, are in doubt.",
                          day_of_utc(last));
}

}  // namespace tactbench::bench
