// One self-contained HTML calibration report: no script, inline SVG, well-formed XML, data as JSON inside. Same input,
// same bytes.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "analysis/identify/identify.h"
#include "analysis/statistics/evaluation.h"
#include "db/record.h"

namespace tactbench::analysis {

// A further run of the same sensor compensated with the same models: held-out, re-mounted, later and warmer.
struct HeldOut {
  std::string title;  // "held-out run", "re-mounted", "one month later at +5 °C"
  db::RunRecord run;
  Evaluation evaluation;
};

struct ReportInput {
  db::RunRecord run;  // the characterization
  std::optional<db::SensorRecord> sensor;
  ArrayFit fit;
  Evaluation evaluation;  // the fit's own run
  std::vector<HeldOut> held_out;
  std::vector<db::VerdictRecord> verdicts;
  std::string program_version;
  std::int64_t frame_count = 0;
};

struct Report {
  std::string number;  // run number + first 8 hex digits of the content hash (contract.md)
  std::string content_sha256;
  std::string html;
  std::string json;  // the data alone, as inside the page: schema tactbench.report, version, number, data
};

Report render_report(const ReportInput& input);

}  // namespace tactbench::analysis
