// The output before correction and the sensor's health as data, and the hash of models.
#include <array>
#include <nlohmann/json.hpp>
#include <span>

#include "analysis/json_fields.h"
#include "analysis/models/model_json.h"
#include "analysis/report/data/data.h"
#include "analysis/report/data/section_data.h"
#include "analysis/report/parts.h"
#include "db/run_store.h"

namespace tactbench::analysis {

std::string behaviour_json(const ReportInput& input) {
  const Behaviour& b = input.behaviour;
  nlohmann::ordered_json loops = nlohmann::ordered_json::array(), traces = nlohmann::ordered_json::array(),
                         repeatability = nlohmann::ordered_json::array(), zero = nlohmann::ordered_json::array(),
                         creep = nlohmann::ordered_json::array();
  for (const RawLoop& loop : b.loops)
    loops.push_back({JSON_FIELDS(loop, name, taxel, full_scale_v),
                     {"hysteresis_max_fs", loop.hysteresis_max},
                     {"hysteresis_mean_fs", loop.hysteresis_mean},
                     {"up_v", number_list(loop.up_v)},
                     {"down_v", number_list(loop.down_v)}});
  for (const RawTrace& trace : b.traces)
    traces.push_back({{"sequence", trace.sequence},
                      {"pressure_psi", number_list(trace.pressure_psi)},
                      {"output_v", number_list(trace.output_v)}});
  for (const LevelRepeatability& level : b.repeatability)
    repeatability.push_back({JSON_FIELDS(level, pressure_psi, mean_up_v, mean_down_v, taxel_up_v, taxel_down_v)});
  for (const ZeroReturn& z : b.zero_returns)
    zero.push_back({JSON_FIELDS(z, sequence, repeats, mean_v, largest_v, worst_taxel_v, worst_taxel)});
  for (const Creep& c : b.creep)
    creep.push_back({JSON_FIELDS(c, sequence, pressure_psi),
                     {"branch", c.up ? "up" : "down"},
                     JSON_FIELDS(c, from_s, to_s, first_v, last_v, per_decade, per_decade_u, samples)});
  return json_text({{"taxels", b.taxels},
                    {"pressure_psi", number_list(b.pressure_psi)},
                    {"full_scale_v", b.full_scale_v},
                    {"loops", loops},
                    {"hysteresis_max_fs", number_list(b.hysteresis_max)},
                    {"hysteresis_mean_fs", number_list(b.hysteresis_mean)},
                    {"traces", traces},
                    {"equilibration_psi", b.equilibration_psi},
                    {"gain", number_list(b.gain)},
                    {"repeats", b.repeats},
                    {"repeatability", repeatability},
                    {"zero_return", zero},
                    {"creep", creep}});
}

std::string health_json(const ReportInput& input) {
  const Health& health = input.health;
  nlohmann::ordered_json findings = nlohmann::ordered_json::array(), swaps = nlohmann::ordered_json::array();
  for (const TaxelHealth& finding : health.findings)
    findings.push_back({JSON_FIELDS(finding, taxel, state, reason, excluded)});
  for (const SwappedLines& swap : health.swaps)
    swaps.push_back({{"lines", swap.rows ? "rows" : "columns"},
                     JSON_FIELDS(swap, first, second),
                     {"correlation_as_is", swap.as_is},
                     {"correlation_exchanged", swap.exchanged}});
  return json_text({JSON_FIELDS(health.options, dead_v, noisy_factor),
                    {"median_noise_v", health.median_noise_v},
                    {"low_v", number_list(health.low_v)},
                    {"high_v", number_list(health.high_v)},
                    {"noise_v", number_list(health.noise_v)},
                    {"findings", findings},
                    {"swaps_assessed", health.swaps_assessed},
                    {"swaps", swaps}});
}

std::string model_sha256(const SensorModel& fit) {
  std::string bytes;
  const bool is_elam = paper_elam_of(fit.mean_taxel()) != nullptr;
  const auto add = [&](std::span<const double> values) {
    bytes.append(reinterpret_cast<const char*>(values.data()), values.size_bytes());
  };
  const auto add_taxel = [&](const ModelTaxel& taxel) {
    bytes += to_string(taxel.status);
    if (const ElamModel* const elam = paper_elam_of(taxel)) {
      const ElamParameters& p = elam->parameters;
      add(std::array{p.alpha_d, p.beta_d, p.alpha_a1, p.alpha_a0, p.beta_a});
    } else if (taxel.fit.model != nullptr) {
      bytes += model_json(*taxel.fit.model).dump();
    } else if (is_elam) {
      add(std::array{0.5, 0.5, 0.0, 0.5, 0.5});  // as reports have counted a taxel without a model
    }
    for (const PatternCurve* curve : {&taxel.ascending, &taxel.descending}) add(curve->y());
    if (fit.dynamics) add(std::array{taxel.creep_scale, taxel.lag_share, taxel.residual_psi});
  };
  bytes.reserve((fit.array().size() + 1) * 32 * (fit.pressure_psi.size() + 3));
  add(fit.pressure_psi);
  add_taxel(fit.mean_taxel());
  for (const ModelTaxel& taxel : fit.array()) add_taxel(taxel);
  if (fit.dynamics) {
    const Dynamics& d = fit.dynamics->shared;
    add(d.creep_s);
    add(d.creep_share);
    add(std::array{d.creep_half, d.lag_s, d.lag_share});
    add(fit.dynamics->residual_shape);
  }
  return db::sha256_hex(bytes);
}

}  // namespace tactbench::analysis
