#include "bench/reporting/method_words.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <optional>

#include "bench/common/overrides.h"
#include "bench/run/run_record.h"
#include "sequences/recipe.h"

namespace tactbench::bench {

namespace {

constexpr std::size_t kMostTurns = 20;  // named one by one

std::vector<sequences::Override> recipe_overrides(const db::RunRecord& run) {
  std::vector<std::string> set;
  if (const auto overrides = stored_overrides(run.overrides_json))
    for (const sequences::Override& item : *overrides) set.push_back(item.key + "=" + item.value);
  return split_overrides(set).recipe;
}

std::string turns_of(const sequences::Recipe& recipe) {
  std::vector<double> turns;
  for (const devices::Psi turn : recipe.turning_points) turns.push_back(turn.value());
  if (turns.size() > kMostTurns) return fmt::format("{} turning points", turns.size());
  return fmt::format("turning at {:g} psi", fmt::join(turns, ", "));
}

std::string conditioning_of(const sequences::Recipe& recipe) {
  const sequences::Conditioning& given = recipe.conditioning;
  if (given.cycles == 0) return "no conditioning";
  const std::string peak = recipe.kind == sequences::RecipeKind::kPress ? fmt::format("{:g} N", given.peak_n)
                                                                        : fmt::format("{:g} psi", given.peak.value());
  if (!(given.change_percent > 0.0)) return fmt::format("before it {} cycles to {} without frames", given.cycles, peak);
  return fmt::format(
      "before it {} to {} cycles to {} without frames, until two differ by less than {:g} % of full scale", given.least,
      given.cycles, peak, given.change_percent);
}

std::string sequence_words(const sequences::Recipe& recipe) {
  std::string words;
  if (recipe.kind == sequences::RecipeKind::kPress)
    words = fmt::format("{} at {} places, forces of {:g} N", recipe.press.object, recipe.press.positions_mm.size(),
                        fmt::join(recipe.press.forces_n, ", "));
  else
    words = fmt::format("a level every {:g} psi, {}", recipe.step.value(), turns_of(recipe));
  words += recipe.settle ? fmt::format("; dwell {:g} s from pressure or force in band to the frame",
                                       fmt::join(recipe.dwell_s, ", "))
                         : fmt::format("; on a ramp of {:g} psi/s", fmt::join(recipe.ramp_psi_per_s, ", "));
  if (recipe.frames_per_level > 1)
    words += fmt::format("; {} frames a level, {:g} s apart", recipe.frames_per_level, recipe.frame_interval_s);
  return fmt::format("{}; {}", words, conditioning_of(recipe));
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
