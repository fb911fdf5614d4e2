// Dynamic compensators along ways of many kinds: pressures, uncertainties and marks as they were when recorded, all in
// sums.
#include "analysis/compensate/dynamic_compensator.h"
#include "analysis/compensate/dynamic_frame_compensator.h"
#include "analysis/compensate/everett.h"
#include "tests/analysis/compensate/recorded_streams.h"

using namespace tactbench::analysis;
using namespace recorded;

namespace {

constexpr std::size_t kFilms = 21, kIntervals = 6, kFilmFrames = 900;

// Everett's function of cells in steps of 1 / 64 V: each point's is the sum of the cells between.
std::vector<double> film_table(std::size_t taxel) {
  std::vector<double> table;
  for (std::size_t i = 0; i <= kIntervals; ++i)
    for (std::size_t j = 0; j <= i; ++j) {
      double sum = 0.0;
      for (std::size_t a = j; a < i; ++a)
        for (std::size_t b = j; b <= a; ++b) sum += static_cast<double>(1 + (3 * a + 5 * b + taxel) % 11) / 64.0;
      table.push_back(sum);
    }
  return table;
}

double film_top(const std::vector<double>& table) { return table[table.size() - 1 - kIntervals]; }

DynamicSetup film_array(Kind kind) {
  const bool in_round_numbers = kind == Kind::kRound;
  DynamicSetup setup;
  setup.x_low = 2.0;
  setup.x_high = 62.0;
  setup.intervals = kIntervals;
  setup.volts_per_count = in_round_numbers ? std::ldexp(1.0, -60) : 1.0 / 8192.0;
  setup.longest_gap = 3;
  setup.tare_share = 0.1;
  setup.start_unknown = false;
  setup.dynamics.creep_s = {0.3, 3.0, 30.0};
  setup.dynamics.lag_s = 0.4;
  setup.dynamics.creep_half = 8.0;
  if (!in_round_numbers) {
    setup.dynamics.creep_share = {0.03, 0.02, 0.01};
    setup.worked_s = 2.0;
  } else {
    setup.observer.share = 1.0 / 32.0;
    setup.observer.forget = 1.0 / 4.0;
  }
  set_limits(kind, setup.options);
  if (kind == Kind::kOpen) setup.observer.share = 0.0;
  for (std::size_t k = 0; k < 2 * kIntervals; ++k)
    setup.residual_psi.push_back(0.01 * static_cast<double>(1 + k * 5 % 12));
  for (std::size_t t = 0; t < kFilms; ++t) {
    DynamicTaxel taxel;
    taxel.usable = t != 9;
    taxel.divider.zero = 0.5;
    taxel.divider.per_amplitude = in_round_numbers ? 0.0 : 0.005 * static_cast<double>(t);
    taxel.everett = film_table(t);
    taxel.creep_scale = 0.5 + 0.1 * static_cast<double>(t);
    taxel.lag_share = in_round_numbers ? 0.0 : 0.015 * static_cast<double>(t);
    taxel.noise_v = in_round_numbers ? 1.0 / 64.0 : 0.001 * static_cast<double>(1 + t % 6);
    taxel.residual_scale = 0.5 + 0.05 * static_cast<double>(t);
    taxel.falling = t % 5 == 3;
    setup.taxels.push_back(taxel);
  }
  return setup;
}

// Volts of each taxel: beyond its zero, shares of what the film gives at its top.
std::vector<std::vector<double>> film_ways(const DynamicSetup& setup, Kind kind) {
  const bool in_round_numbers = kind == Kind::kRound;
  std::vector<std::vector<double>> all;
  for (std::size_t t = 0; t < kFilms; ++t) {
    const DynamicTaxel& taxel = setup.taxels[t];
    const double top = Divider{0.0, taxel.divider.per_amplitude}.output(film_top(taxel.everett));
    all.push_back((drifts(kind) ? drifting_shares : output_shares)(300 + t, kFilmFrames,
                                                                   in_round_numbers ? 0.002
                                                                   : drifts(kind)   ? taxel.noise_v / top
                                                                                    : 0.4 * taxel.noise_v / top));
    for (double& share : all.back()) share *= top;
    if (in_round_numbers) all.back() = in_steps(all.back(), 64.0);
    for (double& volts : all.back()) volts += taxel.divider.zero;
  }
  return all;
}

Summed film_frames_read(const DynamicSetup& setup, Kind kind) {
  return sums_of_frames<DynamicFrameCompensator<double>>(setup, kind, film_ways(setup, kind), 8192.0,
                                                         [](auto& frames, std::size_t f) {
                                                           if (f == 60) frames.set_interval(0.05);
                                                           if (f == 400) frames.set_interval(0.6);
                                                         });
}

Summed plain_film_reads(const DynamicSetup& setup, Kind kind) {
  const bool often = drifts(kind);
  const std::vector<std::vector<double>> outputs = film_ways(setup, kind);
  Summed summed(kFilmFrames * 7);
  for (std::size_t t = 0; t < kFilms; ++t) {
    if (!setup.taxels[t].usable) continue;
    DynamicTaxelCompensator plain(setup, t);
    const double sign = setup.taxels[t].falling ? -1.0 : 1.0;
    for (std::size_t f = 0; f < kFilmFrames; ++f) {
      if (f == 300) plain.reset();
      if (f == 450) plain.rest(1.0);
      if (f == 600) plain.work(2.0);
      if (f % (often ? 90 : 300) == (often ? 45 : 150)) plain.reset_unknown();
      summed.add(plain.step(sign * outputs[t][f], f % 5 == 0 ? 0.3 : 0.02));
      if (f % 25 == 0) summed.add(100.0 * plain.gain(), 0.0, plain.ascending() ? 1 : 0);
    }
  }
  return summed;
}

}  // namespace

