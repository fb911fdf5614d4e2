// States of models along ways in round numbers: at each step what lies beside the place, at knots and at both ends, to
// the last bit, as it was when recorded.
#include <catch2/catch.hpp>
#include <cmath>
#include <memory>
#include <vector>

#include "analysis/models/elam_hysteresis.h"
#include "analysis/models/linearised.h"
#include "analysis/models/monotone.h"
#include "analysis/models/mpi.h"
#include "analysis/models/poly.h"
#include "analysis/models/preisach.h"
#include "tests/analysis/compensate/recorded_streams.h"
#include "tests/analysis/support/bits.h"

using namespace tactbench::analysis;
using recorded::Numbers;
using to_the_bit::Bits;

namespace {

const std::vector<double> kInputs{0.0, 8.0, 20.0, 32.0, 44.0, 56.0, 64.0};

// From `low` on; outputs from 0.5 to 3.5.
ElamModel round_elam(double low, bool exact_outer, bool flat) {
  std::vector<double> x = kInputs;
  for (double& at : x) at += low;
  const std::vector<double> up{0.5, 0.625, 1.0, 1.5, 2.125, 2.75, 3.5}, down{0.5, 1.5, 2.5, 3.0, 3.25, 3.375, 3.5};
  const std::vector<double> flat_up{0.5, 0.5, 0.5, 1.5, 2.5, 3.5, 3.5}, flat_down{0.5, 2.5, 3.5, 3.5, 3.5, 3.5, 3.5};
  return {PatternCurve(x, flat ? flat_up : up, 0.5, 3.5),
          PatternCurve(x, flat ? flat_down : down, 0.5, 3.5),
          {0.625, 0.75, 0.25 / 64.0, 0.25, 0.375},
          {exact_outer}};
}

// Goes to and fro in quarters of a psi over a range 64 long; `measures`: now and then the output was another.
std::string walked(const HysteresisModel& model, bool measures) {
  Bits bits;
  Numbers number(9);
  const auto state = model.state();
  const double low = model.x_low();
  const double near = 0.01 * 64.0;
  double at = low;
  for (int step = 0; step < 500; ++step) {
    if (step % 100 == 99) state->reset();
    const double kind = number(), way = std::floor(64.0 * number()) / 4.0;
    at = kind < 0.08   ? low
         : kind < 0.16 ? low + 64.0
         : kind < 0.2  ? low + near
         : kind < 0.24 ? (low < 0.0 ? -near : low + 64.0 - near)
         : kind < 0.4  ? low + kInputs[static_cast<std::size_t>(7.0 * number())]
         : kind < 0.7  ? at + way
         : kind < 0.95 ? at - way
                       : low + 70.0;
    state->go(at);
    if (measures && number() < 0.25) {
      const double off = number() < 0.3 ? 0.0 : (std::floor(17.0 * number()) - 8.0) / 8.0;
      state->measured(state->output_at(at) + off);
    }
    const double here = state->output_at(at);
    bits.add(here);
    for (const double y : {here, to_the_bit::just_below(here), to_the_bit::just_above(here), 0.5, 3.5, 2.0, 0.25, 4.0})
      bits.add(state->input_at(y));
    for (const double x : {to_the_bit::just_below(at), to_the_bit::just_above(at), at + 4.0, at - 4.0})
      bits.add(state->output_at(x));
    for (const double x : kInputs) {
      const double y = state->output_at(low + x);
      bits.add(y);
      bits.add(state->input_at(y));
    }
  }
  return bits.text();
}

std::shared_ptr<HysteresisModel> elam_state(double low, bool exact, bool flat, bool memory, ElamPieces pieces = {}) {
  return std::make_shared<ElamHysteresis>(round_elam(low, exact, flat), memory, std::move(pieces));
}

std::shared_ptr<PreisachModel> film(double unit) {
  std::vector<double> weights;
  for (int i = 0; i < 21; ++i) weights.push_back(unit * static_cast<double>((i * 7) % 5));
  return std::make_shared<PreisachModel>(0.0, 64.0, 0.5, weights);
}

}  // namespace

