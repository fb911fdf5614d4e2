#include "analysis/compensate/compensator_c.h"

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <utility>
#include <vector>

#include "analysis/compensate/compensator_handle.h"

using namespace tactbench::analysis;

static_assert(static_cast<int>(TB_TAXEL_VALID) == kTaxelValid && static_cast<int>(TB_TAXEL_FLAT) == kTaxelFlat &&
              static_cast<int>(TB_TAXEL_OUT_OF_RANGE) == kTaxelOutOfRange &&
              static_cast<int>(TB_TAXEL_DEAD) == kTaxelDead && static_cast<int>(TB_TAXEL_OUTSIDE) == kTaxelOutside &&
              static_cast<int>(TB_TAXEL_UNKNOWN) == kTaxelUnknown && static_cast<int>(TB_TAXEL_LOST) == kTaxelLost);

namespace {

// The least of version 1's structs; later ones are longer.
constexpr std::size_t kSetupSize = offsetof(tb_compensator_setup, residual_levels),
                      kTaxelSize = offsetof(tb_compensator_taxel, residual);
constexpr std::size_t kMostLevels = 1000;

std::size_t levels_of(const tb_compensator_setup& given) {
  return given.struct_size >= sizeof(tb_compensator_setup) ? given.residual_levels : 0;
}

TaxelSetup taxel_of(const tb_compensator_taxel& given, std::size_t knots, std::size_t levels) {
  TaxelSetup taxel;
  taxel.usable = (given.flags & TB_TAXEL_USABLE) != 0;
  if (!taxel.usable) return taxel;
  taxel.ascending_v.assign(given.ascending, given.ascending + knots);
  taxel.descending_v.assign(given.descending, given.descending + knots);
  taxel.parameters = {given.alpha_d, given.beta_d, given.alpha_a1, given.alpha_a0, given.beta_a};
  taxel.noise_v = given.noise_volts;
  taxel.falling = (given.flags & TB_TAXEL_FALLING) != 0;
  if (given.residual != nullptr) taxel.residual_psi.assign(given.residual, given.residual + 2 * levels);
  return taxel;
}

FrameSetup setup_of(const tb_compensator_setup& given, const std::vector<tb_compensator_taxel>& taxels) {
  FrameSetup setup;
  setup.pressure_psi.assign(given.pressure, given.pressure + given.knots);
  for (const tb_compensator_taxel& taxel : taxels)
    setup.taxels.push_back(taxel_of(taxel, given.knots, levels_of(given)));
  setup.volts_per_count = given.volts_per_count;
  setup.elam.exact_outer = (given.flags & TB_COMPENSATOR_EXACT_OUTER) != 0;
  setup.options.flat_psi = or_default(given.flat_pressure, setup.options.flat_psi);
  setup.options.known_psi = or_default(given.known_pressure, setup.options.known_psi);
  setup.start_unknown = (given.flags & TB_COMPENSATOR_START_AT_REST) == 0;
  setup.tare_share = or_default(given.tare_share, setup.tare_share);
  if (given.longest_gap != 0) setup.longest_gap = static_cast<int>(std::min(given.longest_gap, 0x7fffffffU));
  return setup;
}

template <class Real, class Sample>
int run(tb_compensator* handle, const Sample* samples, std::size_t count, Real* pressure, Real* uncertainty,
        std::uint16_t* status) {
  if (handle == nullptr || samples == nullptr || pressure == nullptr) return TB_COMPENSATOR_NULL;
  if (!handle->is<Real>()) return TB_COMPENSATOR_PRECISION;
  if (count != handle->status_spare.size()) return TB_COMPENSATOR_SIZE;
  Real* const doubt = uncertainty != nullptr ? uncertainty : handle->spare<Real>().data();
  std::uint16_t* const bits = status != nullptr ? status : handle->status_spare.data();
  handle->with_real<Real>([&](auto& own) {
    own.frame(std::span<const Sample>(samples, count), {{pressure, count}, {doubt, count}, {bits, count}});
  });
  return TB_COMPENSATOR_OK;
}

}  // namespace

uint32_t tb_compensator_abi_version(void) { return TB_COMPENSATOR_ABI_VERSION; }

