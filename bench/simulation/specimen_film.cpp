#include "bench/simulation/specimen_film.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "bench/simulation/counter_noise.h"

namespace tactbench::bench {
namespace {

constexpr std::uint64_t kStuckStream = 60;

int index_of(const SpecimenOptions& options, int row, int column) {
  if (row < 0 || row >= options.rows || column < 0 || column >= options.columns) {
    throw std::invalid_argument("specimen: defect at row " + std::to_string(row) + ", column " +
                                std::to_string(column) + " lies outside the array");
  }
  return row * options.columns + column;
}

int checked_taxels(const SpecimenOptions& options) {
  if (options.rows < 1 || options.columns < 1) throw std::invalid_argument("specimen: rows and columns must be >= 1");
  return options.rows * options.columns;
}

}  // namespace

Specimen::Film::Film(const SpecimenOptions& given)
    : options(given),
      taxels(checked_taxels(given)),
      make(make_film(given)),
      share_of_chamber(shares_of_chamber(given)),
      wiring(turned_wiring(given)) {
  const auto size = static_cast<std::size_t>(taxels);
  for (auto& play : memory.plays) play.assign(size, 0.0);
  memory.creep.assign(kCreepTimes, std::vector<double>(size, 0.0));
  if (options.kind == SpecimenKind::kHarsh) harsh.emplace(options, make).begin(memory);
  if (options.kind == SpecimenKind::kFoam) {
    memory = {};
    memory.virgin = 0.0;
    memory.foam = foam.emplace(options, make).begin();
  }
  noise_v.assign(size, 0.0);
  for (const TaxelDefect& defect : options.defects) {
    const int at = index_of(options, defect.row, defect.column);
    if (defect.kind == TaxelDefect::Kind::kNoisy) noise_v[static_cast<std::size_t>(at)] = film::kNoisyV;
  }
  for (const TaxelDefect& defect : options.defects) {
    if (defect.kind != TaxelDefect::Kind::kSwapped) continue;
    std::swap(noise_v[static_cast<std::size_t>(index_of(options, defect.row, defect.column))],
              noise_v[static_cast<std::size_t>(index_of(options, defect.other_row, defect.other_column))]);
  }
  turn(noise_v);
}

void Specimen::Film::turn(std::span<double> values) const {
  if (options.mount_turn == MountTurn::kNone) return;
  const std::vector<double> film(values.begin(), values.end());
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = film[wiring[i]];
}

std::vector<double> Specimen::Film::local_psi(double pressure_psi, double lag_psi,
                                              std::span<const double> contact_psi) const {
  std::vector<double> local(static_cast<std::size_t>(taxels));
  for (std::size_t i = 0; i < local.size(); ++i) {
    const double arrived = pressure_psi + make.lag_share[i] * (lag_psi - pressure_psi);
    local[i] = make.sensitivity[i] * (share_of_chamber[i] * arrived - make.lift_off_psi[i]);
  }
  for (std::size_t i = 0; i < contact_psi.size(); ++i) local[i] += make.sensitivity[i] * contact_psi[i];
  for (double& q : local) q = q > 0.0 ? q : 0.0;
  return local;
}

void Specimen::Film::advance(FilmMemory& state, double pressure_psi, double seconds,
                             std::span<const double> contact_psi) const {
  const double rise = std::max(0.0, pressure_psi - state.pressure_psi);
  // The virgin share falls by exp(-rate) over one load to kFullLoadPsi, most of it at high pressure.
  const double work = rise * (pressure_psi + state.pressure_psi) / (film::kFullLoadPsi * film::kFullLoadPsi);
  state.virgin *= std::exp(-film::kConditioningRate * work);
  state.travel_psi += rise;
  state.pressure_psi = pressure_psi;
  state.lag_psi = pressure_psi + (state.lag_psi - pressure_psi) * std::exp(-seconds / film::kLagSeconds);

  const double friction_now = 1.0 + film::kVirginFriction * state.virgin;
  std::vector<double> local = local_psi(pressure_psi, state.lag_psi, contact_psi);
  if (foam) return foam->advance(state.foam, local, seconds);
  if (harsh) return harsh->advance(state, local, seconds, friction_now);

  std::array<double, kCreepTimes> kept{};
  for (std::size_t j = 0; j < kept.size(); ++j) kept[j] = std::exp(-seconds / film::kCreepSeconds[j]);
  constexpr double kLinear = 1.0 / film::kFrictionLinearPsi;
  constexpr double kSquare = 1.0 / (film::kFrictionPeakPsi * film::kFrictionPeakPsi);

  // Blocks that stay in the first-level cache, elements outside, taxels inside: the inner loops vectorise.
  constexpr int kBlock = 64;
  std::array<double, kBlock> friction{};
  for (int start = 0; start < taxels; start += kBlock) {
    const int count = std::min(kBlock, taxels - start);
    const double* const q = local.data() + start;
    for (int b = 0; b < count; ++b) {
      const auto at = static_cast<std::size_t>(b);
      const std::size_t i = static_cast<std::size_t>(start) + at;
      friction[at] = friction_now * make.friction[i] * q[at] / (1.0 + q[at] * (kLinear + q[at] * kSquare));
    }
    for (std::size_t k = 0; k < state.plays.size(); ++k) {
      double* play = state.plays[k].data() + start;
      const double width = film::kWidths[k];
      for (int b = 0; b < count; ++b) {
        const auto at = static_cast<std::size_t>(b);
        const double high = q[at] + width * friction[at];
        const double held = play[b] < q[at] ? q[at] : play[b];
        play[b] = held > high ? high : held;
      }
    }
    for (int b = 0; b < count; ++b) {
      const auto at = static_cast<std::size_t>(b);
      friction[at] = q[at] / (q[at] + film::kCreepHalfPsi);  // now the creep's target
    }
    for (std::size_t j = 0; j < kept.size(); ++j) {
      double* creep = state.creep[j].data() + start;
      const double keep = kept[j];
      for (int b = 0; b < count; ++b) {
        const double target = friction[static_cast<std::size_t>(b)];
        creep[b] = target + (creep[b] - target) * keep;
      }
    }
  }
}

void Specimen::Film::output(const FilmMemory& state, std::span<double> volts) const {
  if (volts.size() != static_cast<std::size_t>(taxels)) throw std::invalid_argument("Specimen::output: wrong size");
  const SpecimenEffects& effects = options.effects;
  const double cycles = state.travel_psi / film::kFullLoadPsi;
  const double common_gain =
      (1.0 + effects.temperature_coefficient * (options.temperature_c - film::kReferenceCelsius)) *
      (1.0 + effects.gain_drift_per_thousand_cycles * cycles / 1000.0) * (1.0 - film::kVirginGainLoss * state.virgin);
  for (std::size_t i = 0; i < volts.size(); ++i) {
    const double gain = common_gain * (1.0 + effects.gain_drift_per_month * options.age_months * make.age_drift[i]);
    const double zero = make.zero_v[i] + effects.zero_drift_v_per_month * options.age_months;
    if (harsh) {
      volts[i] = zero + state.harsh.zero_v[i] + gain * make.amplitude_v[i] * harsh->response(state, i);
      continue;
    }
    if (foam) {
      volts[i] = zero + gain * make.amplitude_v[i] * foam->response(state.foam, i);
      continue;
    }
    double rest = 0.0;
    double displaced = 0.0;
    for (std::size_t k = 0; k < state.plays.size(); ++k) {
      rest += make.rest_share[k] * state.plays[k][i];
      displaced += make.displaced_share[k] * state.plays[k][i];
    }
    const double widest = state.plays.back()[i];
    const double contact = rest + (displaced - rest) * widest / (widest + film::kDisplacedHalfPsi);
    double crept = 0.0;
    for (std::size_t j = 0; j < state.creep.size(); ++j) crept += film::kCreepShares[j] * (state.creep[j][i] - 1.0);
    const double ratio = contact > 0.0 ? std::pow(contact / film::kHalfPsi, make.exponent[i]) : 0.0;
    volts[i] = zero + gain * make.amplitude_v[i] * (1.0 + make.creep[i] * crept) * ratio / (1.0 + ratio);
  }
  // A dead or stuck taxel also disturbs its neighbours with what it reads, and reads that whatever they do.
  apply_defects(volts);
  apply_crosstalk(volts);
  if (harsh) harsh->couple(volts);
  apply_defects(volts);
  for (const TaxelDefect& defect : options.defects) {
    if (defect.kind != TaxelDefect::Kind::kSwapped) continue;
    std::swap(volts[static_cast<std::size_t>(index_of(options, defect.row, defect.column))],
              volts[static_cast<std::size_t>(index_of(options, defect.other_row, defect.other_column))]);
  }
  turn(volts);
  for (double& v : volts) v = std::clamp(v, 0.0, film::kRailV);
}

void Specimen::Film::apply_defects(std::span<double> volts) const {
  for (const TaxelDefect& defect : options.defects) {
    const int taxel = index_of(options, defect.row, defect.column);
    double& v = volts[static_cast<std::size_t>(taxel)];
    if (defect.kind == TaxelDefect::Kind::kDead) v = 0.0;
    if (defect.kind == TaxelDefect::Kind::kSaturated) v = film::kRailV;
    if (defect.kind == TaxelDefect::Kind::kStuck) {
      v = 0.5 + 2.0 * uniform_of(hash_of(options.sensor_seed, kStuckStream, static_cast<std::uint64_t>(taxel)));
    }
  }
}

void Specimen::Film::apply_crosstalk(std::span<double> volts) const {
  const double in_row = options.effects.row_crosstalk;
  const double in_column = options.effects.column_crosstalk;
  if (in_row == 0.0 && in_column == 0.0) return;
  const auto rows = static_cast<std::size_t>(options.rows);
  const auto columns = static_cast<std::size_t>(options.columns);
  std::vector<double> row_sum(rows, 0.0);
  std::vector<double> column_sum(columns, 0.0);
  for (std::size_t i = 0; i < volts.size(); ++i) {
    row_sum[i / columns] += volts[i];
    column_sum[i % columns] += volts[i];
  }
  const double others_in_row = std::max<double>(1.0, options.columns - 1);
  const double others_in_column = std::max<double>(1.0, options.rows - 1);
  for (std::size_t i = 0; i < volts.size(); ++i) {
    const double own = volts[i];
    volts[i] += in_row * (row_sum[i / columns] - own) / others_in_row +
                in_column * (column_sum[i % columns] - own) / others_in_column;
  }
}

}  // namespace tactbench::bench
