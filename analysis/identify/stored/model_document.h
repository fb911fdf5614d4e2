// A stored model: one JSON document, complete in itself. It says what was fitted on what, and carries for each taxel
// all that predicting and compensating need. Schema "tactbench.model", version 1, described in analysis/README.md.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "analysis/compensate/frame_setup.h"
#include "analysis/identify/elam/identify.h"
#include "analysis/identify/fit_data.h"
#include "analysis/identify/histories.h"

namespace tactbench::analysis {

inline constexpr int kModelDocumentVersion = 1;
inline constexpr double kBandInNoises = 6.0;  // dead band of compensation, in standard deviations of a sample

// Where the model was fitted, so that use elsewhere can be flagged. Absent: not known.
struct Range {
  double low = 0.0, high = 0.0;
  [[nodiscard]] bool contains(double value, double slack = 0.0) const;
  void widen(double value);
};
// How far beyond a range an input is still inside it, of its length: what a rig does not repeat any better.
inline constexpr double kInputSlack = 0.02;
inline constexpr double kTemperatureSlack = 1.0;  // degC
struct Validity {
  std::optional<Range> input, hold_s, rate, temperature_c;  // rate: input units a second
  std::string mount, interface_material;
};

Validity validity_of(const std::vector<History>& histories, const std::vector<double>& temperatures_c);

struct ModelTaxel {
  int taxel = 0;
  std::string status = "fitted";  // or why it was not
  double noise = 0.0;             // standard deviation of a sample; 0: not known
  double loop_low = 0.0;  // output at the lowest input of the external loop; fit.full_scale above is its highest
  double zero = 0.0, gain = 1.0;  // output = zero + gain x the model's: adjustments since the fit
  ModelFit fit;                   // figures, and the model unless the status says otherwise
};

struct ModelDocument {
  std::string model;  // elam, gpi, mpi, poly, preisach, monotone
  IdentifyOptions options;
  std::string source, origin, content_sha256;
  std::vector<std::string> sequences;  // that were fitted
  std::string sensor_serial, scanner_serial, input_unit, output_unit, program_version;
  int rows = 1, columns = 1, scans = 1;  // scans: averaged into a sample, of which the noise is
  bool falling = false;                  // the model is one of the negated output [A20]
  Validity validity;
  std::string parent_sha256, adjustment;  // of a child: its parent's document, and what was adjusted by what
  std::vector<ModelTaxel> taxels;

  [[nodiscard]] const ModelTaxel& taxel(int number) const;  // AnalysisError TB-MODEL-TAXEL
  // Outputs as measured and as the model's own speak of them.
  [[nodiscard]] double to_model(const ModelTaxel& taxel, double output) const;
  [[nodiscard]] double from_model(const ModelTaxel& taxel, double output) const;
};

// Fits `model` to every taxel on the named sequences (empty: all); threads by taxel, the result does not depend on
// their number. A taxel that cannot carry the model gets the reason as its status. Throws AnalysisError.
ModelDocument fit_models(const std::string& model, const Histories& histories,
                         const std::vector<std::string>& sequences, const IdentifyOptions& options, int threads = 0);

// Text with a newline at its end; the same model gives the same bytes.
std::string to_text(const ModelDocument& document);
std::string sha256_of(const ModelDocument& document);  // of that text
// Throws AnalysisError TB-MODEL-DOCUMENT that says which member of `file` is missing, wrong or of a newer version.
ModelDocument document_from_text(const std::string& text, const std::string& file);

// In what the named sequences (empty: all) of `used` lie outside the model's validity, a line each: serials, inputs
// beyond 2 % of the range, holds and rates beyond 10 %, temperatures beyond 1 degC. What either does not know is
// passed.
std::vector<std::string> outside_validity(const ModelDocument& model, const Histories& used,
                                          const std::vector<std::string>& sequences = {});

// What the frame compensator of an array needs. Throws AnalysisError TB-MODEL-COMPENSATOR when the model is not ELAM
// with one split point a branch and without memory, or not of an array.
FrameSetup frame_setup_of(const ModelDocument& document, double volts_per_count);

// The same models as a fit of the whole array, adjustments made since included: what evaluate() takes. Throws
// AnalysisError TB-MODEL-COMPENSATOR as frame_setup_of() does.
ArrayFit array_fit_of(const ModelDocument& document);

// MODEL of the command line: the path of a .json, or RUN[:FIT] in `store` (nullptr: paths only).
ModelDocument load_model(const std::string& model, const db::RunStore* store);
// The model with its options, as tables name it: "elam", "elam, free run".
std::string label_of(const ModelDocument& document);
// Returns the fit's number.
std::int64_t store_model(db::RunStore& store, std::int64_t run, const ModelDocument& document, const std::string& utc);

}  // namespace tactbench::analysis
