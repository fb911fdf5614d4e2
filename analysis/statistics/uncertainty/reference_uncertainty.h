// Uncertainty of the pressure reference itself, from the calibration stored with the run's devices.
#pragma once

#include <array>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "analysis/statistics/uncertainty/instruments.h"
#include "db/record.h"

namespace tactbench::analysis {

// What the certificate of a transducer by itself does not contain. Each is stated as a limit, the half-width of a
// rectangle (4.3.7); of the voltage input in volts, times the transducer's psi a volt.
enum class ReferencePart { kVoltageInput, kHysteresis, kZero, kTemperature };
inline constexpr std::size_t kReferenceParts = 4;

struct ReferenceLimit {
  double half_width_psi = 0.0;
  ChainPart part;
};

// One contribution of the reference's own error: u(x) = width / divisor, c = 1, without degrees of freedom to count.
struct ReferenceRow {
  std::size_t source = 0;  // as UncertaintySource: 0 certificate, 1 drift, 2 resolution, then by ReferencePart
  double width_psi = 0.0, divisor = 1.0, u_psi = 0.0;
};

struct ReferenceUncertainty {
  InstrumentCalibration calibration;  // certificate, dates
  bool independent = false;           // false: the regulator's feedback is used
  bool overdue = false;               // the run began after the due date
  // Certificate: U (psi, with coverage factor k) at readings, rising; empty: none.
  std::vector<double> reading_psi, expanded_psi;
  double coverage_factor = 2.0;
  // Pressures that it holds for; no ends: it states none.
  double low_psi = -std::numeric_limits<double>::infinity(), high_psi = std::numeric_limits<double>::infinity();
  std::optional<TraceabilityGap> beyond;  // pressures of the run lie outside, not traceable
  double drift_stated_psi = 0.0;          // limit of the change from calibration to due date; 0: not stated
  double drift_psi = 0.0;                 // limit on the run's day: the stated one, times drift_growth(); never less
  std::string drift_basis;                // the same in words
  double resolution_psi = 0.0;            // one digit or one converter step; 0: not known
  CertificateCovers covers = CertificateCovers::kNotStated;
  std::array<ReferenceLimit, kReferenceParts> limits;  // by ReferencePart
  [[nodiscard]] const ReferenceLimit& limit(ReferencePart part) const { return limits[static_cast<std::size_t>(part)]; }
  // Why a contribution is not assessed; empty where it is.
  std::string certificate_missing, drift_missing, resolution_missing;

  // Within 1 % of the range beyond its ends, by which a regulator misses its set-point, counts as held.
  [[nodiscard]] bool holds_at(double pressure_psi) const;
  // Why errors against the reference are not traceable: overdue, or beyond the certificate; none: they are.
  [[nodiscard]] std::optional<TraceabilityGap> untraced() const;
  // u(p) = U(p) / k in psi (JCGM 100, 4.3.3), between the certificate's points linear, beyond them the last one's.
  [[nodiscard]] double certificate_u(double pressure_psi) const;
  [[nodiscard]] double largest_certificate_u() const;
  // What is stated, with the certificate's u and the drift's limit as given: the one sum that budgets, verdicts and
  // combined_u() share.
  [[nodiscard]] std::vector<ReferenceRow> rows(double certificate_u_psi, double drift_limit_psi) const;
  // Of all that is stated, at a pressure.
  [[nodiscard]] double combined_u(double pressure_psi) const;
};

// From the device of role "pressure reference" and the analog module that reads it. The run's own date rules. Never
// throws: what cannot be read is not assessed.
ReferenceUncertainty reference_uncertainty(const db::RunRecord& run, std::span<const InstrumentNote> notes = {});
// Volts a count of the run's tactile scanner; 0 where that is not kept.
double scanner_step_v(const db::RunRecord& run);

}  // namespace tactbench::analysis