TEST_CASE("recorded: ELAM's states along round ways are the same to the last bit") {
  const ElamPieces even{{0.0}, {0.0, 0.0}, {0.0, 0.0}, {0.0}};
  const std::vector<std::string> was{"03f78ac20ef8da5b", "81e60e7e6c4bcde4", "bc347b172c8eb2c5", "2cd854e0600fbd0c",
                                     "42b2a12e206d1443", "ac3022d938e4fd37", "9c2b01df29f33b5c", "bcd57a9d3f0330b0",
                                     "2198b551ddd625bd", "a187c0119b4d3b1a", "7f16667d4b546365", "a328c38098d86d00",
                                     "3e1d4be9602394f6", "0d69ee347a6dd046", "6eab1aa1909cc784", "8a52004687b3d599",
                                     "9c9d7c40b87e01e2", "9e54425880d572a6"};
  std::vector<std::string> now;
  for (const bool measures : {false, true})
    for (const bool flat : {false, true})
      for (const bool memory : {false, true})
        for (const bool exact : {false, true})
          now.push_back(walked(*elam_state(exact ? 0.0 : -64.0, exact, flat, memory), measures));
  for (const bool memory : {false, true})
    now.push_back(walked(*elam_state(memory ? 3.0 : -64.0, memory, false, memory, even), true));
  CHECK(now == was);
}

TEST_CASE("recorded: states of the other models along round ways are the same to the last bit") {
  PolyParameters bent, wavers;
  bent.a[4] = 1.0 / 4096.0, bent.b[4] = -1.0 / 4096.0, bent.b[5] = 2.0 / 64.0;
  wavers.a = {0.0, 0.0, 0.0, 2e-5, -0.0018, 0.0486, 0.0};
  wavers.b = {0.0, 2e-8, -2e-6, 1e-4, -0.0036, 0.087, 0.0};
  const std::vector<double> up{0.5, 0.625, 1.0, 1.5, 2.125, 2.75, 3.5};
  const std::vector<std::shared_ptr<HysteresisModel>> models{
      film(0.125),
      film(1.0 / 30.0),
      std::make_shared<LinearisedModel>(Divider{0.25, 0.125}, film(0.1)),
      std::make_shared<MonotoneModel>(PatternCurve(kInputs, up, 0.5, 3.5)),
      std::make_shared<MpiModel>(MpiParameters{0.03125, 0.0, 0.0, 1.25, 0.0}, 0.0, 64.0, 0.5),
      std::make_shared<MpiModel>(MpiParameters{0.15, -0.0045, 3.5e-5, 5.0, 0.0}, 0.0, 64.0, 0.5),
      std::make_shared<PolyModel>(bent, 0.0, 64.0, 0.5, 3.5),
      std::make_shared<PolyModel>(bent, -64.0, 0.0, 0.5, 3.5),
      std::make_shared<PolyModel>(wavers, 0.0, 64.0, 0.5, 3.5)};
  const std::vector<std::string> was{"f2865dc856ceaa7d", "178828fc138cf888", "c05cf1c7c759567f", "f31feec50d1f7aa4",
                                     "d176370aa55ef7cd", "e527be1220456f97", "dc9c98ca0a57f31e", "e2e1beb9e3181aab",
                                     "821e08bb89b8935f", "58f361b2bea1710b", "261ca7449a36cb8d", "bb484be3a461a2d7",
                                     "417be349faa81fdd", "300d656a905b5961", "df235ba510b1d477", "4c6d900c67ad504d",
                                     "8003b4aeb0d50ade", "8258115b12da06a4"};
  std::vector<std::string> now;
  for (const auto& model : models)
    for (const bool measures : {false, true}) now.push_back(walked(*model, measures));
  CHECK(now == was);
}
