#include "bench/reporting/method_words.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <optional>

#include "analysis/counted.h"
#include "analysis/pressure_unit.h"
#include "bench/common/overrides.h"
#include "bench/run/run_record.h"
#include "sequences/recipe.h"

namespace tactbench::bench {

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
  std::vector<std::string> words;
  for (const double psi : turns) words.push_back(analysis::both_units(psi));
  return fmt::format("from {}", fmt::join(words, " to "));
}

std::string ramps_of(const sequences::Recipe& recipe) {
  std::string words;
  for (const double ramp : recipe.ramp_psi_per_s)
    words += fmt::format("{}{} a second", words.empty() ? "" : ", ", analysis::both_units(ramp));
  return words;
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
      "; before the run a wait of at most {:g} s until the unloaded output drifts by less than {:g} % of "
      "the range a minute",
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

std::string sequence_words(const sequences::Recipe& recipe) {
  std::string words = sweeps_of(recipe);
  if (recipe.kind == sequences::RecipeKind::kPress)
    words += fmt::format("; {} at {}, forces of {:g} N", recipe.press.object,
                         analysis::counted(recipe.press.positions_mm.size(), "place"),
                         fmt::join(recipe.press.forces_n, ", "));
  else
    words += fmt::format("; a level every {}, {}", analysis::both_units(recipe.step.value()), turns_of(recipe));
  const char* each = recipe.dwell_s.size() > 1 || recipe.ramp_psi_per_s.size() > 1 ? ", one a repeat in turn" : "";
  words += recipe.settle ? fmt::format("; waiting time (dwell) {:g} s from pressure or force in band to the frame{}",
                                       fmt::join(recipe.dwell_s, ", "), each)
                         : fmt::format("; on a ramp of {}{}, frames as it passes the levels", ramps_of(recipe), each);
  if (recipe.frames_per_level > 1)
    words += fmt::format("; {} frames {}, {:g} s apart", recipe.frames_per_level,
                         recipe.frames_at == sequences::FramesAt::kLevels  ? "a level"
                         : recipe.frames_at == sequences::FramesAt::kTurns ? "at each turning point"
                                                                           : "at each held level",
                         recipe.frame_interval_s);
  return fmt::format("{}; {}{}", words, conditioning_of(recipe), warm_up_of(recipe));
}

}  // namespace

std::vector<std::string> method_words(const db::RunRecord& run) {
  std::vector<std::string> words;
  for (const db::SequenceRecord& sequence : run.sequences) {
    try {
      words.push_back(sequence_words(sequences::parse_recipe(
          sequences::TomlDocument::from_text(sequence.recipe_toml, sequence.name), recipe_overrides(run))));
    } catch (const std::exception&) {
      words.emplace_back();  // of another version, or imported
    }
  }
  return words;
}

}  // namespace tactbench::bench
