// Models kept: as JSON documents, complete in themselves, and in the run store. A document says what was fitted on
// what, and carries for each taxel all that predicting and compensating need. Schema "tactbench.model", version 1,
// described in analysis/README.md. A run's ELAM in the paper's mode on all sequences is kept in rows (fit_rows.h).
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "analysis/compensate/frame_setup.h"
#include "analysis/identify/sensor_model.h"

namespace tactbench::analysis {

inline constexpr int kModelDocumentVersion = 1;
inline constexpr const char* kElamFit = "elam";  // db::FitRecord::model of fits that have rows

// Text with a newline at its end; the same model gives the same bytes.
std::string to_text(const SensorModel& model);
std::string sha256_of(const SensorModel& model);  // of that text
// Throws AnalysisError TB-MODEL-DOCUMENT that says which member of `file` is missing, wrong or of a newer version.
SensorModel document_from_text(const std::string& text, const std::string& file);

// What the frame compensator of an array needs. Throws AnalysisError TB-MODEL-COMPENSATOR when the model is not ELAM
// with one split point a branch and without memory, or not of an array.
FrameSetup frame_setup_of(const SensorModel& model, double volts_per_count);

// MODEL of the command line: the path of a .json, or RUN[:FIT] in `store` (nullptr: paths only).
SensorModel load_model(const std::string& model, const db::RunStore* store);
// The model with its options, as tables name it: "elam", "elam, free run".
std::string label_of(const SensorModel& model);

// The fit that stands for a run where none is named: the newest by the dynamic model, or by ELAM in the paper's mode on
// all sequences; of others the newest, and none where the run was not fitted.
std::optional<db::FitRecord> standing_fit(const db::RunStore& store, std::int64_t run);

// To and from the store. load_fit: the run's standing fit, TB-ANALYSIS-NO-FIT when it has none; or
// the fit of a record; a fit in rows comes without the run's sequences, hash and scans, which load_model adds.
// `made_by`: build and class of processor, kept for who recomputes the fit. Returns the fit's number.
std::int64_t store_fit(db::RunStore& store, const SensorModel& model, const std::string& program_version,
                       const std::string& utc, const std::string& made_by = {});
SensorModel load_fit(const db::RunStore& store, std::int64_t run);
SensorModel load_fit(const db::RunStore& store, const db::FitRecord& record);

}  // namespace tactbench::analysis
