// Frames of an array: the same from a sensor's model, taxel by taxel, from its document, and through the C API.

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include <array>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <new>
#include <stdexcept>

#include "analysis/compensate/compensator_c.h"
#include "analysis/compensate/curves.h"
#include "analysis/compensate/document.h"
#include "analysis/compensate/turning.h"
#include "analysis/identify/sensor_model.h"
#include "analysis/identify/stored/model_document.h"
#include "tests/analysis/compensate/kinds.h"
#include "tests/analysis/support/fit_samples.h"
#include "tests/support/process.h"

using namespace synthetic;

namespace {

// Counts what this thread takes from the heap while it is told to.
thread_local bool counting = false;
thread_local int allocations = 0;

void* counted_or_null(std::size_t size) noexcept {
  if (counting) ++allocations;
  return std::malloc(size == 0 ? 1 : size);
}

void* counted(std::size_t size) {
  void* memory = counted_or_null(size);
  if (memory == nullptr) throw std::bad_alloc();
  return memory;
}

}  // namespace

// Not inlined: GCC 12 would see malloc() meet delete, or new meet free(), and warn.
[[gnu::noinline]] void* operator new(std::size_t size) { return counted(size); }
[[gnu::noinline]] void* operator new[](std::size_t size) { return counted(size); }
// The standard library's temporary buffers ask so, and give back through the plain delete.
[[gnu::noinline]] void* operator new(std::size_t size, const std::nothrow_t& /*tag*/) noexcept {
  return counted_or_null(size);
}
[[gnu::noinline]] void* operator new[](std::size_t size, const std::nothrow_t& /*tag*/) noexcept {
  return counted_or_null(size);
}
[[gnu::noinline]] void operator delete(void* memory) noexcept { std::free(memory); }
[[gnu::noinline]] void operator delete[](void* memory) noexcept { std::free(memory); }
[[gnu::noinline]] void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }
[[gnu::noinline]] void operator delete[](void* memory, std::size_t) noexcept { std::free(memory); }

namespace {

constexpr double kUnreportedExit = std::numeric_limits<double>::quiet_NaN();

struct Results {
  std::array<float, kThree> pressure{}, uncertainty{};
  std::array<std::uint16_t, kThree> status{};
  FrameCompensator::Output output() { return {pressure, uncertainty, status}; }
  bool operator==(const Results&) const = default;
};

// Random reversals with spikes and samples that are no numbers, row by row.
std::vector<std::array<float, kThree>> frames_along(const Kind& kind, bool falling, std::size_t count = 400) {
  const Walk walk = walk_of(kind, reversals(kind, count, 1.0, 5), 1.0 / 2000.0, 8);
  std::vector<std::array<float, kThree>> frames;
  for (std::size_t i = 0; i < count; ++i) {
    std::array<double, kThree> own{walk.output[i], 0.1, kOutputZero + 0.9 * (walk.output[i] - kOutputZero)};
    if (i % 41 == 17) own[0] = 3.0 * kOutputGain * kind.full();
    if (i % 53 == 29) own[2] = kUnreportedExit;
    auto& frame = frames.emplace_back();
    for (std::size_t t = 0; t < kThree; ++t) frame[t] = static_cast<float>(falling ? -own[t] : own[t]);
  }
  return frames;
}

struct Handle {
  tb_compensator* of = nullptr;
  ~Handle() { tb_compensator_destroy(of); }
};

}  // namespace

