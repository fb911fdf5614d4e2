// States of each model along ways to and fro, and streams that undo them: outputs and inputs as they were when
// recorded, all in sums.
#include <functional>
#include <memory>

#include "analysis/compensate/inverse_stream.h"
#include "analysis/compensate/model_compensator.h"
#include "analysis/models/elam_hysteresis.h"
#include "analysis/models/gpi.h"
#include "analysis/models/linearised.h"
#include "analysis/models/monotone.h"
#include "analysis/models/mpi.h"
#include "analysis/models/poly.h"
#include "analysis/models/preisach.h"
#include "tests/analysis/compensate/recorded_streams.h"

using namespace tactbench::analysis;
using namespace recorded;

namespace {

using AnyModel = std::shared_ptr<const HysteresisModel>;

ElamModel elam_of_seven_knots(bool exact_outer) {
  const std::vector<double> x{2.0, 8.0, 20.0, 32.0, 44.0, 52.0, 62.0};
  const std::vector<double> up{0.5, 0.625, 1.0, 1.5, 2.125, 2.75, 3.5}, down{0.5, 1.5, 2.5, 3.0, 3.25, 3.375, 3.5};
  return {PatternCurve(x, up, 0.5, 3.5), PatternCurve(x, down, 0.5, 3.5), {0.6, 0.7, 0.004, 0.3, 0.4}, {exact_outer}};
}

const ElamPieces kThreeEach{{0.2}, {-0.3}, {0.4}, {-0.1}};
const ElamPieces kUneven{{0.3, -0.2}, {}, {-0.1}, {0.25}};

// The second polynomial wavers: it falls in places where the input rises.
AnyModel poly_of(bool wavers) {
  PolyParameters p;
  p.a = {0.0, 0.0, 0.0, 0.0, 0.0005, 0.02, 0.0};
  p.b = {0.0, 0.0, 0.0, 0.0, -0.0006, 0.086, 0.0};
  if (wavers) {
    p.a = {0.0, 0.0, 0.0, 2e-5, -0.0018, 0.0486, 0.0};
    p.b = {0.0, 2e-8, -2e-6, 1e-4, -0.0036, 0.087, 0.0};
  }
  return std::make_shared<PolyModel>(p, 2.0, 62.0, 0.5, 3.5);
}

struct NamedModel {
  const char* name;
  AnyModel model;
};

std::vector<NamedModel> models_of_each_kind() {
  const auto elam = [](bool exact, bool memory, ElamPieces pieces) {
    return std::make_shared<ElamHysteresis>(elam_of_seven_knots(exact), memory, std::move(pieces));
  };
  const std::vector<double> weights{0.3, 0.1, 0.4, 0.0, 0.2, 0.5, 0.05, 0.15, 0.0, 0.6};
  const auto preisach = std::make_shared<PreisachModel>(2.0, 62.0, 0.5, weights);
  return {
      {"elam", elam(false, false, {})},
      {"elam, exact", elam(true, false, {})},
      {"elam, memory", elam(false, true, {})},
      {"elam, memory, exact", elam(true, true, {})},
      {"elam, three pieces", elam(true, false, kThreeEach)},
      {"elam, uneven pieces, memory", elam(false, true, kUneven)},
      {"gpi", std::make_shared<GpiModel>(GpiParameters{1.2, 0.03, 0.1, 1.4, 1.1, 0.05, 0.2, 1.3, 0.06, 0.9, 1.5}, 2.0,
                                         62.0, 0.5)},
      {"mpi", std::make_shared<MpiModel>(MpiParameters{0.02, 0.0003, -2e-6, 3.0, 0.15}, 2.0, 62.0, 0.5)},
      {"mpi that falls", std::make_shared<MpiModel>(MpiParameters{0.15, -0.0045, 3.5e-5, 5.0, 0.9}, 2.0, 62.0, 0.5)},
      {"poly", poly_of(false)},
      {"poly that wavers", poly_of(true)},
      {"preisach", preisach},
      {"linearised", std::make_shared<LinearisedModel>(Divider{0.25, 0.1}, preisach)},
      {"monotone", std::make_shared<MonotoneModel>(elam_of_seven_knots(false).ascending)}};
}

// Inputs on a way with turns, now and then the same again, the ends and beyond; in steps of 1 / 4 psi when round.
std::vector<double> inputs_to_and_fro(std::uint64_t seed, std::size_t count, bool round) {
  Numbers number(seed);
  std::vector<double> inputs;
  double at = 2.0;
  while (inputs.size() < count) {
    const double kind = number(), next = number();
    at = kind < 0.1 ? at : kind < 0.3 ? 70.0 * next - 4.0 : kind < 0.65 ? at + 6.0 * next : at - 6.0 * next;
    at = std::min(std::max(at, 1.0), 63.0);
    if (round) at = std::round(4.0 * at) / 4.0;
    inputs.push_back(at);
  }
  return inputs;
}

Summed state_goes(const HysteresisModel& model, bool measures) {
  Summed summed(2 * 400);
  const auto state = model.state();
  Numbers number(77);
  for (const bool round : {false, true}) {
    state->reset();
    for (const double x : inputs_to_and_fro(round ? 5 : 6, 400, round)) {
      const double y = 0.4 + 3.2 * number(), other = 2.0 + 60.0 * number();
      summed.add(state->output_at(other), state->input_at(round ? std::round(16.0 * y) / 16.0 : y), 0);
      state->go(x);
      if (measures && number() < 0.2) state->measured(state->output_at(x) + 0.4 * (number() - 0.5));
      summed.add(state->output_at(x), state->input_at(state->output_at(x)), 0);
    }
  }
  return summed;
}

Summed streams_read(const HysteresisModel& model) {
  Summed summed(3 * 300);
  InverseStream stream(model, 0.0625);
  ModelCompensator compensator(model, {0.5, 3.5, 0.0625}, {.noise_v = 0.02});
  std::vector<double> outputs;
  for (const double share : output_shares(31, 600, 0.01)) outputs.push_back(0.5 + 3.0 * share);
  for (std::size_t k = 0; k < outputs.size(); ++k) {
    if (k == 100) stream.reset();
    if (k % 200 == 150) stream.reset_unknown();
    if (k == 350) compensator.reset();
    const double output = k < 300 ? outputs[k] : std::round(16.0 * outputs[k]) / 16.0;
    summed.add(stream.reads(output + 0.1), stream.reads(output - 0.1), 0);
    summed.add(stream.step(output), 0.0, 0);
    summed.add(compensator.step(output));
  }
  return summed;
}

void check_models(const std::function<Summed(const HysteresisModel&)>& read, const std::vector<Sums>& was) {
  std::string lines;
  std::size_t at = 0;
  for (const NamedModel& one : models_of_each_kind()) {
    const Summed now = read(*one.model);
    check_sums(one.name, now, std::span(was).subspan(std::min(at, was.size())), lines);
    at += now.sums().size();
  }
  INFO("now:\n" << lines);
  CHECK(at == was.size());
}

}  // namespace

