// One self-contained HTML calibration report: no script, inline SVG, well-formed XML, data as JSON inside. Same input,
// same bytes.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "analysis/identify/sensor_model.h"
#include "analysis/pressure_unit.h"
#include "analysis/report/history.h"
#include "analysis/report/laboratory.h"
#include "analysis/report/page/style.h"
#include "analysis/report/results.h"
#include "analysis/statistics/conformity/overall_verdict.h"
#include "analysis/judgement/trajectory.h"
#include "analysis/statistics/conformity/verdict.h"
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

struct UnassessedSource {
  std::string source, why;  // "re-mounting"
};

// Remarks on the verdicts besides their rows, for page 1.
struct JudgementNotes {
  std::string not_judged;            // why the rows are not a verdict; empty: they are one
  std::vector<std::string> remarks;  // void runs that were counted, held-out runs that were not
  // Stored verdicts on these models that are worse than the rows: by other limits, or on runs that the rows leave out.
  std::vector<db::VerdictRecord> stored_worse;
  std::vector<JudgedTrajectory> trajectories;  // of each judged run
  // What dominates in use and is neither shown by a judged run nor in the budgets; with any, a pass is one under
  // repeatability conditions only (VIM 2.20).
  std::vector<UnassessedSource> not_assessed;
  std::string untraced;  // "reference overdue since 2020-01-31", when a judged run was made; empty: all is traceable
};

// The overall verdict as a statement: "pass, under repeatability conditions only", "inconclusive: reference overdue
// since ...".
std::string statement_in_words(Verdict overall, const JudgementNotes& notes);
// What follows the verdict's own word in it; empty: nothing.
std::string condition_in_words(Verdict overall, const JudgementNotes& notes);
// "re-mounting; temperature"; empty: all are assessed.
std::string not_assessed_in_words(const JudgementNotes& notes);

// The overall verdict of rows and notes: inconclusive when the rows are not a verdict, fail when a stored verdict is
// fail, else the worst row; none without rows.
std::optional<Verdict> final_verdict(std::span<const db::VerdictRecord> verdicts, const JudgementNotes& notes);

struct ReportInput {
  db::RunRecord run;  // the characterization
  std::optional<db::SensorRecord> sensor;
  SensorModel fit;        // without taxels: no models, and the sections that need some say so
  Evaluation evaluation;  // the fit's own run; without levels: not evaluated
  std::vector<HeldOut> held_out;
  std::vector<db::RunRecord> further;       // of the same sensor, for creep, mounts, objects
  std::vector<db::VerdictRecord> verdicts;  // of each run judged, one after the other
  JudgementNotes judgement;
  std::optional<Uncertainty> uncertainty;  // of a reading of this run's taxels
  std::vector<JudgedUncertainty> judged;   // of the figures in `verdicts`
  std::string program_version;
  std::int64_t frame_count = 0;
  ReportResults more;
  RunHistory history;
  Health health;
  Behaviour behaviour;
  Laboratory laboratory;
  std::vector<std::string> method;          // how each sequence was carried out, pressures in psi; empty: not known
  std::vector<db::ReportRecord> approvals;  // of this run's reports, oldest first; no part of the content
  std::string issued;                       // date of issue as typed; empty: that of the approval
  std::string reason;                       // why a draft replaces an approved report; no part of the content
  PaperSize paper = PaperSize::kA4;         // no part of the content
  PressureUnit unit;  // of the pressures on the page; no part of the content, as the data stay in psi
};

struct Report {
  std::string number;  // run number + first 8 hex digits of the content hash
  std::string content_sha256;
  std::string html;
  std::string json;  // the data alone, as inside the page: schema tactbench.report, version, number, data
};

// Whether `input` carries a signature for report `number`.
bool is_signed(const ReportInput& input, const std::string& number);
// The mark of a signed report in its title, which a PDF keeps.
std::string signed_title_mark(const std::string& number);

Report render_report(const ReportInput& input);

}  // namespace tactbench::analysis