TEST_CASE("FrameCompensator: model, single taxels, document and C API give the same frames, for every model kind") {
  const tactbench::tests::TemporaryFolder folder;
  for (const Kind& kind : kinds())
    for (const bool falling : {false, true}) {
      const SensorModel model = sensor_of(kind, falling);
      const std::string text = to_text(model);
      tactbench::tests::write_file(folder.path("m.json"), text);
      for (const unsigned scans : {0U, 1U}) {
        INFO(kind.name << (falling ? ", falling" : "") << ", scans " << scans);
        const double noisier = scans == 1 ? std::sqrt(2.0) : 1.0;
        FrameCompensator of_model = frames_of(model, noisier);
        DocumentFrames of_document = frames_from_document(text, static_cast<int>(scans));
        Handle parsed, loaded;
        REQUIRE(tb_compensator_parse(text.c_str(), scans, &parsed.of, nullptr, 0) == TB_COMPENSATOR_OK);
        REQUIRE(tb_compensator_load(folder.path("m.json").c_str(), scans, &loaded.of, nullptr, 0) == TB_COMPENSATOR_OK);
        CHECK(tb_compensator_taxels(loaded.of) == kThree);
        const auto first = compensator_of(model, model.taxels[0], noisier);
        first->start(Start::kUnknown);
        Results a, b, c, d;
        const auto same = [&] { return a == b && a == c && a.pressure == d.pressure && a.status == d.status; };
        int frame = 0;
        for (const auto& outputs : frames_along(kind, falling)) {
          const double seconds = frame == 0 ? kUnreportedExit : 0.4;
          of_model.frame(outputs, seconds, a.output());
          of_document.frames.frame(outputs, seconds, b.output());
          CHECK(tb_compensator_frame(parsed.of, outputs.data(), kThree, seconds, c.pressure.data(),
                                     c.uncertainty.data(), c.status.data()) == TB_COMPENSATOR_OK);
          CHECK(tb_compensator_frame(loaded.of, outputs.data(), kThree, seconds, d.pressure.data(), nullptr,
                                     d.status.data()) == TB_COMPENSATOR_OK);
          REQUIRE(same());
          const double output = static_cast<double>(falling ? -outputs[0] : outputs[0]);
          const Compensated one = first->step(output, frame == 0 ? 0.0 : 0.4);
          REQUIRE(static_cast<float>(one.pressure_psi) == a.pressure[0]);
          CHECK(a.status[1] == kTaxelDead);
          if (++frame % 90 == 0) {
            of_model.lost_frame(0.4, a.output());
            of_document.frames.lost_frame(0.4, b.output());
            CHECK((tb_compensator_lost_frame(parsed.of, 0.4) == 0 && tb_compensator_lost_frame(loaded.of, 0.4) == 0));
            first->lost(0.4);
          }
          if (frame == 200) {
            of_model.start(Start::kAtRest);
            of_model.work(30.0);
            of_document.frames.start(Start::kAtRest);
            of_document.frames.work(30.0);
            for (tb_compensator* const own : {parsed.of, loaded.of})
              CHECK(tb_compensator_start(own, 1, 30.0) == TB_COMPENSATOR_OK);
            first->start(Start::kAtRest);
            first->work(30.0);
            frame = 0;
          }
        }
      }
    }
}

TEST_CASE("FrameCompensator: sets status bits of lost, dead and out-of-range taxels, and refuses invalid frames") {
  for (const Kind& kind : kinds()) {
    INFO(kind.name);
    const SensorModel model = sensor_of(kind);
    FrameCompensator frames = frames_of(model, 1.0, 2);
    Results now;
    const auto low = static_cast<float>(kind.measured(kind.model->state()->output_at(kind.model->x_low())));
    const auto half = low + static_cast<float>(0.4 * kOutputGain * kind.full());
    const auto give = [&](float first, double seconds = 0.4) {
      frames.frame(std::array<float, kThree>{first, 0.0F, half}, seconds, now.output());
      return now.status[0];
    };
    const bool two_ways = kind.name != "monotone";
    CHECK(frames.tare(std::array<float, kThree>{low, 0.0F, 1e3F}) == 1);
    CHECK((give(half) & ~kTaxelFlat) == kTaxelValid);
    CHECK(now.status[1] == kTaxelDead);
    CHECK((now.pressure[1] == static_cast<float>(kind.model->x_low()) &&
           now.uncertainty[1] == static_cast<float>(kind.span())));
    CHECK(((now.status[2] & kTaxelUnknown) != 0) == two_ways);
    CHECK((give(std::nanf("")) & ~kTaxelFlat) == kTaxelLost);
    CHECK((give(half + 1e3F) & ~kTaxelFlat) == kTaxelOutOfRange);
    frames.set_outside_validity(true);
    CHECK((give(half) & ~kTaxelFlat) == kTaxelOutside);
    frames.set_outside_validity(false);
    for (int i = 0; i < 2; ++i) frames.lost_frame(0.4, now.output());
    CHECK((now.status[0] & ~kTaxelFlat) == kTaxelLost);
    CHECK(now.status[1] == kTaxelDead);
    CHECK((give(half) & ~kTaxelFlat) == kTaxelValid);
    for (int i = 0; i < 3; ++i) frames.lost_frame(0.4, now.output());
    CHECK(((give(half) & kTaxelUnknown) != 0) == two_ways);

    // A model in time is told the time, but of the first frame; of others it may be not known.
    frames.start(Start::kAtRest);
    CHECK(frames.needs_time() == false);
    give(half, kUnreportedExit);
    CHECK(frames.needs_time() == kind.in_time);
    if (kind.in_time)
      CHECK_THROWS_AS(give(half, kUnreportedExit), std::invalid_argument);
    else
      CHECK_NOTHROW(give(half, kUnreportedExit));
    const Results before = now;
    for (const double wrong : {-0.1, HUGE_VAL}) {
      CHECK_THROWS_AS(give(half, wrong), std::invalid_argument);
      CHECK_THROWS_AS(frames.lost_frame(wrong, now.output()), std::invalid_argument);
    }
    CHECK(now == before);
    CHECK_THROWS_AS(frames.frame(std::array<float, 2>{}, 0.4, now.output()), std::invalid_argument);
    CHECK_THROWS_AS(frames.frame(std::array<float, kThree>{}, 0.4, {now.pressure, now.uncertainty, {}}),
                    std::invalid_argument);
    CHECK_THROWS_AS(frames.tare(std::array<float, 2>{}), std::invalid_argument);
    give(half, 0.4);
    if (!kind.in_time) CHECK(now.pressure[0] == Approx(before.pressure[0]).margin(0.01 * kind.span()));
  }
  SensorModel part = sensor_of(kinds().front());
  part.rows = 2;
  CHECK(id_of_refusal([&] { (void)frames_of(part); }) == "TB-MODEL-COMPENSATOR");
  CHECK_THROWS_AS(frames_from_document(to_text(part), 0), std::invalid_argument);
  SensorModel wild = sensor_of(kinds().back());
  wild.taxels[2].creep_scale = 11.0;
  CHECK(id_of_refusal([&] { (void)compensator_of(wild, wild.taxels[2]); }) == "TB-MODEL-COMPENSATOR");
}

