#include "analysis/report/parts.h"
#include "analysis/report/sections/sections.h"

namespace tactbench::analysis {

using html::markup;
using html::Markup;
using html::Text;

namespace {

// Words of VIM (JCGM 200) and of the guides on pressure and conformity, once for a reader who does not know them.
Markup terms_table() {
  static const std::vector<std::pair<const char*, const char*>> terms = {
      {"indication", "the output of a taxel as measured, in volt"},
      {"corrected indication",
       "the pressure that the measurement model, the inverse of the hysteresis model, gives for it"},
      {"reference value", "the pressure by the measurement standard, the pressure reference, when the frame was taken"},
      {"error", "corrected indication less reference value; mean absolute error: the mean of its size"},
      {"increasing, decreasing", "the direction of the pressure: loading, unloading"},
      {"hysteresis", "difference between increasing and decreasing pressure at one level"},
      {"non-uniformity", "standard deviation over the taxels at one level, all under the same pressure"},
      {"relative sensitivity", "output of a taxel over the mean of all at one level"},
      {"lack of fit", "what the model differs by from what it was fitted to"},
      {"zero deviation", "change of the output at the lowest pressure from before to after"},
      {"discrimination", "the model distinguishes pressures in spite of noise"},
      {"measuring interval", "pressures at which U of 95 % of the taxels is within a stated share of full pressure"},
      {"calibration data", "the own run, which the models were made from"},
      {"verification data", "other runs, held out: the models were not made from them"},
      {"requirement, tolerance limit", "a figure that is judged, and the value that it must not exceed"},
      {"statement of conformity",
       "whether all requirements are met by the decision rule: pass, fail or what lies between"},
      {"FS",
       "full scale. Of the indication, where not stated otherwise, the highest of the outputs at the levels, each the "
       "mean of the sweeps; of the corrected indication the highest pressure. Of a model it is the output at the end "
       "of "
       "its loop"}};
  Markup rows;
  for (const auto& [term, meaning] : terms)
    rows += markup("<tr><th scope=\"row\">{}</th><td>{}</td></tr>\n", Text(term), Text(meaning));
  return markup("<table class=\"pairs\"><caption>Terms</caption><tbody>\n{}</tbody></table>\n", rows);
}

}  // namespace

Markup meaning_section(const ReportInput& input) {
  Markup out = section_start("meaning", "Terms, and limits of the figures");
  out += terms_table();
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
      Text("The errors of the direct model and those in the column “own run” are of the calibration data, which the "
           "models were made from. Only other runs are independent verification."));
  item(
      Text("Flat stretches: where the output hardly changes with pressure, above all where it begins to decrease, the "
           "pressure "
           "cannot be observed by any method. Such samples are flagged and counted; figures with and without them are "
           "both given."));
  const bool covered = input.uncertainty && input.uncertainty->creep.assessed();
  item(markup(
      "Creep: a held pressure with a drifting output is outside every rate-independent model, this one too. What was "
      "measured of creep, repeatability and zero deviation stands in “Indication before correction”; crosstalk "
      "in “Crosstalk, rate and hold, mounting, uniformity of the pressure”. What no run shows is not assessed.{}",
      covered
          ? markup(" U covers creep in indications from {} s to {} s after the level was commanded, no other ones.",
                   html::fixed(input.uncertainty->creep.read_after_s, 1), html::fixed(input.uncertainty->creep.to_s, 0))
          : markup("")));
  if (!input.more.studies.uniformity.assessed()) {
    item(
        Text("Uniformity of the pressure over the chamber: not assessed. It would count as non-uniformity "
             "of the taxels."));
  }
  item(Text(
      "Shares of FS of the indication and of the corrected indication are shares of two quantities: see FS above."));
  out += markup("</ul>\n");
  return out;
}

}  // namespace tactbench::analysis
