// Resolves the calibration of an instrument in one place for every section of a report, its data and every verb: from
// what the run stored with the device and what a laboratory file states for its serial number.
// Precedence, field by field: the run's stored value, which its hash covers and verdicts rest on. The laboratory file
// fills in what the run leaves open. Of two due dates the earlier one counts. Where both state something else,
// `remarks` says so. An invalid date and a value that still says FILL-IN count as not stated.
// And the uncertainty of the instruments other than the pressure reference (reference_uncertainty.h): force sensor,
// thermometer. Rows by JCGM 100.
#pragma once

#include <chrono>
#include <cmath>
#include <numbers>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "analysis/dataset.h"
#include "analysis/identify/sensor_model.h"
#include "analysis/pressure_unit.h"
#include "db/record.h"

namespace tactbench::analysis {

// Typed in a laboratory file for the instrument with this serial number.
struct InstrumentNote {
  std::string serial, certificate, calibrated_by, calibrated_on, due, note;  // dates as 2026-01-31
};

enum class DueState { kNotStated, kInDate, kOverdue };

// U of an instrument's certificate.
struct StatedU {
  double expanded = 0.0, factor = 2.0;
  std::string unit;            // psi, N, mm, K
  bool of_correction = false;  // then it is the largest of its points
};
// "U 0.05 psi (k = 2)"; pressures in `unit`.
std::string display_text(const StatedU& stated, PressureUnit unit);

struct InstrumentCalibration {
  std::string role, model, serial;                             // serial: empty where it was never filled in
  std::string certificate, calibrated_by, calibrated_on, due;  // dates as 2026-01-31; empty: not stated
  std::optional<StatedU> stated_u;
  std::string note;
  std::vector<std::string> remarks;  // what was not taken and why, one sentence each
  [[nodiscard]] bool traceable() const { return !certificate.empty(); }
};

// Never throws: what cannot be read is not stated.
InstrumentCalibration calibration_of(const db::DeviceRecord& device, std::span<const InstrumentNote> notes = {});

// On the day that `utc` begins with, the last day of validity included. A text that is not a date is not after any
// date.
DueState due_state(const InstrumentCalibration& calibration, std::string_view utc);

// How many times its stated limit of change an instrument may be off on that day, at least 1: the time since the
// calibration over the interval that the limit holds for. The interval goes from the calibration date to the due date;
// it is a year where one of them is not stated. Without both: 1.
double drift_growth(const InstrumentCalibration& calibration, std::string_view utc);

// "2026-01-31", with or without a time ("2026-01-31T12:00:00Z"); none for days that do not exist.
std::optional<std::chrono::sys_days> day_of(std::string_view text);
bool is_date(std::string_view text);  // "2026-01-31" alone

// A template's "FILL-IN" that was not replaced.
bool is_placeholder(std::string_view text);
// The calibration as it is stored, without what was never filled in.
std::string without_placeholders(const std::string& calibration_json);

// Serial number of the scanner electronics: of the scanner that answered in the run, else the one that the sensor was
// registered with when the run began, else the one that it is registered with now.
std::string scanner_serial_of(const db::RunRecord& run, const std::optional<db::SensorRecord>& sensor = {});

// Why errors of a run relative to the pressure reference are not traceable.
// Overdue, or else beyond what the reference's certificate covers.
struct TraceabilityGap {
  std::string overdue_since = {};                // "2026-01-31"; empty: in date
  double run_low_psi = 0.0, run_high_psi = 0.0;  // levels of the run
  double low_psi = 0.0, high_psi = 0.0;          // covered
  bool below = false, above = false;             // where the run goes beyond
  bool corrected = false;                        // covered by a correction, of readings from ... to:
  double first_reading_psi = 0.0, last_reading_psi = 0.0;
  friend bool operator==(const TraceabilityGap&, const TraceabilityGap&) = default;
};

// "reference overdue since 2026-01-31"; "levels above 50 psi are not traceable: the run goes from 0 to 60 psi, the
// reference's certificate covers 0 to 50 psi".
std::string display_text(const TraceabilityGap& untraced, PressureUnit unit);

// Of what the certificate speaks: the sensing element by itself, or with what reads it, as it was in the run.
enum class CertificateCovers { kNotStated, kChain, kTransducer };
CertificateCovers covers_of(const db::DeviceRecord& device);
const char* display_text(CertificateCovers covers);  // "the whole chain", "the transducer alone", "not stated"

// Why a part of the chain has no row of its own. `from`: it needs none, and why. Both empty: it has one.
struct ChainPart {
  std::string missing, from;
};
// Of a part whose half-width is stated (> 0) or not. `key`: where it would be stated. `known`: the certificate's U is.
ChainPart chain_part(CertificateCovers covers, double half_width, bool known, std::string_view key);

struct InstrumentRow {
  std::string name, distribution;
  double width = 0.0, divisor = 1.0;
  ChainPart part;
  [[nodiscard]] double u() const { return width / divisor; }
  [[nodiscard]] bool assessed() const { return part.missing.empty() && part.from.empty(); }
};

struct InstrumentUncertainty {
  std::string unit;  // N | K; empty: no such instrument took part
  CertificateCovers covers = CertificateCovers::kNotStated;
  std::vector<InstrumentRow> rows;                             // certificate, drift, input that reads it
  [[nodiscard]] double u() const;                              // of the assessed rows; 0: none is
  [[nodiscard]] double expanded() const { return 2.0 * u(); }  // k = 2: all rows have infinite degrees of freedom
  [[nodiscard]] bool complete() const;                         // no row is missing
};

// Of the run's first device whose role begins with `role`: "force sensor" or "temperature_c". On the run's day. Never
// throws.
InstrumentUncertainty instrument_uncertainty(const db::RunRecord& run, std::string_view role,
                                             std::span<const InstrumentNote> notes = {});

// Contribution of temperature to the uncertainty of a reading: the change of the output per kelvin, from runs of one
// sensor at several temperatures, over the temperatures of the calibration. Datasets in, a coefficient with its
// standard uncertainty out, used by the uncertainty budgets.
inline constexpr double kOtherTemperatureK = 2.0;  // means of two runs' readings that differ by this are two

// A change of the output: `zero_v` volts, and `share` of the output over its zero.
struct OutputChange {
  double zero_v = 0.0, share = 0.0;
};

struct TemperatureEffect {
  std::string not_assessed = "no run of this sensor at another temperature shows its effect";  // empty: assessed
  std::vector<double> temperature_c;  // of each run, the calibration first: mean of its readings
  // Of the mean taxel over its external loop, against as many first repeats of the calibration.
  std::vector<OutputChange> change;
  // A kelvin, of the mean taxel: slope of the above over temperature. u: the larger of what the scatter of the repeats
  // and the scatter of the runs about the line give. deviation: of single taxels' own slopes from the mean's.
  OutputChange per_kelvin, u, deviation;
  bool from_repeats = true;  // u is that of the repeats: two runs, or runs that lie on a line as well as repeats do
  double dof = 0.0;          // of u
  double low_c = 0.0, high_c = 0.0, resolution_c = 0.0;  // of the calibration's readings
  double thermometer_u_c = 0.0;                          // of the thermometer's own calibration; 0: not stated
  [[nodiscard]] bool assessed() const { return not_assessed.empty(); }
  // Of a rectangle: the readings' range and step, and what the thermometer itself is off by, of the same variance.
  [[nodiscard]] double half_width_c() const {
    return std::hypot(0.5 * (high_c - low_c + resolution_c), std::numbers::sqrt3 * thermometer_u_c);
  }
  // Half-width in volt at an output so far over its zero: half_width_c times the root of the squares of coefficient,
  // its u and the taxels' deviation.
  [[nodiscard]] double width_v(double over_zero_v) const;
  [[nodiscard]] std::string display_text()
      const;  // what was found, and what is not kept apart; empty when not assessed
};

double mean_temperature_c(const Dataset& dataset);  // NaN without readings
// Both runs have readings, and their means differ by kOtherTemperatureK.
bool at_another_temperature(std::span<const double> calibration_c, std::span<const double> other_c);

// `others`: of the same sensor, mounted once and not aged between, which the caller knows. Throws AnalysisError
// TB-ANALYSIS-OTHER-SENSOR, TB-ANALYSIS-ORIGIN.
TemperatureEffect temperature_effect_of(const Dataset& calibration, std::span<const Dataset> others,
                                        const SensorModel& fit, double resolution_c, double thermometer_u_c = 0.0);

}  // namespace tactbench::analysis