TEST_CASE("FrameCompensator: a document with a missing or wrong member is refused and leaves no handle") {
  using Json = nlohmann::ordered_json;
  for (const Kind& kind : {kinds().front(), kinds().back()}) {
    const Json whole = Json::parse(to_text(sensor_of(kind)));
    const auto refused = [&](const char* pointer, const Json& value) {
      Json json = whole;
      const Json::json_pointer at(pointer);
      REQUIRE(json.contains(at));
      if (value.is_null())
        json[at.parent_pointer()].erase(at.back());
      else
        json[at] = value;
      INFO(kind.name << ": " << pointer << " is " << value);
      Handle handle{reinterpret_cast<tb_compensator*>(1)};
      char message[200] = "";
      CHECK(tb_compensator_parse(json.dump().c_str(), 0, &handle.of, message, sizeof message) == TB_COMPENSATOR_VALUE);
      CHECK(handle.of == nullptr);
      CHECK(std::strlen(message) > 0);
      CHECK_THROWS_AS(frames_from_document(json.dump(), 0), std::invalid_argument);
    };
    for (const char* const pointer :
         {"/schema", "/output/falling", "/output/scans", "/sensor/rows", "/taxels", "/taxels/0/taxel",
          "/taxels/0/status", "/taxels/0/zero", "/taxels/0/gain", "/taxels/0/noise", "/taxels/0/model",
          "/taxels/0/loop_low", "/taxels/0/figures/full_scale"})
      refused(pointer, nullptr);
    for (const char* const pointer : {"/output/falling", "/output/scans", "/sensor/columns", "/taxels/0/gain"})
      refused(pointer, "much");
    refused("/sensor/rows", 7);
    refused("/taxels/0/gain", 0.0);
    refused("/taxels/2/noise", -1.0);
    refused("/taxels/2/taxel", 5);
    refused("/taxels", Json::array());
    if (!kind.in_time) continue;
    for (const char* const pointer : {"/dynamics/creep_s", "/dynamics/creep_share", "/dynamics/lag_s",
                                      "/dynamics/residual_shape", "/taxels/0/creep_scale", "/taxels/0/lag_share"})
      refused(pointer, nullptr);
    refused("/dynamics/creep_s", Json::array({1.0, 2.0}));
    refused("/dynamics/creep_share", Json::array({0.9, 0.2, 0.1}));
    refused("/taxels/2/lag_share", 1.0);
  }
  CHECK_THROWS_AS(frames_from_document("{", 0), std::invalid_argument);
  CHECK_THROWS_AS(frames_from_document("[]", 0), std::invalid_argument);
}

