// Runs that a time estimate can learn from, written straight into a store: known times, no rig.
#pragma once

#include <string>
#include <vector>

#include "db/run_store.h"
#include "sequences/recipe.h"

namespace tactbench::tests {

// 9 frames a repeat, two repeats.
inline sequences::Recipe recipe_named(const std::string& name) {
  return sequences::parse_recipe(sequences::TomlDocument::from_text(
      "schema = 1\nname = \"" + name + "\"\nunit = \"psi\"\nturning_points = [0, 8, 0]\nstep = 2\nrepeats = 2\n" +
          "[conditioning]\ncycles = 1\npeak = 8\n",
      name + ".toml"));
}

struct Past {
  double step_s = 3.0;
  std::string overrides = "[]", bench = "b";
  db::Outcome outcome = db::Outcome::kCompleted;
  int redo_after = -1;  // frames; the branch so far is done again
};

inline void store_run(db::RunStore& store, const std::vector<sequences::Recipe>& recipes, const Past& past) {
  db::RunRecord run;
  run.uuid = db::new_uuid();
  run.origin = std::string("simulated");
  run.state = std::string("prepared");
  run.bench_id = past.bench;
  run.overrides_json = past.overrides;
  run.sensor_serial = "S-1";
  for (std::size_t i = 0; i < recipes.size(); ++i) {
    run.sequences.push_back({static_cast<int>(i), recipes[i].name, recipes[i].text, db::sha256_hex(recipes[i].text),
                             recipes[i].repeats, 9});
  }
  const std::int64_t number = store.begin_run(run);
  double now = 0.0;
  std::int64_t branch = 0;
  db::BranchRecord at;
  at.sequence = -1;
  int frames = 0;
  for (const sequences::Step& step : sequences::compile(recipes)) {
    now += past.step_s;
    if (!takes_frame(step)) continue;
    if (step.sequence != at.sequence || step.repeat != at.repeat || step.branch != at.ordinal) {
      at.sequence = step.sequence;
      at.repeat = step.repeat;
      at.ordinal = step.branch;
      branch = store.begin_branch(number, at);
    }
    db::FrameRecord frame;
    frame.branch = branch;
    frame.ordinal = step.ordinal;
    frame.time_ns = static_cast<std::int64_t>(now * 1e9);
    frame.rows = frame.columns = frame.scans = 1;
    frame.counts = {0};
    store.append_frame(number, frame);
    if (++frames == past.redo_after) now += 100.0;
  }
  store.end_run(number, past.outcome, "", db::SafeState::kVerified, "");
}

}  // namespace tactbench::tests
