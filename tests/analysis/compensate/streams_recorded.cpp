// Compensators of ELAM along ways of many kinds: pressures, uncertainties and marks as they were when recorded, all in
// sums. What single figures mean is tested by hand elsewhere; here every operation counts.
#include "analysis/compensate/compensator.h"
#include "analysis/compensate/frame_compensator.h"
#include "tests/analysis/compensate/recorded_streams.h"

using namespace tactbench::analysis;
using namespace recorded;

namespace {

constexpr std::size_t kTaxels = 21, kFrames = 900;

double bent(double share, double bend) { return share * (1.0 + bend * (1.0 - share)); }

// Patterns in steps of 1 / 256 V from 0.5 to 3.5 V; taxel 4 does not rise at its top, 5 not at its bottom.
FrameSetup elam_array(bool in_round_numbers, bool exact_outer) {
  FrameSetup setup;
  setup.pressure_psi = {0.0, 6.0, 20.0, 32.0, 44.0, 52.0, 60.0};
  setup.volts_per_count = in_round_numbers ? std::ldexp(1.0, -60) : 1.0 / 4096.0;
  setup.elam.exact_outer = exact_outer;
  setup.longest_gap = 3;
  setup.tare_share = 0.1;
  setup.start_unknown = false;
  if (in_round_numbers) {
    setup.options.jump_in_noises = 4.0;
    setup.options.lead_in_noises = 0.0;
    setup.options.band_in_noises = 4.0;
    setup.options.rest_in_noises = 3.0;
    setup.options.hold_in_noises = 2.0;
    setup.options.drift_share = 1.0 / 128.0;
  }
  for (std::size_t t = 0; t < kTaxels; ++t) {
    const double k = static_cast<double>(t);
    TaxelSetup taxel;
    taxel.usable = t != 7;
    for (const double psi : setup.pressure_psi) {
      const double share = psi / 60.0, up = bent(share, -0.8 + 0.02 * k), down = bent(share, 0.2 + 0.03 * k);
      const auto volts = [&](double part) { return 0.5 + std::round(3.0 * part * 256.0) / 256.0; };
      taxel.ascending_v.push_back(volts(t == 5 && psi < 21.0 ? 0.0 : up));
      taxel.descending_v.push_back(volts(t == 4 && psi > 43.0 ? 1.0 : down));
    }
    taxel.parameters = {0.3 + 0.03 * k, 0.35 + 0.025 * k, 0.001 * (k - 10.0), 0.1 + 0.04 * k, 0.2 + 0.03 * k};
    if (in_round_numbers) taxel.parameters = {0.5, 0.75, 0.0, 0.25 * std::fmod(k, 4.0), 0.125 * std::fmod(k, 8.0)};
    taxel.noise_v = in_round_numbers ? 1.0 / 64.0 : 0.001 * (1.0 + std::fmod(k, 6.0));
    taxel.falling = t % 5 == 3;
    if (taxel.falling && !in_round_numbers) taxel.ascending_v.back() = taxel.descending_v.back();
    for (std::size_t bin = 0; bin < 12 && t % 4 != 2; ++bin)
      taxel.residual_psi.push_back(0.01 * static_cast<double>(1 + bin * 7 % 12) + 0.001 * k);
    setup.taxels.push_back(taxel);
  }
  return setup;
}

// Volts of each taxel.
std::vector<std::vector<double>> ways(bool in_round_numbers) {
  std::vector<std::vector<double>> all;
  for (std::size_t t = 0; t < kTaxels; ++t) {
    const double noise = in_round_numbers ? 0.004 : 0.001 / 3.0 * (1.0 + std::fmod(static_cast<double>(t), 6.0));
    std::vector<double> volts = output_shares(100 + t, kFrames, noise);
    for (double& volt : volts) volt = 0.5 + 3.0 * volt;
    all.push_back(in_round_numbers ? in_steps(std::move(volts), 64.0) : std::move(volts));
  }
  return all;
}

Summed frames_read(const FrameSetup& setup, bool in_round_numbers) {
  FrameCompensator<double> frames(setup);
  const std::vector<std::vector<double>> outputs = ways(in_round_numbers);
  std::vector<double> volts(kTaxels), psi(kTaxels), doubt(kTaxels);
  std::vector<std::uint16_t> status(kTaxels), counts(kTaxels);
  const FrameCompensator<double>::Output output{psi, doubt, status};
  Summed summed(kTaxels * 150);
  for (std::size_t f = 0; f < kFrames; ++f) {
    for (std::size_t t = 0; t < kTaxels; ++t) {
      volts[t] = outputs[t][f];
      counts[t] = static_cast<std::uint16_t>(std::lround(std::max(0.0, volts[t]) * 4096.0));
      if (setup.taxels[t].falling) volts[t] = -volts[t];
    }
    if (f == 150) frames.reset_unknown();
    if (f == 210) frames.reset();
    if (f == 300) frames.reset_unknown();
    if (f == 450 && !in_round_numbers) CHECK(frames.tare(counts) < kTaxels);
    if (f == 600) frames.reset_unknown();
    if (f == 580 || f == 590) frames.set_outside_validity(f == 580);
    if (f % 97 == 11) volts[(f / 97) * 2] = std::nan("");
    const bool lost = f % 83 == 40 || (f > 700 && f < 705);
    if (lost)
      frames.lost_frame(output);
    else if (f % 7 == 3 && !in_round_numbers)
      frames.frame(std::span<const std::uint16_t>(counts), output);
    else
      frames.frame(std::span<const double>(volts), output);
    for (std::size_t t = 0; t < kTaxels; ++t) summed.add(psi[t], doubt[t], status[t]);
  }
  return summed;
}

// The plain form along the same ways.
Summed plain_reads(const FrameSetup& setup, bool in_round_numbers) {
  const std::vector<std::vector<double>> outputs = ways(in_round_numbers);
  Summed summed(kFrames * 7);
  for (std::size_t t = 0; t < kTaxels; ++t) {
    const TaxelSetup& from = setup.taxels[t];
    const ElamModel model{
        PatternCurve(setup.pressure_psi, from.ascending_v, from.ascending_v.front(), from.ascending_v.back()),
        PatternCurve(setup.pressure_psi, from.descending_v, from.descending_v.front(), from.descending_v.back()),
        from.parameters, setup.elam};
    CompensatorOptions options = setup.options;
    options.noise_v = from.noise_v;
    TaxelCompensator plain(model, options);
    for (std::size_t f = 0; f < kFrames; ++f) {
      if (f == 300) plain.reset();
      if (f % 300 == 150) plain.reset_unknown();
      summed.add(plain.step(outputs[t][f]));
    }
  }
  return summed;
}

}  // namespace

