// Frames of counts along random reversals of the synthetic array, for the tests of the frame compensator.
#pragma once

#include "analysis/compensate/compensator.h"
#include "analysis/compensate/compensator_c.h"
#include "analysis/compensate/frame_compensator.h"
#include "tests/analysis/support/synthetic.h"

namespace synthetic {

struct Frames {
  FrameSetup setup;
  std::vector<ElamModel> models;
  std::vector<double> pressure;       // all taxels see the same
  std::vector<std::uint16_t> counts;  // frames x taxels
  [[nodiscard]] std::span<const std::uint16_t> at(std::size_t frame) const {
    return std::span(counts).subspan(frame * models.size(), models.size());
  }
};

// From rest; frames before `pressure` first comes to `skip_to` after some reversals are left out.
inline Frames random_reversals(int taxels, std::size_t count, double noise_v, double step_psi, double skip_to = 0.0,
                               unsigned seed = 1, unsigned sensor_seed = 1) {
  ArrayOptions options;
  options.rows = 1;
  options.columns = taxels;
  options.sensor_seed = sensor_seed;
  const Array array(options);
  Frames frames;
  frames.setup.volts_per_count = 5.0 / 65536.0;
  frames.setup.start_unknown = false;
  for (ElamModel model : array.taxels) {
    model.options.exact_outer = false;
    const auto up = model.ascending.y(), down = model.descending.y(), x = model.ascending.x();
    frames.setup.pressure_psi.assign(x.begin(), x.end());
    frames.setup.taxels.push_back(
        {true, {up.begin(), up.end()}, {down.begin(), down.end()}, model.parameters, noise_v, false});
    frames.models.push_back(model);
  }
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> level(0.0, 60.0);
  std::vector<double> turns{0.0};
  if (skip_to > 0.0)
    for (const double turn : {level(random), level(random), skip_to}) turns.push_back(turn);
  const std::size_t skipped = skip_to > 0.0 ? levels_of(turns, step_psi).size() : 0;
  while (levels_of(turns, step_psi).size() < skipped + count) turns.push_back(level(random));
  std::vector<Plant> plants(frames.models.begin(), frames.models.end());
  std::size_t step = 0;
  for (const double pressure : levels_of(turns, step_psi)) {
    const bool kept = step++ >= skipped && frames.pressure.size() < count;
    if (kept) frames.pressure.push_back(pressure);
    for (Plant& plant : plants) {
      const double volts = plant(pressure) + noise_v * normal(random);
      if (kept)
        frames.counts.push_back(
            static_cast<std::uint16_t>(std::clamp(std::lround(volts / frames.setup.volts_per_count), 0L, 65535L)));
    }
  }
  return frames;
}

// With the noise that a frame compensator takes: rounding to counts is noise, too.
inline std::vector<TaxelCompensator> plain_of(const Frames& frames, bool unknown) {
  std::vector<TaxelCompensator> plain;
  for (std::size_t t = 0; t < frames.models.size(); ++t) {
    CompensatorOptions options = frames.setup.options;
    options.noise_v = std::hypot(frames.setup.taxels[t].noise_v, frames.setup.volts_per_count / std::sqrt(12.0));
    plain.emplace_back(frames.models[t], options);
    if (unknown) plain.back().reset_unknown();
  }
  return plain;
}

// The C API's structs; they point into `own`.
inline tb_compensator_setup c_setup_of(const FrameSetup& own, std::uint32_t flags) {
  tb_compensator_setup setup{};
  setup.struct_size = sizeof setup;
  setup.flags = flags;
  setup.taxels = own.taxels.size();
  setup.knots = own.pressure_psi.size();
  setup.pressure = own.pressure_psi.data();
  setup.volts_per_count = own.volts_per_count;
  return setup;
}

inline tb_compensator_taxel c_taxel_of(const TaxelSetup& own) {
  tb_compensator_taxel taxel{};
  taxel.struct_size = sizeof taxel;
  taxel.flags = TB_TAXEL_USABLE;
  taxel.ascending = own.ascending_v.data();
  taxel.descending = own.descending_v.data();
  taxel.alpha_d = own.parameters.alpha_d;
  taxel.beta_d = own.parameters.beta_d;
  taxel.alpha_a1 = own.parameters.alpha_a1;
  taxel.alpha_a0 = own.parameters.alpha_a0;
  taxel.beta_a = own.parameters.beta_a;
  taxel.noise_volts = own.noise_v;
  return taxel;
}

template <class Real>
struct Results {
  std::vector<Real> pressure, uncertainty;
  std::vector<std::uint16_t> status;
  explicit Results(std::size_t taxels) : pressure(taxels), uncertainty(taxels), status(taxels) {}
  typename FrameCompensator<Real>::Output output() { return {pressure, uncertainty, status}; }
};

}  // namespace synthetic