TEST_CASE("recorded: dynamic frames along ways with noise, creep and lag read what they read when recorded") {
  check_recorded(film_frames_read(film_array(Kind::kNoise), Kind::kNoise), {{145414.2764672, 18951.0115431, 471170},
                                                                            {145552.6277014, 23410.2597026, 1419613},
                                                                            {136509.7172286, 29973.2381649, 2009116},
                                                                            {135637.6943851, 29951.2737603, 2104033},
                                                                            {129820.2733221, 28592.9386294, 2751019},
                                                                            {125072.5961701, 24929.3645563, 593280}});
}

TEST_CASE("recorded: dynamic frames in round numbers, where limits are met exactly, read what they read") {
  check_recorded(film_frames_read(film_array(Kind::kRound), Kind::kRound), {{134251.0549845, 23133.5982115, 666854},
                                                                            {145871.5708663, 25377.7765975, 1859385},
                                                                            {137874.0011593, 30442.8788217, 2546362},
                                                                            {138814.8297263, 34815.9256723, 811382},
                                                                            {135354.2625166, 33417.9422149, 3590345},
                                                                            {131446.3660873, 24558.1041686, 1003706}});
}

TEST_CASE("recorded: dynamic frames in slow drifts, of histories that are often unknown, read what they read") {
  check_recorded(film_frames_read(film_array(Kind::kDrift), Kind::kDrift), {{151351.0103422, 25238.9159599, 1422399},
                                                                            {122940.4803162, 24929.0820398, 1613190},
                                                                            {146294.2005835, 31461.0316772, 1648585},
                                                                            {134901.0613433, 28535.2080514, 2357440},
                                                                            {137892.7367965, 35711.8123787, 2304653},
                                                                            {131593.7804229, 33785.9166893, 1884339}});
  check_recorded(film_frames_read(film_array(Kind::kOpen), Kind::kOpen), {{150883.3115168, 18689.1633461, 1851175},
                                                                          {122572.3917350, 19455.2535424, 2599890},
                                                                          {145901.1208514, 21143.5697363, 2594805},
                                                                          {134499.0728863, 23714.0942475, 2958053},
                                                                          {137004.8916605, 23896.6537228, 2944710},
                                                                          {130463.0521434, 22355.8575149, 2693455}});
}

TEST_CASE("recorded: the plain dynamic form along the same ways reads what it read when recorded") {
  check_recorded(plain_film_reads(film_array(Kind::kNoise), Kind::kNoise), {{310196.8781228, 24963.8951486, 315474},
                                                                            {309309.0000888, 28757.4383649, 354691},
                                                                            {289421.5258992, 21895.2356043, 197284}});
  check_recorded(plain_film_reads(film_array(Kind::kRound), Kind::kRound), {{311433.9306608, 28072.4757052, 504486},
                                                                            {315128.6159572, 28515.8392431, 560305},
                                                                            {299216.3911223, 21876.3256966, 428467}});
  check_recorded(plain_film_reads(film_array(Kind::kDrift), Kind::kDrift), {{315944.3121941, 27893.0306063, 452378},
                                                                            {330948.6486143, 39896.4236456, 404627},
                                                                            {279380.9694433, 40636.6214620, 336525}});
  check_recorded(plain_film_reads(film_array(Kind::kOpen), Kind::kOpen), {{315402.6473537, 20071.2281948, 737938},
                                                                          {329849.2334598, 17444.3375465, 674883},
                                                                          {277544.5316366, 9402.9706540, 623792}});
}
