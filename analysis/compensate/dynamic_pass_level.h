// One vector level of the dynamic passes; dynamic_pass.cpp includes it once for each and defines the level's names and
// target. Hence no include guard. The loops have no branch that depends on a sample: the compiler makes vectors of
// them.

namespace tactbench::analysis {

template <class Real>
TACTBENCH_PASS_TARGET DynamicBits DynamicPasses<Real>::TACTBENCH_PASS_LEVEL(DynamicBlock<Real>& b,
                                                                            const Real* __restrict samples,
                                                                            const DynamicFrame<Real>& frame,
                                                                            Real* __restrict outputs) {
  const DynamicFrame<Real> f = frame;
  using Flag = std::conditional_t<sizeof(Real) == 4, std::int32_t, std::int64_t>;
  alignas(64) Flag events[kLanes], held[kLanes];
  for (std::size_t i = 0; i < kLanes; ++i) {
    const Real one = 1, zero = 0;
    const Real above = b.gain[i] * (samples[i] - b.zero[i]);
    // The creep's target needs the pressure: guessed along the slope of the last reading.
    const Real guessed = b.last_x[i] + b.last_slope[i] * (above * b.last_share[i] - b.last_mean[i]);
    const Real guess = std::min(std::max(guessed, zero), f.span);
    const Real target = guess / (guess + f.half);
    Real sum = target * f.creep_new - f.creep_all;
    for (std::size_t j = 0; j < kCreepElements; ++j) sum += f.creep_kept[j] * b.psi[j][i];
    const Real share = one / (one + b.creep_scale[i] * sum), y = above * share;
    b.last_share[i] = share;
    outputs[i] = y;
    const Real weight0 = b.weight[i], mean0 = b.mean[i], steps0 = b.steps[i];
    const Real off = y - mean0, off2 = off * off;
    const Real step = off2 * (one - Real(0.5) * weight0);
    const Real averaged_weight = std::max(weight0 / (one + weight0), f.least);
    const bool jumps = (f.moving < steps0) | (f.jump2 * (one + weight0) < off2);
    b.steps[i] = steps0 + (std::min(step, Real(kStepCeiling)) - steps0) * Real(1.0 / kStepWindow);
    const Real averaged = mean0 + averaged_weight * off;
    const Real mean = jumps ? y : averaged, weight = jumps ? one : averaged_weight;
    b.mean[i] = mean;
    b.weight[i] = weight;
    const Real root = std::sqrt(weight), lead = f.lead * root * (one - weight);
    const Real direction = b.rising[i], extreme0 = b.extreme[i], extreme_weight0 = b.extreme_weight[i];
    const Real ahead = direction * (mean - extreme0), forward = std::max(zero, ahead);
    const Real behind = std::max(zero, direction * (b.turn[i] - mean)), behind2 = behind * behind;
    const Real wider = std::max(weight, extreme_weight0), hold = f.hold2 * wider;
    const bool holds = forward * forward <= hold;
    const bool turns = (ahead < zero) & (behind2 > f.band2 * wider);
    const bool rested = (weight <= f.least) & (weight < extreme_weight0) & (behind2 <= f.rest2);
    const bool taken = (!turns) & ((ahead >= zero) | rested);
    const Real extreme_before = extreme0, turn_before = b.turn[i];
    b.extreme[i] = taken ? mean : extreme_before;
    b.extreme_weight[i] = taken ? weight : extreme_weight0;
    b.turn[i] = taken ? mean - direction * lead : turn_before;
    const Real left = one - std::min(mean * b.divider[i], Real(Divider::kMost)), per_left = one / left;
    const Real u = mean * per_left;
    const Real x = b.x[i] + b.slope[i] * (u - b.u[i]);
    const Real slope = b.slope[i] * per_left * per_left, reverse = b.reverse[i];
    const Real sensitivity = holds ? std::max(slope, reverse) : slope;
    b.uncertainty[i] = std::min(root * sensitivity, f.span);
    b.last_x[i] = x;
    b.last_slope[i] = std::min(slope, b.steepest[i]);
    b.last_mean[i] = mean;
    const bool fits = (b.low[i] <= u) & (u <= b.high[i]) & ((!holds) | (reverse == reverse));
    const bool back = (!taken) & (behind2 > hold);
    events[i] = ((!fits) | back | turns) ? 1 : 0;
    held[i] = holds ? 1 : 0;
  }
  unsigned event_bits = 0, held_bits = 0;
  for (std::size_t i = 0; i < kLanes; ++i) {
    event_bits |= static_cast<unsigned>(events[i]) << i;
    held_bits |= static_cast<unsigned>(held[i]) << i;
  }
  return {static_cast<std::uint16_t>(event_bits), static_cast<std::uint16_t>(held_bits)};
}

template <class Real>
TACTBENCH_PASS_TARGET void DynamicPasses<Real>::TACTBENCH_PASS_FINISH(DynamicBlock<Real>& b,
                                                                      const DynamicFrame<Real>& frame,
                                                                      const Real* __restrict outputs,
                                                                      const FrameResults<Real>& to) {
  const DynamicFrame<Real> f = frame;
  Real* const __restrict pressures = to.pressure;
  Real* const __restrict uncertainties = to.uncertainty;
  std::uint16_t* const __restrict status = to.status;
  for (std::size_t i = 0; i < kLanes; ++i) {
    const Real left = b.lag_share[i] * f.lag_kept;
    const Real undone = (b.last_x[i] - left * b.late[i]) / (Real(1) - left);
    const Real p = std::min(std::max(undone, Real(0)), f.span), target = p / (p + f.half);
    for (std::size_t j = 0; j < kCreepElements; ++j) b.psi[j][i] = target + (b.psi[j][i] - target) * f.kept[j];
    b.late[i] = p + (b.late[i] - p) * f.lag_kept;
    pressures[i] = b.pressure[i] = f.lowest + p;
    const Real noise = b.uncertainty[i], residual = b.residual[i];
    uncertainties[i] = std::min(std::sqrt(noise * noise + residual * residual), f.span);
  }
  for (std::size_t i = 0; i < kLanes; ++i) {
    const bool outside = (outputs[i] < -f.band) | (outputs[i] > b.highest[i]);
    const unsigned range = outside ? unsigned{kTaxelOutOfRange} : unsigned{kTaxelValid};
    const unsigned flat = b.uncertainty[i] > f.flat ? unsigned{kTaxelFlat} : 0U;
    status[i] = static_cast<std::uint16_t>(range | flat);
  }
}

}  // namespace tactbench::analysis
