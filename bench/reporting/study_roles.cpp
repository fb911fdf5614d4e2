#include "bench/reporting/study_roles.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>
#include <string_view>

#include "analysis/counted.h"
#include "analysis/pressure_unit.h"
#include "bench/common/error.h"
#include "bench/common/overrides.h"
#include "bench/run/run_record.h"
#include "sequences/recipe.h"

namespace tactbench::bench {

namespace {

struct Recorded {
  std::string value, where;  // "90", "simulation.turned_in_chamber_deg"
};

std::optional<Recorded> metadata_of(const db::RunRecord& run, std::string_view key) {
  for (const std::string& tag : run.tags)
    if (tag.size() > key.size() && tag.starts_with(key) && tag[key.size()] == '=')
      return Recorded{tag.substr(key.size() + 1), fmt::format("its tag {}", tag)};
  return std::nullopt;
}

std::optional<SpecimenOptions> specimen_of(const db::RunRecord& run) {
  if (run.origin != "simulated") return std::nullopt;
  const std::optional<BenchConfig> bench = stored_bench(run);
  if (!bench || !bench->simulation) return std::nullopt;
  return bench->simulation->plant.specimen;
}

std::optional<Recorded> turn_of(const db::RunRecord& run) {
  if (std::optional<Recorded> stated = metadata_of(run, "turned")) return stated;
  const std::optional<SpecimenOptions> specimen = specimen_of(run);
  if (!specimen) return std::nullopt;
  return Recorded{fmt::format("{:g}", specimen->turned_in_chamber_deg),
                  fmt::format("simulation.turned_in_chamber_deg = {:g}", specimen->turned_in_chamber_deg)};
}

std::optional<Recorded> mount_of(const db::RunRecord& run) {
  if (std::optional<Recorded> stated = metadata_of(run, "mount")) return stated;
  const std::optional<SpecimenOptions> specimen = specimen_of(run);
  if (!specimen) return std::nullopt;
  return Recorded{std::to_string(specimen->mount_seed),
                  fmt::format("simulation.mount_seed = {}", specimen->mount_seed)};
}

std::optional<double> degrees_in(const Recorded& recorded) {
  double value = 0.0;
  const char* const end = recorded.value.data() + recorded.value.size();
  const auto [stopped, error] = std::from_chars(recorded.value.data(), end, value);
  return error == std::errc() && stopped == end ? std::optional(value) : std::nullopt;
}

[[noreturn]] void refuse(const StudyRun& study, const std::string& what, const std::string& remedy) {
  throw Error("TB-REPORT-STUDY", what, fmt::format("--studies {}:{}", study.run, study.role), remedy);
}

// Rotation relative to the report's run, 0 to 360 degrees; none if the run does not record it.
std::optional<double> turned_against(const db::RunRecord& own, const Recorded& recorded) {
  const std::optional<double> there = degrees_in(recorded);
  if (!there) return std::nullopt;
  const std::optional<Recorded> ours = turn_of(own);
  const double here = ours ? degrees_in(*ours).value_or(0.0) : 0.0;
  return std::fmod(std::fmod(*there - here, 360.0) + 360.0, 360.0);
}

}  // namespace

void check_role(const StudyRun& study, const db::RunRecord& own, const db::RunRecord& other, StudyPurpose purpose) {
  if (study.role.empty()) return;
  if (purpose != StudyPurpose::kPlainLoops)
    refuse(study,
           fmt::format("run {} {}, according to its recipe: it cannot be a study of {}", study.run,
                       purpose == StudyPurpose::kPresses ? "presses an object" : "has several rates or held levels",
                       study.role == "mount" ? "mounts" : "turns"),
           fmt::format("its recipe shows its purpose: --studies {}", study.run));
  const std::optional<Recorded> turned = turn_of(other);
  const std::optional<double> degrees = turned ? turned_against(own, *turned) : std::nullopt;
  const double stated = study.role == "mount" ? 0.0 : std::stod(study.role);
  if (degrees && std::abs(*degrees - stated) > 1e-6)
    refuse(study,
           fmt::format("run {} was turned by {:g} degrees relative to run {}, according to its record ({}){}",
                       study.run, *degrees, own.run, turned->where,
                       study.role == "mount" ? "" : fmt::format(", not by {:g}", stated)),
           fmt::format("state what was done: {}:{:g}", study.run, *degrees));
  if (study.role != "mount") return;
  const std::optional<Recorded> ours = mount_of(own), theirs = mount_of(other);
  if (ours && theirs && ours->value == theirs->value)
    refuse(study,
           fmt::format("run {} was not re-mounted, according to its record: {}, as in run {}", study.run, theirs->where,
                       own.run),
           fmt::format("name runs of another mount; to check models on this run: --held-out {}", study.run));
}

namespace {

constexpr std::size_t kMostTurns = 4;  // named one by one

std::vector<sequences::Override> recipe_overrides(const db::RunRecord& run) {
  std::vector<std::string> set;
  if (const auto overrides = stored_overrides(run.overrides_json))
    for (const sequences::Override& item : *overrides) set.push_back(item.key + "=" + item.value);
  return split_overrides(set).recipe;
}

std::string turns_of(const sequences::Recipe& recipe) {
  std::vector<double> turns;
  for (const devices::Psi turn : recipe.turning_points) turns.push_back(turn.value());
  if (turns.size() > kMostTurns) {
    const auto [low, high] = std::ranges::minmax(turns);
    return fmt::format("{} turning points, {}", turns.size(), analysis::both_units_span(low, high));
  }
  std::vector<std::string> pressures;
  for (const double psi : turns) pressures.push_back(analysis::both_units(psi));
  return fmt::format("from {}", fmt::join(pressures, " to "));
}

std::string ramps_of(const sequences::Recipe& recipe) {
  std::string text;
  for (const double ramp : recipe.ramp_psi_per_s)
    text += fmt::format("{}{} a second", text.empty() ? "" : ", ", analysis::both_units(ramp));
  return text;
}

// A sweep is a branch from one turning point to the next.
std::string sweeps_of(const sequences::Recipe& recipe) {
  std::string repeats = analysis::counted(recipe.repeats, "repeat");
  if (recipe.kind == sequences::RecipeKind::kPress || recipe.turning_points.size() < 2) return repeats;
  return fmt::format("{} of {}", repeats, analysis::counted(recipe.turning_points.size() - 1, "sweep"));
}

std::string warm_up_of(const sequences::Recipe& recipe) {
  if (recipe.warm_up.at_most_s <= 0.0) return {};
  return fmt::format(
      "; before the run a wait of at most {:g} s until the unloaded output drifts by less than {:g} % of the range per "
      "minute",
      recipe.warm_up.at_most_s, recipe.warm_up.drift_percent_per_min);
}

std::string conditioning_of(const sequences::Recipe& recipe) {
  const sequences::Conditioning& given = recipe.conditioning;
  if (given.cycles == 0) return "no conditioning before it";
  const std::string peak = recipe.kind == sequences::RecipeKind::kPress ? fmt::format("{:g} N", given.peak_n)
                                                                        : analysis::both_units(given.peak.value());
  if (!(given.change_percent > 0.0))
    return fmt::format("before it {} to {} without frames", analysis::counted(given.cycles, "cycle"), peak);
  return fmt::format(
      "before it {} to {} cycles to {} without frames, until two differ by less than {:g} % of full scale", given.least,
      given.cycles, peak, given.change_percent);
}

std::string sequence_text(const sequences::Recipe& recipe) {
  std::string text = sweeps_of(recipe);
  if (recipe.kind == sequences::RecipeKind::kPress)
    text += fmt::format("; {} at {}, forces of {:g} N", recipe.press.object,
                        analysis::counted(recipe.press.positions_mm.size(), "place"),
                        fmt::join(recipe.press.forces_n, ", "));
  else
    text += fmt::format("; a level every {}, {}", analysis::both_units(recipe.step.value()), turns_of(recipe));
  const char* each = recipe.dwell_s.size() > 1 || recipe.ramp_psi_per_s.size() > 1 ? ", one per repeat in turn" : "";
  text += recipe.settle ? fmt::format("; waiting time (dwell) {:g} s from pressure or force in band to the frame{}",
                                      fmt::join(recipe.dwell_s, ", "), each)
                        : fmt::format("; on a ramp of {}{}, frames as it passes the levels", ramps_of(recipe), each);
  if (recipe.frames_per_level > 1)
    text += fmt::format("; {} frames {}, {:g} s apart", recipe.frames_per_level,
                        recipe.frames_at == sequences::FramesAt::kLevels  ? "a level"
                        : recipe.frames_at == sequences::FramesAt::kTurns ? "at each turning point"
                                                                          : "at each held level",
                        recipe.frame_interval_s);
  return fmt::format("{}; {}{}", text, conditioning_of(recipe), warm_up_of(recipe));
}

}  // namespace

std::vector<std::string> method_descriptions(const db::RunRecord& run) {
  std::vector<std::string> descriptions;
  for (const db::SequenceRecord& sequence : run.sequences) {
    try {
      descriptions.push_back(sequence_text(sequences::parse_recipe(
          sequences::TomlDocument::from_text(sequence.recipe_toml, sequence.name), recipe_overrides(run))));
    } catch (const std::exception&) {
      descriptions.emplace_back();  // of another version, or imported
    }
  }
  return descriptions;
}

}  // namespace tactbench::bench
