// Earlier runs for time estimates, written directly into a store: known times, no rig.
#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include "db/run_store.h"
#include "sequences/recipe.h"

namespace tactbench::tests {

// 9 frames per repeat, two repeats.
inline sequences::Recipe recipe_named(const std::string& name) {
  return sequences::parse_recipe(sequences::TomlDocument::from_text(
      "schema = 1\nname = \"" + name + "\"\nunit = \"psi\"\nturning_points = [0, 8, 0]\nstep = 2\nrepeats = 2\n" +
          "[conditioning]\ncycles = 1\npeak = 8\n",
      name + ".toml"));
}

struct Past {
  double step_s = 3.0, growth_s = 0.0;  // each step takes so much longer than the one before
  std::string overrides = "[]", bench = "b";
  db::Outcome outcome = db::Outcome::kCompleted;
  bool idle = false;      // without frames
  int redo_after = -1;    // frames; the branch so far is done again
  double prompt_s = 0.0;  // waited for the operator before the first step
  int paused_after = -1;  // frames: a pause of 600 s, and 50 s for the way back
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
    const std::vector<sequences::Step> steps = sequences::compile(recipes[i], static_cast<int>(i));
    const auto frames = std::count_if(steps.begin(), steps.end(),
                                      [](const sequences::Step& step) { return has_frame(step) && step.repeat == 0; });
    run.sequences.push_back({static_cast<int>(i), recipes[i].name, recipes[i].text, db::sha256_hex(recipes[i].text),
                             recipes[i].repeats, static_cast<int>(frames)});
  }
  const std::int64_t number = store.begin_run(run);
  double now = 0.0;
  const auto tell = [&](const std::string& kind, const std::string& detail) {
    store.append_event(number, {static_cast<std::int64_t>(now * 1e9), kind, "", detail});
  };
  tell("state", "prepared -> running: x");
  if (past.prompt_s > 0.0) {
    tell("state", "running -> pausing: for the operator");
    tell("state", "pausing -> paused: x");
    now += past.prompt_s;
    tell("state", "paused -> running: x");
  }
  std::int64_t branch = 0;
  db::BranchRecord at;
  at.sequence = -1;
  int frames = 0, steps_done = 0;
  for (const sequences::Step& step : sequences::compile(recipes)) {
    now += past.step_s + past.growth_s * steps_done++;
    if (!has_frame(step) || past.idle) continue;
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
    if (frames != past.paused_after) continue;
    tell("state", "running -> pausing: asked by Ctrl-C");
    tell("state", "pausing -> paused: asked by Ctrl-C");
    now += 600.0;
    tell("state", "paused -> running: resumed by alice (pid 7) after 600 s");
    tell("way-back", "x");
    now += 50.0;
  }
  tell("state", "running -> stopping: all steps done");
  store.end_run(number, past.outcome, "", db::SafeState::kVerified, "");
}

}  // namespace tactbench::tests