int tb_compensator_create(const tb_compensator_setup* setup, const tb_compensator_taxel* taxels,
                          tb_compensator** handle, char* message, size_t message_size) {
  const auto wrong = [](const tb_compensator_setup& given) -> std::pair<int, const char*> {
    if (given.pressure == nullptr) return {TB_COMPENSATOR_NULL, "setup.pressure is null"};
    if (given.taxels == 0 || given.knots < 2) return {TB_COMPENSATOR_SIZE, "no taxels, or fewer than two knots"};
    if (levels_of(given) > kMostLevels) return {TB_COMPENSATOR_SIZE, "more than 1000 residual_levels"};
    return {TB_COMPENSATOR_OK, ""};
  };
  const auto missing = [](const tb_compensator_taxel& taxel) {
    return taxel.ascending == nullptr || taxel.descending == nullptr ? "a usable taxel's pattern is null" : nullptr;
  };
  return create_handle(setup, kSetupSize, taxels, kTaxelSize, wrong, missing, setup_of, &tb_compensator::whole,
                       &tb_compensator::single, handle, message, message_size);
}

void tb_compensator_destroy(tb_compensator* handle) { delete handle; }

size_t tb_compensator_taxels(const tb_compensator* handle) {
  return handle == nullptr ? 0 : handle->status_spare.size();
}

int tb_compensator_counts(tb_compensator* handle, const uint16_t* counts, size_t count, float* pressure,
                          float* uncertainty, uint16_t* status) {
  return run(handle, counts, count, pressure, uncertainty, status);
}
int tb_compensator_counts_double(tb_compensator* handle, const uint16_t* counts, size_t count, double* pressure,
                                 double* uncertainty, uint16_t* status) {
  return run(handle, counts, count, pressure, uncertainty, status);
}
int tb_compensator_volts(tb_compensator* handle, const float* volts, size_t count, float* pressure, float* uncertainty,
                         uint16_t* status) {
  return run(handle, volts, count, pressure, uncertainty, status);
}
int tb_compensator_volts_double(tb_compensator* handle, const double* volts, size_t count, double* pressure,
                                double* uncertainty, uint16_t* status) {
  return run(handle, volts, count, pressure, uncertainty, status);
}

int tb_compensator_lost_frame(tb_compensator* handle) {
  if (handle == nullptr) return TB_COMPENSATOR_NULL;
  const std::size_t count = handle->status_spare.size();
  std::uint16_t* const bits = handle->status_spare.data();
  if (handle->is<float>())
    handle->with_real<float>([&](auto& own) {
      float* const spare = handle->single_spare.data();
      own.lost_frame({{spare, count}, {spare + count, count}, {bits, count}});
    });
  else
    handle->with_real<double>([&](auto& own) {
      double* const spare = handle->whole_spare.data();
      own.lost_frame({{spare, count}, {spare + count, count}, {bits, count}});
    });
  return TB_COMPENSATOR_OK;
}

int tb_compensator_reset(tb_compensator* handle) {
  if (handle == nullptr) return TB_COMPENSATOR_NULL;
  handle->with([](auto& compensator) { compensator.reset(); });
  return TB_COMPENSATOR_OK;
}

int tb_compensator_reset_unknown(tb_compensator* handle) {
  if (handle == nullptr) return TB_COMPENSATOR_NULL;
  handle->with([](auto& compensator) { compensator.reset_unknown(); });
  return TB_COMPENSATOR_OK;
}

int tb_compensator_tare(tb_compensator* handle, const uint16_t* counts, size_t count, size_t* refused) {
  if (handle == nullptr || counts == nullptr) return TB_COMPENSATOR_NULL;
  if (count != handle->status_spare.size()) return TB_COMPENSATOR_SIZE;
  const std::size_t left = handle->with([&](auto& compensator) { return compensator.tare({counts, count}); });
  if (refused != nullptr) *refused = left;
  return TB_COMPENSATOR_OK;
}

int tb_compensator_set_outside_validity(tb_compensator* handle, int outside) {
  if (handle == nullptr) return TB_COMPENSATOR_NULL;
  handle->with([&](auto& compensator) { compensator.set_outside_validity(outside != 0); });
  return TB_COMPENSATOR_OK;
}