TEST_CASE("recorded: states of each model go along ways to and fro as they did when recorded") {
  check_models([](const HysteresisModel& model) { return state_goes(model, false); },
               {{2574.2151819, 36829.4298846, 0}, {2793.7113986, 38677.8889888, 0}, {2631.3246705, 36119.5501869, 0},
                {2821.6106491, 38232.5884742, 0}, {2587.4064264, 36623.1669218, 0}, {2792.5978799, 38674.8662219, 0},
                {2724.2320520, 35025.8874142, 0}, {2901.3288713, 37456.7726109, 0}, {2649.8657969, 36034.0311638, 0},
                {2836.9491520, 38155.6940074, 0}, {2591.5227215, 36556.6155688, 0}, {2801.8490095, 38623.1783646, 0},
                {4106.4496929, 25196.1783985, 0}, {4438.6271850, 27455.3478727, 0}, {2187.7859007, 40608.4611221, 0},
                {2298.2500402, 43238.5278579, 0}, {2173.0391384, 33253.5048564, 0}, {2318.8366409, 36465.7927687, 0},
                {2478.8489402, 37852.9888974, 0}, {2670.7817229, 39884.7530348, 0}, {2143.9018743, 41226.1888293, 0},
                {2085.9152454, 44863.1761216, 0}, {1863.9512690, 43683.1859281, 0}, {1949.8223242, 46335.7487388, 0},
                {1867.7128924, 43467.9828703, 0}, {1941.0091883, 46170.6230637, 0}, {2068.1142549, 41958.5865398, 0},
                {2130.8963599, 44805.1315182, 0}});
}