TEST_CASE("C API: returns error codes and truncated messages, and a refusal leaves the state unchanged") {
  const tactbench::tests::TemporaryFolder folder;
  const std::string text = to_text(sensor_of(kinds().back()));  // in time
  CHECK(tb_compensator_abi_version() == TB_COMPENSATOR_ABI_VERSION);
  char message[60];
  Handle handle;
  const auto parse = [&](const char* own, tb_compensator** to) {
    std::strcpy(message, "untouched");
    return tb_compensator_parse(own, 0, to, message, sizeof message);
  };
  CHECK((parse(nullptr, &handle.of) == TB_COMPENSATOR_NULL && handle.of == nullptr && message[0] != 0));
  CHECK(parse(text.c_str(), nullptr) == TB_COMPENSATOR_NULL);
  CHECK(tb_compensator_load(nullptr, 0, &handle.of, nullptr, 0) == TB_COMPENSATOR_NULL);
  for (const std::string& file : {folder.path("none.json"), folder.path(".")})
    CHECK((tb_compensator_load(file.c_str(), 0, &handle.of, message, sizeof message) == TB_COMPENSATOR_FILE &&
           handle.of == nullptr));
  char small[5];
  CHECK(tb_compensator_parse("{", 0, &handle.of, small, sizeof small) == TB_COMPENSATOR_VALUE);
  CHECK(std::strlen(small) == 4);
  REQUIRE((parse(text.c_str(), &handle.of) == TB_COMPENSATOR_OK && message[0] == 0));

  float psi[kThree] = {}, volts[kThree] = {0.3F, 0.0F, 0.3F};
  std::size_t off = 9;
  const auto frame = [&](double seconds) {
    return tb_compensator_frame(handle.of, volts, kThree, seconds, psi, nullptr, nullptr);
  };
  CHECK(tb_compensator_tare(handle.of, volts, kThree, &off) == TB_COMPENSATOR_OK);
  CHECK(off == 0);
  CHECK(frame(kUnreportedExit) == TB_COMPENSATOR_OK);  // the first
  volts[0] = 1.0F;
  CHECK(frame(kUnreportedExit) == TB_COMPENSATOR_TIME);
  CHECK(frame(-1.0) == TB_COMPENSATOR_VALUE);
  CHECK(frame(HUGE_VAL) == TB_COMPENSATOR_VALUE);
  CHECK(tb_compensator_lost_frame(handle.of, kUnreportedExit) == TB_COMPENSATOR_TIME);
  CHECK(tb_compensator_lost_frame(handle.of, -1.0) == TB_COMPENSATOR_VALUE);
  CHECK(tb_compensator_start(handle.of, 1, -1.0) == TB_COMPENSATOR_VALUE);
  CHECK(tb_compensator_start(handle.of, 1, kUnreportedExit) == TB_COMPENSATOR_VALUE);
  CHECK(tb_compensator_frame(handle.of, volts, 2, 0.4, psi, nullptr, nullptr) == TB_COMPENSATOR_SIZE);
  CHECK(tb_compensator_tare(handle.of, volts, 4, nullptr) == TB_COMPENSATOR_SIZE);
  CHECK(tb_compensator_frame(handle.of, nullptr, kThree, 0.4, psi, nullptr, nullptr) == TB_COMPENSATOR_NULL);
  CHECK(tb_compensator_frame(handle.of, volts, kThree, 0.4, nullptr, nullptr, nullptr) == TB_COMPENSATOR_NULL);
  CHECK(tb_compensator_tare(handle.of, nullptr, kThree, nullptr) == TB_COMPENSATOR_NULL);
  CHECK(frame(0.4) == TB_COMPENSATOR_OK);
  const float once = psi[0];
  Handle untroubled;
  REQUIRE(tb_compensator_parse(text.c_str(), 0, &untroubled.of, nullptr, 0) == TB_COMPENSATOR_OK);
  const float rest[kThree] = {0.3F, 0.0F, 0.3F};
  tb_compensator_tare(untroubled.of, rest, kThree, nullptr);
  tb_compensator_frame(untroubled.of, rest, kThree, kUnreportedExit, psi, nullptr, nullptr);
  tb_compensator_frame(untroubled.of, volts, kThree, 0.4, psi, nullptr, nullptr);
  CHECK(psi[0] == once);
  std::uint16_t bits[kThree] = {};
  CHECK(tb_compensator_set_outside_validity(handle.of, 1) == TB_COMPENSATOR_OK);
  CHECK(tb_compensator_frame(handle.of, volts, kThree, 0.4, psi, nullptr, bits) == TB_COMPENSATOR_OK);
  CHECK((bits[0] & (TB_TAXEL_OUTSIDE | TB_TAXEL_VALID)) == TB_TAXEL_OUTSIDE);

  CHECK(tb_compensator_frame(nullptr, volts, kThree, 0.4, psi, nullptr, nullptr) == TB_COMPENSATOR_NULL);
  CHECK(tb_compensator_lost_frame(nullptr, 0.4) == TB_COMPENSATOR_NULL);
  CHECK(tb_compensator_start(nullptr, 1, 0.0) == TB_COMPENSATOR_NULL);
  CHECK(tb_compensator_tare(nullptr, volts, kThree, nullptr) == TB_COMPENSATOR_NULL);
  CHECK(tb_compensator_set_outside_validity(nullptr, 1) == TB_COMPENSATOR_NULL);
  CHECK(tb_compensator_taxels(nullptr) == 0);
  tb_compensator_destroy(nullptr);
}

