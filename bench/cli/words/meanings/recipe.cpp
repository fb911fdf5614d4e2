#include "bench/cli/words/meanings/meanings.h"

namespace tactbench::bench {

KeyMeanings recipe_meanings() {
  return {
      {"schema", "Version of this file's format"},
      {"name", "Short name, by which reports and lists call it"},
      {"title", "Title in reports and lists; left out: the name"},
      {"kind", "levels: pressure in the chamber; press: an object under the z stage"},
      {"unit", "Unit of the pressures in this file"},
      {"turning_points", "Pressures at which the direction changes, from the first to the last; whole steps apart"},
      {"step", "Distance of two levels; a frame is taken at each level between the turning points"},
      {"settle", "band: a frame waits until the level is reached; none: it is taken as the ramp passes the level"},
      {"dwell_s", "Time from the level reached to the frame; a list: one for each repeat"},
      {"ramp_psi_per_s", "How fast the set-point changes; 0: as fast as the bench allows. A list: one for each repeat"},
      {"frames_per_level", "Frames at each level; more than one is a hold"},
      {"frame_interval_s", "Time between two frames of one level"},
      {"repeats", "How often the whole sequence is carried out; left out: as often as the longest list has entries"},
      {"rest_restart_s", "A run that is resumed after a longer rest does the whole repeat again"},

      {"random.seed", "Turning points are drawn instead of listed; the same seed gives the same ones"},
      {"random.reversals", "How many are drawn; an odd number, so that the way back to 0 is a fall"},
      {"random.low", "Lowest turning point that is drawn"},
      {"random.high", "Highest turning point that is drawn; the sequence begins with a loop to it"},

      {"conditioning.cycles", "Cycles without frames before the first repeat, at most; 0: none. First loads differ"},
      {"conditioning.least", "At least so many, where change_percent may end them"},
      {"conditioning.change_percent",
       "They end when the loop changes from one to the next by less than this share of full scale; 0: all are done"},
      {"conditioning.peak", "Highest pressure of such a cycle"},
      {"conditioning.peak_n", "Highest force of such a cycle, for kind = \"press\"; left out: the highest of forces_n"},

      {"warm_up.drift_percent_per_min", "The first command waits until the unloaded output drifts less than this"},
      {"warm_up.at_most_s", "It waits at most this long; 0: it does not wait"},
      {"dwell.tolerance_s", "Frames whose dwell differs by more than this are flagged"},

      {"limits.least_response_v",
       "A run ends in its first cycle when the mean output at the first peak is not this far above the unloaded one; "
       "0: no limit"},
      {"limits.most_dead_taxels",
       "A run ends in its first cycle when more taxels than this do not respond; -1: no limit"},

      {"guard.tolerance_psi", "A branch breaks when the pressure steps back by more than this"},
      {"guard.tolerance_n", "The same of the force, for kind = \"press\""},
      {"guard.redo", "How often a broken branch is done again"},
      {"guard.on_broken", "When it is still broken: fail the run, or flag the branch and go on"},

      {"suspend[].quantity", "What is watched; the bench needs a sensor of it"},
      {"suspend[].trip_below", "Below this the run vents and waits; it goes with resume_above"},
      {"suspend[].trip_above", "Above this the run vents and waits; it goes with resume_below"},
      {"suspend[].resume_above", "The run goes on once the quantity has stayed above this"},
      {"suspend[].resume_below", "The run goes on once the quantity has stayed below this"},
      {"suspend[].hold_s", "How long it must have stayed there"},
      {"suspend[].timeout_s", "After a longer wait the run ends"},

      {"retry.frame", "How often a frame that a device failed is tried again"},
      {"retry.branch", "How often a branch in which a device failed is done again"},
      {"retry.verdict", "worst: a frame that needed another attempt is flagged; any: it counts like all others"},
      {"timeout.step_s", "Longest time that one step may take; 0: the bench's own limits alone"},
      {"prompt.before", "Question to the operator before the sequence; \"\": none. --yes answers it"},

      {"press.object", "Name of the object; stored, and on the simulated rig ring, point or flat"},
      {"press.forces_n", "Forces at which frames are taken, rising; the way down is added"},
      {"press.positions_mm", "Places [x, y] of the stage, one after another; or [press.grid]"},
      {"press.grid.x", "Places along x as [from, to, step]"},
      {"press.grid.y", "Places along y as [from, to, step]"},
      {"press.hold", "What stands still during the dwell: the position of z, or the force"},
      {"press.contact_n", "Force at which the object counts as touching while it approaches"},
      {"press.approach_mm_per_s", "Speed of z until it touches"},
      {"press.servo_mm_per_s", "Speed of z while a force is sought"},
      {"press.clear_mm", "How far z goes back between two places"},
      {"press.tare", "Whether the force sensor is set to zero before each repeat and after the last"},
      {"press.registers", "Whether the touches are used to find the taxels under the stage"},

      {"parameters.NAME.default", "Its value where --set recipe.NAME=... names none"},
      {"parameters.NAME.low", "Smallest value allowed"},
      {"parameters.NAME.high", "Largest value allowed"},
      {"parameters.NAME.value", "Its value, in place of the default; --set recipe.NAME=... writes here"},
      {"parameters.NAME.unit", "Its unit, for lists"},
      {"parameters.NAME.help", "What it does, for lists"}};
}

}  // namespace tactbench::bench
