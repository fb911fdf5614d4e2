#include <algorithm>
#include <cmath>
#include <cstring>
#include <memory>
#include <new>
#include <stdexcept>
#include <vector>

#include "analysis/compensate/compensator_handle.h"
#include "analysis/compensate/everett.h"

using namespace tactbench::analysis;

namespace {

// Version 1's structs; later ones are longer.
constexpr std::size_t kDynamicSetupSize = sizeof(tb_dynamic_setup), kDynamicTaxelSize = sizeof(tb_dynamic_taxel);

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
  setup.observer.share = given.top_share < 0.0 ? 0.0 : or_default(given.top_share, setup.observer.share);
  return setup;
}

}  // namespace

int tb_compensator_create_dynamic(const tb_dynamic_setup* setup, const tb_dynamic_taxel* taxels,
                                  tb_compensator** handle, char* message, size_t message_size) {
  (void)refuse(0, "", message, message_size);
  if (handle == nullptr) return refuse(TB_COMPENSATOR_NULL, "handle is null", message, message_size);
  *handle = nullptr;
  if (setup == nullptr || taxels == nullptr)
    return refuse(TB_COMPENSATOR_NULL, "setup or taxels is null", message, message_size);
  if (setup->struct_size < kDynamicSetupSize)
    return refuse(TB_COMPENSATOR_SIZE, "setup.struct_size is below version 1's", message, message_size);
  if (setup->taxels == 0 || setup->intervals < 1 || setup->intervals > 100)
    return refuse(TB_COMPENSATOR_SIZE, "no taxels, or not 1 to 100 intervals", message, message_size);
  const std::size_t step = taxels->struct_size;
  if (step < kDynamicTaxelSize || step % alignof(tb_dynamic_taxel) != 0)
    return refuse(TB_COMPENSATOR_SIZE, "taxel.struct_size is below version 1's", message, message_size);
  try {
    std::vector<tb_dynamic_taxel> own(setup->taxels);
    for (std::size_t i = 0; i < own.size(); ++i) {
      std::memcpy(&own[i], reinterpret_cast<const char*>(taxels) + i * step, kDynamicTaxelSize);
      if (own[i].struct_size != step)
        return refuse(TB_COMPENSATOR_SIZE, "the taxels' struct_size differ", message, message_size);
      if ((own[i].flags & TB_TAXEL_USABLE) != 0 && own[i].everett == nullptr)
        return refuse(TB_COMPENSATOR_NULL, "a usable taxel's table is null", message, message_size);
    }
    const DynamicSetup made = setup_of(*setup, own);
    auto compensator = std::make_unique<tb_compensator>();
    compensator->status_spare.resize(setup->taxels);
    if ((setup->flags & TB_COMPENSATOR_DOUBLE) != 0) {
      compensator->dynamic_whole.emplace(made);
      compensator->whole_spare.resize(2 * setup->taxels);
    } else {
      compensator->dynamic_single.emplace(made);
      compensator->single_spare.resize(2 * setup->taxels);
    }
    *handle = compensator.release();
    return TB_COMPENSATOR_OK;
  } catch (const std::bad_alloc&) {
    return refuse(TB_COMPENSATOR_MEMORY, "not enough memory", message, message_size);
  } catch (const std::exception& fault) {
    return refuse(TB_COMPENSATOR_VALUE, fault.what(), message, message_size);
  }
}

int tb_compensator_set_interval(tb_compensator* handle, double seconds) {
  if (handle == nullptr) return TB_COMPENSATOR_NULL;
  if (!std::isfinite(seconds) || seconds < 0.0) return TB_COMPENSATOR_VALUE;
  if (handle->dynamic_single) handle->dynamic_single->set_interval(seconds);
  if (handle->dynamic_whole) handle->dynamic_whole->set_interval(seconds);
  return TB_COMPENSATOR_OK;
}