TEST_CASE("recorded: frames of ELAM along ways with noise read what they read when recorded") {
  check_recorded(frames_read(elam_array(false, false), false), {{114925.8324343, 14217.5517099, 430803},
                                                                {124721.4233637, 15638.1508123, 1217182},
                                                                {130583.1499372, 16753.8062467, 1432901},
                                                                {132838.3712225, 16386.5873361, 1592322},
                                                                {125984.3532487, 21723.7310217, 2479380},
                                                                {137366.7390806, 14859.3755247, 908146}});
}

TEST_CASE("recorded: frames of ELAM in round numbers, where limits are met exactly, read what they read") {
  check_recorded(frames_read(elam_array(true, false), true), {{103310.4326807, 17152.8844457, 604068},
                                                              {108782.5175287, 18865.2997250, 1484893},
                                                              {116908.1434999, 20743.7580205, 1967261},
                                                              {121576.5635635, 16859.0510808, 722192},
                                                              {107848.1513192, 25715.5324252, 3021405},
                                                              {114769.6803614, 17411.1988887, 1033493}});
  check_recorded(frames_read(elam_array(true, true), true), {{113082.4241731, 17468.6443107, 623656},
                                                             {121127.9691135, 19440.4560395, 1388397},
                                                             {126957.4353897, 20299.8249190, 1897255},
                                                             {125588.0146258, 16895.1381984, 725730},
                                                             {120364.3852420, 26428.8459380, 3025579},
                                                             {124856.2755672, 17585.8891985, 1157769}});
}

TEST_CASE("recorded: the plain form of ELAM along the same ways reads what it read when recorded") {
  check_recorded(plain_reads(elam_array(false, true), false), {{263281.1368472, 8275.8852589, 361049},
                                                               {283183.2407464, 5617.7692017, 311752},
                                                               {293097.5281752, 4552.7189513, 221760}});
  check_recorded(plain_reads(elam_array(true, false), true), {{227867.3594222, 7923.4658778, 355633},
                                                              {242759.3183550, 8251.5796424, 364452},
                                                              {238784.9057461, 8402.8466864, 366163}});
}
