#include "analysis/statistics/uncertainty/instrument_uncertainty.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "analysis/json_io.h"

namespace tactbench::analysis {
namespace {

using InstrumentJson = nlohmann::json;

double limit_in(const InstrumentJson& json, const std::string& key) {
  if (!json.is_object() || !json.contains(key) || !json[key].is_number()) return 0.0;
  return std::max(0.0, json[key].get<double>());  // JSON has no number that is not finite
}

}  // namespace

CertificateCovers covers_of(const db::DeviceRecord& device) {
  const InstrumentJson json = try_json(device.calibration_json);
  if (!json.is_object() || !json.contains("certificate_covers") || !json["certificate_covers"].is_string())
    return CertificateCovers::kNotStated;
  const std::string word = json["certificate_covers"].get<std::string>();
  return word == "chain"        ? CertificateCovers::kChain
         : word == "transducer" ? CertificateCovers::kTransducer
                                : CertificateCovers::kNotStated;
}

const char* display_text(CertificateCovers covers) {
  return covers == CertificateCovers::kChain        ? "the whole chain"
         : covers == CertificateCovers::kTransducer ? "the transducer alone"
                                                    : "not stated";
}

ChainPart chain_part(CertificateCovers covers, double half_width, bool known, std::string_view key) {
  if (half_width > 0.0) return {};
  if (!known) return {"no U of a certificate is stated, which could contain it", {}};
  if (covers == CertificateCovers::kChain) return {{}, "contained in the certificate, which covers the whole chain"};
  if (covers == CertificateCovers::kTransducer)
    return {fmt::format("the bench file gives no limit for it: {}", key), {}};
  return {"not recorded what the certificate covers, the whole chain or the transducer alone", {}};
}

double InstrumentUncertainty::u() const {
  double squares = 0.0;
  for (const InstrumentRow& row : rows)
    if (row.assessed()) squares += row.u() * row.u();
  return std::sqrt(squares);
}

bool InstrumentUncertainty::complete() const {
  return !rows.empty() && std::ranges::all_of(rows, [](const InstrumentRow& row) { return row.part.missing.empty(); });
}

InstrumentUncertainty instrument_uncertainty(const db::RunRecord& run, std::string_view role,
                                             std::span<const InstrumentNote> notes) {
  InstrumentUncertainty out;
  const auto device =
      std::ranges::find_if(run.devices, [&](const db::DeviceRecord& record) { return record.role.starts_with(role); });
  if (device == run.devices.end()) return out;
  const bool force = role.starts_with("force");
  const std::string ending = force ? "_n" : "_c", table = force ? "[force]" : "[[environment.sensor]]";
  const InstrumentJson json = try_json(device->calibration_json);
  out.unit = force ? "N" : "K";
  out.covers = covers_of(*device);
  const double expanded = limit_in(json, "expanded_uncertainty" + ending);
  const double drift = limit_in(json, "drift" + ending), input = limit_in(json, "input_limit" + ending);
  const auto not_stated = [&](const char* key) {
    return ChainPart{fmt::format("the bench file gives no limit for it: {} {}{}", table, key, ending), {}};
  };
  out.rows.push_back(
      {"certificate", "normal", expanded, 2.0, expanded > 0.0 ? ChainPart() : not_stated("expanded_uncertainty")});
  out.rows.push_back({"drift", "rectangular", drift * drift_growth(calibration_of(*device, notes), run.started_utc),
                      std::numbers::sqrt3, drift > 0.0 ? ChainPart() : not_stated("drift")});
  out.rows.push_back({"input that reads it", "rectangular", input, std::numbers::sqrt3,
                      chain_part(out.covers, input, expanded > 0.0, table + " input_limit" + ending)});
  return out;
}

}  // namespace tactbench::analysis
