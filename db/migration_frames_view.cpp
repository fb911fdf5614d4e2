// Schema 7's view of frames: with the raw counts, the wrench and the place, also as numbers.
#include <fmt/format.h>

#include <string>

#include "db/schema.h"

namespace tactbench::db {

namespace {

// SQL for number `index` of a blob of float64le, exact, and NULL where it is not finite; SQLite has no function for it.
// Of the hexadecimal digits (two a byte, lowest byte first) the last two bytes, `top`, hold sign, exponent and the
// mantissa's highest four bits, the six before them, `low`, its other bits (IEEE 754, binary64). The mantissa is a
// whole number below 2^53; powers of two that scale it are whole numbers up to 2^62, three of which reach 2^-186. Below
// that it counts as 0.
std::string number_of(const std::string& blob, int index) {
  const auto digit = [](int position) {  // value of the digit at `position`, from 1
    return fmt::format("(instr('0123456789ABCDEF', substr(h, {}, 1)) - 1)", position);
  };
  const auto byte = [&](int number) {
    return fmt::format("({} * 16 + {})", digit(2 * number + 1), digit(2 * number + 2));
  };
  std::string low;
  for (int i = 0; i < 6; ++i) low += fmt::format("{}({} << {})", i == 0 ? "" : " | ", byte(i), 8 * i);
  return fmt::format(
      "(SELECT CASE WHEN (top >> 4) & 2047 = 0 THEN 0.0 WHEN (top >> 4) & 2047 < 2047 THEN (1 - (top >> 15) * 2) * "
      "((16 | (top & 15)) << 48 | low) * 1.0 "
      "/ (1 << min(max(1075 - ((top >> 4) & 2047), 0), 62)) / (1 << min(max(1013 - ((top >> 4) & 2047), 0), 62)) "
      "/ (1 << min(max(951 - ((top >> 4) & 2047), 0), 62)) * (1 << min(max(((top >> 4) & 2047) - 1075, 0), 62)) END "
      "FROM (SELECT {} << 8 | {} AS top, {} AS low FROM (SELECT hex(substr({}, {}, 8)) AS h)) WHERE {} IS NOT NULL)",
      byte(7), byte(6), low, blob, 8 * index + 1, blob);
}

}  // namespace

std::string frames_view_migration() {
  std::string numbers;
  const char* const wrench[] = {"fx_n", "fy_n", "fz_n", "tx_nmm", "ty_nmm", "tz_nmm"};
  const char* const place[] = {"x_mm", "y_mm", "z_mm"};
  for (int i = 0; const char* name : wrench) numbers += fmt::format(",\n  {} AS {}", number_of("f.wrench", i++), name);
  for (int i = 0; const char* name : place) numbers += fmt::format(",\n  {} AS {}", number_of("f.place_mm", i++), name);
  return fmt::format(R"sql(
DROP VIEW v_frames;
CREATE VIEW v_frames AS
SELECT r.run, f.frame - r.run * 1000000000 AS position, s.name AS recipe, b.sequence, b."repeat", b.ordinal AS branch,
  b.attempt, b.void, b.from_psi, b.to_psi, b.from_n, b.to_n, f.ordinal AS step, f.setpoint_psi,
  f.feedback_psi, f.reference_psi, f.target_n, f.force_start_n, f.setpoint_counts, f.feedback_counts, f.reference_counts,
  f.time_ns, f.time_ns * 1e-9 AS time_s, f.since_command_ns, f.in_band_ns, f.flags, f.device_time_us, f.status,
  f.exchanges, f.dtype, f."rows", f.columns, f.scans, f.counts,
  (SELECT CASE WHEN instr(d.calibration_json, '"volts_per_count":') > 0 THEN nullif(CAST(substr(d.calibration_json,
    instr(d.calibration_json, '"volts_per_count":') + 18) AS REAL), 0.0) END  -- JSON's functions are refused in views
    FROM devices d WHERE d.run = r.run AND d.role = 'tactile scanner' ORDER BY d.position LIMIT 1) AS volts_per_count{},
  f.wrench_raw, length(f.trace) / 16 AS polls, lower(hex(f.chain)) AS chain_sha256
FROM runs r
JOIN frames f ON f.frame BETWEEN r.run * 1000000000 + 1 AND r.run * 1000000000 + 999999999
JOIN branches b ON b.branch = f.branch
JOIN sequences s ON s.run = b.run AND s.sequence = b.sequence;
)sql",
                     numbers);
}

}  // namespace tactbench::db
