// HTML pages of a nightly run with its trends, and of the figures of a sensor or rig over its runs. One file each, no
// script, inline SVG, well-formed XML.
#pragma once

#include <string>
#include <vector>

#include "bench/nightly/subject_trend.h"
#include "bench/nightly/suite.h"

namespace tactbench::bench {

struct NightPage {
  std::string begun_utc, program;       // program: version and commit
  std::vector<ScenarioResult> results;  // in the suite's order
  std::vector<SubjectTrend> followed;   // trends of the suite's subjects, if nights are stored; else empty
};
std::string night_page(const Suite& suite, const NightPage& night);

// `origin`: simulated data is marked as such on the page.
std::string trend_page(const std::string& title, const std::string& origin, const std::vector<SubjectTrend>& followed);

}  // namespace tactbench::bench
