// Stores models as self-contained JSON documents, in files and in the run store. A document states what was fitted on
// what, and holds for each taxel everything that prediction and compensation need. Schema "tactbench.model", version 1,
// described in analysis/README.md. Every finite double is restored bit for bit; NaN is null.
#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "analysis/identify/sensor_model.h"
#include "db/record.h"

namespace tactbench::analysis {

inline constexpr int kModelDocumentVersion = 1;
inline constexpr const char* kElamFit = "elam";  // SensorModel::model of the paper's

// Text with a newline at its end; the same model gives the same bytes. to_line: on one line without blanks, as stored.
std::string to_text(const SensorModel& model);
std::string to_line(const SensorModel& model);
std::string sha256_of(const SensorModel& model);  // of that text
// Throws AnalysisError TB-MODEL-DOCUMENT that says which member of `file` is missing, wrong or of a newer version.
SensorModel document_from_text(const std::string& text, const std::string& file);

// MODEL of the command line: the path of a .json, or RUN[:FIT] in `store` (nullptr: paths only).
SensorModel load_model(const std::string& model, const db::Models* store);
// The model with its options, as tables name it: "elam", "elam, free run".
std::string label_of(const SensorModel& model);

// Writes the model to the store; returns the fit's number. It is the default fit of its run (db::FitRecord::stands) if
// it is the dynamic model, or ELAM in the paper's mode of the whole array on all sequences. `made_by`: build and class
// of processor.
std::int64_t store_fit(db::RunStore& store, const SensorModel& model, const std::string& program_version,
                       const std::string& utc, const std::string& made_by = {});
// What is stored, as it was written. Throws AnalysisError TB-MODEL-STORED.
SensorModel document_of(const db::FitRecord& record);
// The same with the run's and the fit's number in this store. Of a run: its standing fit, TB-ANALYSIS-NO-FIT when it
// has none.
SensorModel load_fit(const db::FitRecord& record);
SensorModel load_fit(const db::Models& store, std::int64_t run);

// Additional members of a dynamic model's document: "dynamics", and three members per taxel.
nlohmann::ordered_json dynamics_json(const SensorDynamics& dynamics);
// The readers throw std::invalid_argument that names the member that is missing, of another kind or out of range.
SensorDynamics dynamics_from(const nlohmann::ordered_json& json);

void add_taxel_dynamics(const ModelTaxel& taxel, nlohmann::ordered_json& json);
void read_taxel_dynamics(const nlohmann::ordered_json& json, ModelTaxel& taxel);

// Compares stored fits and verdicts with those recomputed from the raw frames, for `verify`. They are equal bit for bit
// on the same build and class of processor; elsewhere numbers may differ by kRelativeTolerance.
inline constexpr double kRelativeTolerance = 1e-12;

// |a - b| <= tolerance x max(|a|, |b|); any two NaN are equal, and so are 0.0 and -0.0.
bool same_number(double a, double b, double tolerance);

// Text of the first difference; empty: none. Fits: two documents (model_document.h). With tolerance 0 their numbers are
// compared bit by bit.
std::string first_difference(const std::string& stored, const std::string& recomputed, double tolerance);
std::string first_difference(const std::vector<db::VerdictRecord>& stored,
                             const std::vector<db::VerdictRecord>& recomputed, double tolerance, bool with_u = true);

}  // namespace tactbench::analysis