TEST_CASE("FrameCompensator: ELAM and table models allocate no memory while they process frames") {
  for (const Kind& kind : kinds()) {
    if (kind.name != "elam" && kind.name != "preisach" && kind.name != "linearised in time") continue;
    FrameCompensator frames = frames_of(sensor_of(kind), 1.0, 3);
    Results now;
    const auto given = frames_along(kind, false);
    counting = true;
    for (std::size_t i = 0; i < given.size(); ++i) {
      frames.frame(given[i], 0.4, now.output());
      for (std::size_t lost = 0; i % 60 == 10 && lost < i / 60; ++lost) frames.lost_frame(0.4, now.output());
      if (i == 100) frames.start(Start::kAtRest);
      if (i == 150) frames.tare(given[0]);
      if (i == 200) frames.work(30.0);
    }
    counting = false;
    INFO(kind.name);
    CHECK(allocations == 0);
  }
}

// The curves of the compensator: pieces are correct for all of their outputs, ELAM's curves equal the paper's.

namespace {

std::shared_ptr<const PreisachCurve::Film> film_table(const PreisachModel& model, double per_amplitude) {
  auto film = std::make_shared<PreisachCurve::Film>();
  *film = {model.x_low(), model.x_high(), model.intervals(), {0.0, per_amplitude}, {}};
  const auto at = [&](std::size_t i) {
    return model.x_low() + (model.x_high() - model.x_low()) * static_cast<double>(i) / static_cast<double>(film->n);
  };
  for (std::size_t i = 0; i <= film->n; ++i)
    for (std::size_t j = 0; j <= i; ++j) film->everett.push_back(model.everett(at(i), at(j)));
  return film;
}

// Along drawn turns, of which many close loops: what a piece says of any of its outputs, asked for or gone to, is what
// the curve says there.
template <class Curve>
void check_pieces(Curve curve, unsigned seed) {
  Random draw(seed);
  const double top = curve.top(), span = curve.x_high() - curve.x_low();
  bool rises = true;
  double from = 0.0;
  std::vector<double> turns(4, 0.0);
  curve.start(false);
  for (int turn = 0; turn < 400; ++turn) {
    double furthest = from;
    Curve gone_on = curve;
    CurvePiece kept;
    for (int i = 0; i < 12; ++i) {
      const double share = 0.1 * i * draw(0.2, 1.0);
      double y = rises ? from + share * (1.02 * top - from) : from * (1 - share);
      // Exactly where a loop closes.
      const double earlier = turns[turns.size() - 1 - static_cast<std::size_t>(draw(0.0, 3.999))];
      if (i % 3 == 2 && (rises ? earlier > from : earlier < from)) y = earlier;
      const double u = curve.place(y);
      const CurvePiece piece = curve.piece(u);
      REQUIRE(piece.holds(u));
      // Ahead: behind may lie a loop that closed on the way.
      const double ahead =
          rises ? std::min(piece.high, curve.place(1.1 * top)) : std::max(piece.low, curve.place(-0.1 * top));
      const double other = u + draw(0.0, 1.0) * (ahead - u);
      INFO("turn " << turn << ", " << (rises ? "rising" : "falling") << " from " << from << ": the piece of " << y);
      REQUIRE(curve.piece(other).along(other) == Approx(piece.along(other)).margin(1e-7 * span));
      const double x = curve.input(piece.along(u));
      REQUIRE((x >= curve.x_low() - 1e-9 * span && x <= curve.x_high() + 1e-9 * span));
      if (rises ? y < furthest : y > furthest) continue;
      // As a stream walks: it goes where its kept piece ends, and a jump lands on the same.
      furthest = y;
      if (!kept.holds(u)) {
        gone_on.go(u);
        kept = gone_on.piece(u);
      }
      REQUIRE(kept.along(u) == Approx(piece.along(u)).margin(1e-7 * span));
    }
    curve = gone_on;
    curve.turn(curve.back_from(curve.place(furthest), curve.piece(curve.place(furthest))));
    turns.push_back(from = furthest);
    rises = !rises;
    if (rises ? from < 0.001 * top : from > 0.999 * top) {  // at an end it does not turn again at once
      curve.start(rises ? false : true);
      from = rises ? 0.0 : top;
    }
  }
}

}  // namespace

