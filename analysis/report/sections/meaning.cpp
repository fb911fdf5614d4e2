#include "analysis/report/parts.h"
#include "analysis/report/sections/sections.h"

namespace tactbench::analysis {

using html::markup;
using html::Markup;
using html::Text;

Markup meaning_section(const ReportInput& input) {
  Markup out = section_start("meaning", "What the figures mean, and their limits");
  out += markup("<ul>\n");
  const auto item = [&](const html::Safe& text) { out += markup("<li>{}</li>\n", text); };
  if (is_simulated(input)) {
    item(
        Text("The devices and the sensor were simulated. The figures show what the program does, not what a sensor is "
             "like."));
  }
  item(Text(input.uncertainty
                ? "Uncertainty of measurement: U is valid for the conditions of use that the table beside the budgets "
                  "names, and for no other."
                : "Uncertainty of measurement: not assessed. No figure here has a stated uncertainty."));
  item(
      Text("The results relate only to the item identified, with the scanner electronics named, in the state and at "
           "the place of "
           "the run. This report is to be reproduced only as a whole."));
  if (!has_reference(input.run)) {
    item(
        Text("Pressure not independently traceable: an error of the regulator's feedback is contained in the models "
             "and cannot "
             "be seen in any error printed here."));
  }
  item(
      Text("The errors of the direct model and those in the column “own run” are of the data that the models were made "
           "from. Only "
           "other runs show what to expect in use."));
  item(
      Text("Flat stretches: where the output hardly changes with pressure, above all at the start of unloading, the "
           "pressure "
           "cannot be observed by any method. Such samples are flagged and counted; figures with and without them are "
           "both given."));
  const bool covered = input.uncertainty && input.uncertainty->creep.assessed();
  item(markup(
      "Creep: a held pressure with a drifting output is outside every rate-independent model, this one too. What was "
      "measured of creep, repeatability and zero return stands in “Behaviour before compensation”; crosstalk "
      "in “Crosstalk, rate and hold, mounting, uniformity”. What no run tells is not assessed.{}",
      covered
          ? markup(" U covers creep in readings from {} s to {} s after the level was commanded, no other ones.",
                   html::fixed(input.uncertainty->creep.read_after_s, 1), html::fixed(input.uncertainty->creep.to_s, 0))
          : markup("")));
  if (!input.more.studies.uniformity.assessed()) {
    item(
        Text("Uniformity of the pressure over the chamber: not assessed. A non-uniformity is taken for mismatch of the "
             "taxels."));
  }
  item(
      Text("FS is the highest mean output in volt before compensation and the full pressure after it; a per cent "
           "before and a "
           "per cent after are shares of these two."));
  out += markup("</ul>\n");
  return out;
}

}  // namespace tactbench::analysis
