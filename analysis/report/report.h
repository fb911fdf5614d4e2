// One self-contained HTML calibration report: no script, inline SVG, well-formed XML, data as JSON inside. Same input,
// same bytes.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "analysis/identify/identify.h"
#include "analysis/report/history.h"
#include "analysis/report/laboratory.h"
#include "analysis/report/results.h"
#include "analysis/report/style.h"
#include "analysis/statistics/behaviour.h"
#include "analysis/statistics/evaluation.h"
#include "analysis/statistics/health.h"
#include "analysis/statistics/uncertainty.h"
#include "analysis/statistics/verdict.h"
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
  ArrayFit fit;           // without taxels: no models, and the sections that need some say so
  Evaluation evaluation;  // the fit's own run; without levels: not evaluated
  std::vector<HeldOut> held_out;
  std::vector<db::RunRecord> further;  // of the same sensor, for what one run does not tell: creep, mounts, objects
  std::vector<db::VerdictRecord> verdicts;
  std::optional<Uncertainty> uncertainty;  // of a reading of this run's taxels
  std::vector<JudgedUncertainty> judged;   // of the figures in `verdicts`
  std::string program_version;
  std::int64_t frame_count = 0;
  ReportResults more;
  RunHistory history;
  Health health;
  Behaviour behaviour;
  Laboratory laboratory;
  std::vector<db::ReportRecord> approvals;  // of this run's reports, oldest first; no part of the content
  std::string issued;                       // date of issue as typed; empty: that of the approval
  PaperSize paper = PaperSize::kA4;         // no part of the content
};

struct Report {
  std::string number;  // run number + first 8 hex digits of the content hash (contract.md)
  std::string content_sha256;
  std::string html;
  std::string json;  // the data alone, as inside the page: schema tactbench.report, version, number, data
};

Report render_report(const ReportInput& input);

}  // namespace tactbench::analysis