TEST_CASE("curve pieces: equal the curve up to the end of their branch, along nested loops that close") {
  for (const unsigned seed : {1U, 2U, 3U})
    for (const Kind& kind : kinds()) {
      if (kind.in_time) continue;
      INFO(kind.name << ", seed " << seed);
      check_pieces(StateCurve(*kind.truth, 0.0), seed);
      if (kind.name == "elam") check_pieces(ElamStack(dynamic_cast<const ElamHysteresis&>(*kind.model).elam()), seed);
    }
  for (const unsigned seed : {1U, 2U, 3U})
    for (const double per_amplitude : {0.0, 0.13}) {
      INFO("table, seed " << seed);
      check_pieces(PreisachCurve(film_table(film_of(seed, 20), per_amplitude)), seed);
      check_pieces(PreisachCurve(film_table(random_preisach(seed, 30), 0.0)), seed);
    }
}

TEST_CASE("ElamStack: branches that leave the external loop equal the paper's curves") {
  for (ElamModel model : Array({.rows = 3, .columns = 3}).taxels)
    for (const bool exact : {false, true}) {
      model.options.exact_outer = exact;
      const double y0 = model.y0(), yu = model.yu();
      ElamStack stack(model);
      const auto compare = [&](const ElamCurve& paper, double y) {
        REQUIRE(stack.piece(y - y0).along(y - y0) == Approx(paper.input(y)).margin(1e-9));
      };
      const ElamCurve up(model, true, model.x0(), y0), down(model, false, model.xu(), yu);
      for (int i = 0; i <= 60; ++i) {
        // Rising to x, and down from there: Eqs (31) to (34), but not where the drift's allowance moves the split.
        const double y = y0 + (yu - y0) * i / 60.0, x = up.input(y);
        stack.start(false);
        compare(up, y);
        stack.turn(stack.back_from(y - y0, stack.piece(y - y0)));
        if (yu - y > 2.0 * ElamStack::kDriftShare * (yu - y0) || i == 60)
          for (int k = 0; k <= 40; ++k)
            compare(i == 60 ? down : ElamCurve(model, false, x, y), y0 + (y - y0) * k / 40.0);
        // Falling from the top, and up from there: Eqs (35) to (38).
        stack.start(true);
        compare(down, y);
        stack.turn(stack.back_from(y - y0, stack.piece(y - y0)));
        if (i > 0 && i < 60)
          for (int k = 0; k <= 40; ++k) compare(ElamCurve(model, true, down.input(y), y), y + (yu - y) * k / 40.0);
      }
    }
}

TEST_CASE("TurningCompensator: cached curve pieces and an uncached curve give the same readings on noisy holds") {
  const PreisachModel film = film_of(1, 60);  // a state's pieces have no length: nothing is kept of it
  const double top = film.everett(film.x_high(), film.x_low());
  CompensatorSetup setup;
  setup.zero = film.y_low();
  setup.noise = 0.02 * top;
  TurningCompensator<PreisachCurve> kept(PreisachCurve(film_table(film, 0.0)), setup);
  TurningCompensator<StateCurve> asked(StateCurve(film, 0.0), setup);
  std::mt19937 random(3);
  std::normal_distribution<double> noise(0.0, setup.noise);
  for (const double level : {0.3, 0.7, 0.5, 0.2, 0.6})
    for (int i = 0; i < 400; ++i) {
      const double output = setup.zero + top * level + noise(random);
      const Compensated a = kept.step(output, 0.0), b = asked.step(output, 0.0);
      REQUIRE(a.pressure_psi == Approx(b.pressure_psi).margin(1e-6 * (film.x_high() - film.x_low())));
      REQUIRE(a.uncertainty_psi == Approx(b.uncertainty_psi).epsilon(1e-6));
    }
}
