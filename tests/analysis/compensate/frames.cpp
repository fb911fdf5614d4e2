// Frames of an array: the same from a sensor's model, taxel by taxel, from its document, and through the C API.
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <new>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "analysis/compensate/compensator_c.h"
#include "analysis/compensate/document.h"
#include "analysis/identify/sensor_model.h"
#include "analysis/identify/stored/model_document.h"
#include "tests/analysis/compensate/kinds.h"
#include "tests/analysis/identify/refusals.h"
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
