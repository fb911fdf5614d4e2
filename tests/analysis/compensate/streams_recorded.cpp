// Compensators of ELAM along ways of many kinds: pressures, uncertainties and marks as they were when recorded, all in
// sums. What single figures mean is tested by hand elsewhere; here every operation counts.
#include "analysis/compensate/compensator.h"
#include "analysis/compensate/frame_compensator.h"
#include "tests/analysis/compensate/recorded_streams.h"

using namespace tactbench::analysis;
using namespace recorded;

namespace {

constexpr std::size_t kElamTaxels = 21, kElamFrames = 900;

double bent_share(double share, double bend) { return share * (1.0 + bend * (1.0 - share)); }

// Patterns in steps of 1 / 256 V from 0.5 to 3.5 V; taxel 4 does not rise at its top, 5 not at its bottom.
FrameSetup elam_array(Kind kind, bool exact_outer) {
  const bool in_round_numbers = kind == Kind::kRound;
  FrameSetup setup;
  setup.pressure_psi = {2.0, 8.0, 22.0, 34.0, 46.0, 54.0, 62.0};
  setup.volts_per_count = in_round_numbers ? std::ldexp(1.0, -60) : 1.0 / 4096.0;
  setup.elam.exact_outer = exact_outer;
  setup.longest_gap = 3;
  setup.tare_share = 0.1;
  setup.start_unknown = false;
  set_limits(kind, setup.options);
  if (in_round_numbers) setup.options.drift_share = 1.0 / 128.0;
  if (kind == Kind::kOpen) setup.options.drift_share = 0.0;
  for (std::size_t t = 0; t < kElamTaxels; ++t) {
    const double k = static_cast<double>(t);
    TaxelSetup taxel;
    taxel.usable = t != 7;
    for (const double psi : setup.pressure_psi) {
      const double share = (psi - 2.0) / 60.0, up = bent_share(share, -0.8 + 0.02 * k),
                   down = bent_share(share, 0.2 + 0.03 * k);
      const auto volts = [&](double part) { return 0.5 + std::round(3.0 * part * 256.0) / 256.0; };
      taxel.ascending_v.push_back(volts(t == 5 && psi < 23.0 ? 0.0 : up));
      taxel.descending_v.push_back(volts(t == 4 && psi > 45.0 ? 1.0 : down));
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
std::vector<std::vector<double>> elam_ways(Kind kind) {
  std::vector<std::vector<double>> all;
  for (std::size_t t = 0; t < kElamTaxels; ++t) {
    const double noise = kind == Kind::kRound ? 0.004 : 0.001 / 3.0 * static_cast<double>(1 + t % 6);
    std::vector<double> volts = (drifts(kind) ? drifting_shares : output_shares)(100 + t, kElamFrames, noise);
    for (double& volt : volts) volt = 0.5 + 3.0 * volt;
    all.push_back(kind == Kind::kRound ? in_steps(std::move(volts), 64.0) : std::move(volts));
  }
  return all;
}

Summed frames_read(const FrameSetup& setup, Kind kind) {
  return sums_of_frames<FrameCompensator<double>>(setup, kind, elam_ways(kind), 4096.0, [](auto&, std::size_t) {});
}

// The plain form along the same ways.
Summed plain_reads(const FrameSetup& setup, Kind kind) {
  const std::vector<std::vector<double>> outputs = elam_ways(kind);
  const bool often = drifts(kind);
  Summed summed(kElamFrames * 7);
  for (std::size_t t = 0; t < kElamTaxels; ++t) {
    const TaxelSetup& from = setup.taxels[t];
    const ElamModel model{
        PatternCurve(setup.pressure_psi, from.ascending_v, from.ascending_v.front(), from.ascending_v.back()),
        PatternCurve(setup.pressure_psi, from.descending_v, from.descending_v.front(), from.descending_v.back()),
        from.parameters, setup.elam};
    CompensatorOptions options = setup.options;
    options.noise_v = from.noise_v;
    TaxelCompensator plain(model, options);
    for (std::size_t f = 0; f < kElamFrames; ++f) {
      if (f == 300) plain.reset();
      if (f % (often ? 90 : 300) == (often ? 45 : 150)) plain.reset_unknown();
      summed.add(plain.step(outputs[t][f]));
    }
  }
  return summed;
}

}  // namespace

TEST_CASE("recorded: frames of ELAM along ways with noise read what they read when recorded") {
  check_recorded(frames_read(elam_array(Kind::kNoise, false), Kind::kNoise), {{124343.1195631, 14217.5517099, 430803},
                                                                              {134141.2055419, 15638.1508123, 1217182},
                                                                              {140001.4271649, 16753.8062467, 1432901},
                                                                              {142257.1434997, 16386.5873361, 1592322},
                                                                              {135403.6205754, 21723.7310217, 2479380},
                                                                              {146784.5014569, 14859.3755247, 908146}});
}

TEST_CASE("recorded: frames of ELAM in round numbers, where limits are met exactly, read what they read") {
  check_recorded(frames_read(elam_array(Kind::kRound, false), Kind::kRound),
                 {{112727.7198094, 17152.8844457, 604068},
                  {118202.2997070, 18865.2997250, 1484893},
                  {126326.4207276, 20743.7580205, 1967261},
                  {130995.3358407, 16859.0510808, 722192},
                  {117267.4186459, 25715.5324252, 3021405},
                  {124187.4427377, 17411.1988887, 1033493}});
  check_recorded(frames_read(elam_array(Kind::kRound, true), Kind::kRound), {{122499.7113019, 17468.6443107, 623656},
                                                                             {130547.7512918, 19440.4560395, 1388397},
                                                                             {136375.7126175, 20299.8249190, 1897255},
                                                                             {135006.7869030, 16895.1381984, 725730},
                                                                             {129783.6525688, 26428.8459380, 3025579},
                                                                             {134274.0379434, 17585.8891985, 1157769}});
}

TEST_CASE("recorded: frames of ELAM in slow drifts, of histories that are often unknown, read what they read") {
  check_recorded(frames_read(elam_array(Kind::kDrift, true), Kind::kDrift), {{165340.0018550, 19454.0742138, 1611189},
                                                                             {138765.4298884, 21374.0201639, 2156606},
                                                                             {153188.7498226, 26113.0929031, 2395941},
                                                                             {145088.7061766, 21393.9476466, 1979932},
                                                                             {146037.4875548, 25736.0317084, 2358826},
                                                                             {149271.3613604, 24149.4151198, 2315207}});
  check_recorded(frames_read(elam_array(Kind::kOpen, false), Kind::kOpen), {{161343.5259921, 15756.3119166, 2745985},
                                                                            {134845.9278555, 16789.9670650, 3423436},
                                                                            {151736.8438918, 19166.2816821, 3606183},
                                                                            {142775.4250045, 16541.7469857, 3046218},
                                                                            {144735.8179750, 21100.2419020, 3833458},
                                                                            {148817.2130807, 17705.3534640, 3443487}});
}

TEST_CASE("recorded: the plain form of ELAM along the same ways reads what it read when recorded") {
  check_recorded(plain_reads(elam_array(Kind::kNoise, true), Kind::kNoise), {{282118.2061541, 8275.8852589, 361049},
                                                                             {302020.2902513, 5617.7692017, 311752},
                                                                             {311934.5578782, 4552.7189513, 221760}});
  check_recorded(plain_reads(elam_array(Kind::kRound, false), Kind::kRound), {{246704.4287292, 7923.4658778, 355633},
                                                                              {261596.3678600, 8251.5796424, 364452},
                                                                              {257621.9354491, 8402.8466864, 366163}});
  check_recorded(plain_reads(elam_array(Kind::kDrift, false), Kind::kDrift), {{307370.6534173, 11858.9674840, 323454},
                                                                              {318876.6617705, 4169.2870860, 230016},
                                                                              {311841.8446921, 13584.1407817, 444844}});
  check_recorded(plain_reads(elam_array(Kind::kOpen, true), Kind::kOpen), {{336087.2141396, 21144.0816411, 953832},
                                                                           {319014.9423749, 13138.5461403, 979060},
                                                                           {291531.2285564, 14431.8338233, 897852}});
}