TEST_CASE("recorded: states of each model that measured outputs correct go as they did when recorded") {
  check_models([](const HysteresisModel& model) { return state_goes(model, true); },
               {{2563.1481743, 37481.0482060, 0}, {2806.5003834, 38496.4233528, 0}, {2621.8842508, 36748.0980068, 0},
                {2836.1811445, 38024.5377558, 0}, {2567.7341976, 37426.1524358, 0}, {2785.9901004, 38589.3734707, 0},
                {2709.7700906, 36018.6573151, 0}, {2889.0832456, 37450.7286912, 0}, {2644.2817909, 36623.2395773, 0},
                {2860.2502271, 37932.4928867, 0}, {2576.3903040, 37277.3618170, 0}, {2801.4561757, 38424.0247540, 0},
                {4093.2904152, 25538.9868994, 0}, {4424.9184848, 27467.9429449, 0}, {2133.3477711, 41272.8455024, 0},
                {2300.9049013, 42989.9266934, 0}, {2207.0400685, 33770.7104682, 0}, {2301.0349884, 36043.3123295, 0},
                {2470.2663981, 38280.2815396, 0}, {2687.2585549, 39585.6224611, 0}, {2131.8624388, 41941.0472617, 0},
                {2074.9211800, 44843.8010376, 0}, {1816.0238655, 44295.1667679, 0}, {1953.0605213, 46043.7317038, 0},
                {1834.2130096, 44170.9424965, 0}, {1942.7481053, 45970.7965137, 0}, {1998.4146743, 42443.1633585, 0},
                {2138.8580110, 44588.4849835, 0}});
}

TEST_CASE("recorded: streams that undo each model read what they read when recorded") {
  check_models(streams_read, {{50533.7303505, 15421.4793776, 10675}, {40439.9668747, 12089.9374746, 12369},
                              {49673.8367922, 15075.9689578, 10401}, {39005.6656960, 11410.6538082, 12387},
                              {51834.5489375, 15832.1389378, 14535}, {40609.1681163, 12021.9192362, 14790},
                              {49986.6561505, 14921.0522568, 14535}, {38771.3937079, 11159.8811917, 14790},
                              {47823.0381013, 14634.5376369, 13698}, {37628.7744895, 11045.7642745, 14268},
                              {51379.2676871, 15673.7430134, 14535}, {40943.4947432, 12130.4489027, 14790},
                              {21737.2406685, 5990.8089078, 13772},  {17383.9487549, 4771.3183229, 13501},
                              {61433.3860675, 19312.5835099, 14320}, {51199.6773384, 15931.0940799, 14596},
                              {35592.7093989, 12020.5870095, 1981},  {28616.2342101, 9821.1914475, 1568},
                              {52279.8188435, 15817.2319016, 14535}, {42933.1834176, 12674.6540778, 14790},
                              {70042.3224204, 23090.5015517, 1228},  {66351.8361059, 21850.3738884, 542},
                              {69556.9611661, 22219.0108231, 6498},  {57509.0562834, 18178.9049619, 9799},
                              {72473.1778900, 23375.3768972, 6437},  {58225.7983979, 18162.6632200, 10003},
                              {64179.4013642, 20571.6158548, 655},   {55526.3887789, 17610.1161848, 567}});
}
