// Uncertainty of the instruments other than the pressure reference: force sensor, thermometer. Rows by JCGM 100 from
// the calibration stored with the run's devices; and what a certificate covers.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "analysis/statistics/uncertainty/instrument_calibration.h"
#include "db/record.h"

namespace tactbench::analysis {

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

}  // namespace tactbench::analysis
