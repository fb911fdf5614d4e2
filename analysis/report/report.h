// One self-contained HTML calibration report of at most six pages plus annexes: no script, inline SVG, well-formed XML;
// and its data as JSON, whose hash is part of the report's number. The same input gives the same bytes.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "analysis/identify/sensor_model.h"
#include "analysis/judgement/judgement.h"
#include "analysis/pressure_unit.h"
#include "analysis/report/laboratory.h"
#include "analysis/report/page/page.h"
#include "analysis/report/results.h"
#include "analysis/report/run_log.h"
#include "analysis/statistics/figures/behaviour.h"
#include "analysis/statistics/figures/evaluation.h"
#include "analysis/statistics/sensor/health.h"
#include "analysis/statistics/uncertainty/uncertainty.h"
#include "db/record.h"

namespace tactbench::analysis {

// A further run of the same sensor compensated with the same models: held-out, re-mounted, later and warmer.
struct HeldOut {
  std::string title;  // "held-out run", "re-mounted", "one month later at +5 °C"
  db::RunRecord run;
  Evaluation evaluation;
};

// The pressures of one sequence over time, from its first repeat.
struct AppliedPressures {
  std::string title;  // the sequence
  bool verification = false;
  std::size_t repeats = 1;
  std::vector<double> time_s, pressure_psi;
};

struct ReportInput {
  db::RunRecord run;  // the characterization
  std::optional<db::SensorRecord> sensor;
  SensorModel fit;        // without taxels: there are no models, and the sections that need them say so
  Evaluation evaluation;  // on the run of the fit; without levels: not evaluated
  std::vector<HeldOut> held_out;
  std::vector<db::RunRecord> further;  // further runs of the same sensor, for creep, mounts, objects
  Judgement judgement;
  std::optional<Uncertainty> uncertainty;  // of a reading of this run's taxels
  std::string program_version;
  std::int64_t frame_count = 0;
  ReportResults more;
  RunLog history;
  Health health;
  Behaviour behaviour;
  Laboratory laboratory;
  std::vector<std::string> method;          // how each sequence was carried out, pressures in psi; empty: not known
  std::vector<AppliedPressures> applied;    // one entry per distinct trajectory
  std::vector<std::string> annexes;         // by name; not part of the content
  std::vector<db::ReportRecord> approvals;  // of this run's reports, oldest first; not part of the content
  std::string issued;                       // date of issue as typed; empty: date of the approval
  std::string reason;                       // why a draft replaces an approved report; not part of the content
  PaperSize paper = PaperSize::kA4;         // not part of the content
  PressureUnit unit;  // of the pressures on the page; not part of the content, because the data stay in psi
};

struct Report {
  std::string number;  // run number + first 8 hex digits of the content hash
  std::string content_sha256;
  std::string html;
  std::string
      json;  // the data: schema tactbench.report, version, number, ...; the page contains only the first members
};

// Whether `input` carries a signature for report `number`.
bool is_signed(const ReportInput& input, const std::string& number);
// The mark of a signed report in its title, which a PDF keeps.
std::string signed_title_mark(const std::string& number);

inline constexpr std::array kAnnexes = {"maps", "taxels", "models", "parameters", "events", "hashes"};

Report render_report(const ReportInput& input);
// `report` as a digital calibration certificate (dcc/dcc.h). Throws AnalysisError TB-REPORT-DCC, naming all that it
// lacks.
std::string render_dcc(const ReportInput& input, const Report& report);

}  // namespace tactbench::analysis
