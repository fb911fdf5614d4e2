#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <utility>
#include <vector>

#include "analysis/compensate/compensator_handle.h"
#include "analysis/compensate/everett.h"

using namespace tactbench::analysis;

namespace {

// The least of version 1's structs; later ones are longer.
constexpr std::size_t kDynamicSetupSize = offsetof(tb_dynamic_setup, worked_seconds),
                      kDynamicTaxelSize = sizeof(tb_dynamic_taxel);

DynamicTaxel taxel_of(const tb_dynamic_taxel& given, std::size_t intervals) {
  DynamicTaxel taxel;
  taxel.usable = (given.flags & TB_TAXEL_USABLE) != 0;
  if (!taxel.usable) return taxel;
  taxel.divider = {given.zero_volts, given.per_amplitude};
  taxel.everett.assign(given.everett, given.everett + Everett<double>::size(intervals));
  taxel.creep_scale = or_default(given.creep_scale, 1.0);
  taxel.lag_share = given.lag_share;
  taxel.noise_v = given.noise_volts;
  taxel.residual_scale = or_default(given.residual_scale, 1.0);
  taxel.falling = (given.flags & TB_TAXEL_FALLING) != 0;
  return taxel;
}

DynamicSetup setup_of(const tb_dynamic_setup& given, const std::vector<tb_dynamic_taxel>& taxels) {
  DynamicSetup setup;
  setup.x_low = given.pressure_low;
  setup.x_high = given.pressure_high;
  setup.intervals = given.intervals;
  for (const tb_dynamic_taxel& taxel : taxels) setup.taxels.push_back(taxel_of(taxel, given.intervals));
  setup.volts_per_count = given.volts_per_count;
  setup.options.flat_psi = or_default(given.flat_pressure, setup.options.flat_psi);
  setup.options.known_psi = or_default(given.known_pressure, setup.options.known_psi);
  setup.tare_share = or_default(given.tare_share, setup.tare_share);
  setup.start_unknown = (given.flags & TB_COMPENSATOR_START_AT_REST) == 0;
  if (given.longest_gap != 0) setup.longest_gap = static_cast<int>(std::min(given.longest_gap, 0x7fffffffU));
  if (given.residual != nullptr) setup.residual_psi.assign(given.residual, given.residual + 2 * given.intervals);
  Dynamics& d = setup.dynamics;
  for (std::size_t j = 0; j < kCreepElements; ++j) {
    d.creep_share[j] = given.creep_share[j];
    if (given.creep_share[j] != 0.0 || given.creep_seconds[j] != 0.0) d.creep_s[j] = given.creep_seconds[j];
  }
  d.creep_half = or_default(given.creep_half, d.creep_half);
  d.lag_s = or_default(given.lag_seconds, d.lag_s);
  if (given.struct_size >= sizeof(tb_dynamic_setup)) setup.worked_s = given.worked_seconds;
  setup.observer.share = given.top_share < 0.0 ? 0.0 : or_default(given.top_share, setup.observer.share);
  return setup;
}

}  // namespace

int tb_compensator_create_dynamic(const tb_dynamic_setup* setup, const tb_dynamic_taxel* taxels,
                                  tb_compensator** handle, char* message, size_t message_size) {
  const auto wrong = [](const tb_dynamic_setup& given) -> std::pair<int, const char*> {
    if (given.taxels == 0 || given.intervals < 1 || given.intervals > 100)
      return {TB_COMPENSATOR_SIZE, "no taxels, or not 1 to 100 intervals"};
    return {TB_COMPENSATOR_OK, ""};
  };
  const auto missing = [](const tb_dynamic_taxel& taxel) {
    return taxel.everett == nullptr ? "a usable taxel's table is null" : nullptr;
  };
  return create_handle(setup, kDynamicSetupSize, taxels, kDynamicTaxelSize, wrong, missing, setup_of,
                       &tb_compensator::dynamic_whole, &tb_compensator::dynamic_single, handle, message, message_size);
}

int tb_compensator_set_interval(tb_compensator* handle, double seconds) {
  if (handle == nullptr) return TB_COMPENSATOR_NULL;
  if (!std::isfinite(seconds) || seconds < 0.0) return TB_COMPENSATOR_VALUE;
  if (handle->dynamic_single) handle->dynamic_single->set_interval(seconds);
  if (handle->dynamic_whole) handle->dynamic_whole->set_interval(seconds);
  return TB_COMPENSATOR_OK;
}
