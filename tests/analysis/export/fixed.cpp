// The compensator in integers against the one in doubles, and what it promises a device.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <memory>
#include <random>
#include <sstream>
#include <string>
#include <vector>

#include "analysis/export/quantise.h"
#include "analysis/export/write_export.h"
#include "analysis/identify/sensor_model.h"
#include "tests/analysis/compensate/kinds.h"

using namespace synthetic;

namespace {

constexpr double kPerCount = 5.0 / 65535.0, kRate = 76.0;

Kind kind_of(const std::string& name) {
  const std::vector<Kind> all = kinds();
  return *std::ranges::find(all, name, &Kind::name);
}

FixedOptions device() { return {kPerCount, kRate, 2, 0.0, 0.0}; }

std::shared_ptr<const FixedModel> fixed_of(const Kind& kind, bool falling = false) {
  return std::make_shared<const FixedModel>(quantised(sensor_of(kind, falling), device()));
}

const char* const kBoth[] = {"elam", "linearised in time"};

// Counts of taxel 0 along a way at kRate, without noise beyond what they are rounded to where `noise` is 0.
std::vector<std::uint16_t> counts_along(const Kind& kind, const FixedModel& fixed, const std::vector<double>& way,
                                        double noise, bool falling = false) {
  Walker walker(kind, noise, 5, 1.0 / kRate);
  walker.go_along(way);
  std::vector<std::uint16_t> counts;
  for (const double output : walker.walk.output) counts.push_back(count_of(fixed, falling ? 5.0 - output : output));
  return counts;
}

std::vector<double> straight(double from, double to, int samples) {
  std::vector<double> way;
  for (int i = 0; i < samples; ++i) way.push_back(from + (to - from) * i / (samples - 1));
  return way;
}

}  // namespace

TEST_CASE("fixed compensator: thresholds equal the rule's for means of one to eight samples") {
  const CompensatorOptions rule;
  REQUIRE(rule.longest_mean == TB_LONGEST_MEAN);
  for (int n = 1; n <= rule.longest_mean; ++n) {
    const double weight = 1.0 / n;
    CHECK(tb_jump[n - 1] == Approx(256.0 * rule.jump_in_noises * std::sqrt(1.0 + weight)).margin(0.51));
    CHECK(tb_step_share[n - 1] == Approx(65536.0 * (1.0 - 0.5 * weight)).margin(0.51));
    if (n > 1) CHECK(tb_part[n - 1] == Approx(65536.0 * weight).margin(0.51));
    CHECK(tb_lead[n - 1] == Approx(256.0 * rule.lead_in_noises * std::sqrt(weight) * (1.0 - weight)).margin(0.51));
    CHECK(tb_band[n - 1] == Approx(256.0 * rule.band_in_noises * std::sqrt(weight)).margin(0.51));
    CHECK(tb_hold[n - 1] == Approx(256.0 * rule.hold_in_noises * std::sqrt(weight)).margin(0.51));
  }
  CHECK(TB_MOVING == Approx(4096.0 * rule.moving).margin(1.0));
  CHECK(TB_REST == Approx(256.0 * rule.rest_in_noises).margin(0.51));
  CHECK(TB_BAND == Approx(256.0 * rule.band_in_noises).margin(0.51));
  CHECK(TB_LONGEST_SPIKE == rule.longest_spike);
}

TEST_CASE("fixed compensator: products and quotients of 16 bits are rounded down") {
  std::mt19937 random(1);
  for (int i = 0; i < 20000; ++i) {
    const auto a = static_cast<std::int32_t>(random());
    const auto b = static_cast<std::uint16_t>(random());
    const double product = std::floor(static_cast<double>(a) * b / 65536.0);
    REQUIRE(tb_m(a, b) == static_cast<std::int32_t>(product));
    const auto over = static_cast<std::uint32_t>(1 + random() % ((1U << 20) - 1));
    const auto under = static_cast<std::uint32_t>(random() % over);
    REQUIRE(tb_r(under, over) == (static_cast<std::uint64_t>(under) << 16) / over);
  }
  for (std::uint32_t over = 1; over < 65536; over += 1 + over / 256)
    for (std::uint32_t under = 0; under < over; under += 1 + over / 1024)
      if (tb_r_short(under, over) != (under << 16) / over) FAIL(under << " / " << over);
}

TEST_CASE("fixed-point compensator: on dense noisy reversals its error is at most 1.02 times that of doubles") {
  for (const char* const name : kBoth)
    for (const bool falling : {false, true}) {
      const Kind kind = kind_of(name);
      SensorModel model = sensor_of(kind, falling);
      if (falling)  // 5 V less what rises
        for (ModelTaxel& taxel : model.taxels) taxel.zero -= 5.0;
      const auto fixed = std::make_shared<const FixedModel>(quantised(model, device()));
      const double noise = 1.0 / 1500.0;
      const Walk walk = [&] {
        Walker walker(kind, noise, 7, 1.0 / kRate);
        walker.go_along(reversals(kind, 30000, 0.08, 3));
        return walker.walk;
      }();
      const auto stream = compensator_of(model, model.taxels.front());
      FixedTaxel integers(fixed, 0);
      double by_doubles = 0.0, by_integers = 0.0;
      std::vector<double> apart;
      for (std::size_t i = 0; i < walk.output.size(); ++i) {
        const std::uint16_t count = count_of(*fixed, falling ? 5.0 - walk.output[i] : walk.output[i]);
        const double seen = falling ? -kPerCount * count : kPerCount * count;
        const double reference = stream->step(seen, 1.0 / kRate).pressure_psi;
        const FixedReading now = integers.step(count);
        const double pressure = fixed->pressure(now.pressure);
        REQUIRE(now.status == TB_VALID);
        by_doubles += std::abs(reference - walk.x[i]);
        by_integers += std::abs(pressure - walk.x[i]);
        apart.push_back(std::abs(pressure - reference));
      }
      INFO(name << (falling ? ", falling" : ""));
      CHECK(by_integers <= 1.02 * by_doubles);
      std::ranges::nth_element(apart, apart.begin() + static_cast<std::ptrdiff_t>(apart.size() / 2));
      CHECK(apart[apart.size() / 2] <= 0.0004 * kind.span());
    }
}

TEST_CASE("fixed compensator: a cached piece of a branch changes no reading") {
  for (const char* const name : kBoth) {
    const Kind kind = kind_of(name);
    const auto fixed = fixed_of(kind);
    const std::vector<std::uint16_t> counts = counts_along(kind, *fixed, reversals(kind, 8000, 0.4, 11), 1.0 / 800.0);
    const auto compare = [&](auto model, auto taxel, const auto& init, const auto& step) {
      tb_frames frames;
      std::vector kept(3, taxel), searched(3, taxel);
      REQUIRE(init(&model, &frames, kept.data()) == 1);
      REQUIRE(init(&model, &frames, searched.data()) == 1);
      for (std::size_t i = 0; i < counts.size(); ++i) {
        searched[0].at.here = searched[0].at.there = {};
        const auto status = step(&model, &kept[0], counts[i], i % 8 == 0);
        REQUIRE(step(&model, &searched[0], counts[i], i % 8 == 0) == status);
        INFO(name << ", sample " << i);
        REQUIRE(searched[0].at.pressure == kept[0].at.pressure);
      }
    };
    if (fixed->dynamic)
      compare(fixed->dynamic_model(), tb_dynamic_taxel{}, tb_dynamic_init,
              [](auto* m, auto* t, unsigned count, bool renews) { return tb_dynamic_step(m, 0, t, count, renews); });
    else
      compare(fixed->elam_model(), tb_elam_taxel{}, tb_elam_init,
              [](auto* m, auto* t, unsigned count, bool) { return tb_elam_step(m, 0, t, count); });
  }
}

TEST_CASE("fixed compensator: a single taxel reads as in the array, also with lost frames and a dead neighbour") {
  for (const char* const name : kBoth) {
    const Kind kind = kind_of(name);
    const auto fixed = fixed_of(kind);
    const std::vector<std::uint16_t> counts = counts_along(kind, *fixed, reversals(kind, 3000, 0.5, 4), 1.0 / 1500.0);
    FixedFrames array(fixed);
    FixedTaxel first(fixed, 0), last(fixed, 2);
    std::vector<std::uint16_t> pressures(kThree), status(kThree);
    for (std::size_t i = 0; i < counts.size(); ++i) {
      const bool lost = i % 97 == 50 || (i > 2000 && i < 2014);
      if (lost)
        array.lost_frame(pressures, status);
      else
        array.frame(std::vector(kThree, counts[i]), pressures, status);
      const FixedReading one = lost ? first.lost() : first.step(counts[i]),
                         two = lost ? last.lost() : last.step(counts[i]);
      INFO(name << ", frame " << i);
      REQUIRE(one.pressure == pressures[0]);
      REQUIRE(one.status == status[0]);
      REQUIRE(two.pressure == pressures[2]);
      REQUIRE(two.status == status[2]);
      REQUIRE(pressures[1] == 0);
      REQUIRE(status[1] == TB_DEAD);
    }
  }
}

TEST_CASE("fixed compensator: a history is unknown until zero, top or tare, and after ten lost frames") {
  for (const char* const name : kBoth) {
    const Kind kind = kind_of(name);
    const auto fixed = fixed_of(kind);
    const auto count_at = [&](double x) { return counts_along(kind, *fixed, straight(0.0, x, 400), 0.0).back(); };
    const std::uint16_t zero = count_at(0.0), middle = count_at(30.0), top = count_at(60.0);
    for (const std::uint16_t known : {zero, top}) {
      FixedTaxel taxel(fixed, 0);
      INFO(name);
      CHECK(taxel.step(middle).status == (TB_VALID | TB_UNKNOWN));
      CHECK(taxel.step(known).status == TB_VALID);
      CHECK(taxel.step(middle).status == TB_VALID);
      for (int i = 0; i < 10; ++i) CHECK(taxel.lost().status == TB_LOST);
      CHECK(taxel.lost().status == (TB_LOST | TB_UNKNOWN));
      CHECK(taxel.step(middle).status == (TB_VALID | TB_UNKNOWN));
    }
    FixedFrames array(fixed);
    std::vector<std::uint16_t> pressures(kThree), status(kThree);
    const auto drifted = static_cast<std::uint16_t>(zero + (top - zero) / 10);
    CHECK(array.tare(std::vector(kThree, top)) == 2);
    CHECK(array.tare(std::vector(kThree, drifted)) == 0);
    array.frame(std::vector(kThree, drifted), pressures, status);
    CHECK(status[0] == TB_VALID);
    CHECK(pressures[0] == 0);
  }
}

TEST_CASE("fixed compensator: an impossible count is held, a persistent one reads as the end of the loop") {
  for (const char* const name : kBoth) {
    const Kind kind = kind_of(name);
    const auto fixed = fixed_of(kind);
    const std::vector<std::uint16_t> way = counts_along(kind, *fixed, straight(0.0, 30.0, 400), 0.0);
    FixedTaxel taxel(fixed, 0), without(fixed, 0);
    FixedReading before;
    for (const std::uint16_t count : way) {
      before = taxel.step(count);
      (void)without.step(count);
    }
    INFO(name);
    for (int i = 0; i < 3; ++i) {
      const FixedReading spike = taxel.step(65535);
      CHECK(spike.status == TB_OUT_OF_RANGE);
      CHECK(spike.pressure == before.pressure);
    }
    CHECK(std::abs(taxel.step(way.back()).pressure - without.step(way.back()).pressure) <= 2);
    for (int i = 0; i < 3; ++i) (void)taxel.step(65535);
    CHECK(taxel.step(65535).pressure >= fixed->highest - fixed->highest / 100);
  }
}

TEST_CASE("fixed compensator: changing any word of the table changes the hash") {
  for (const char* const name : kBoth) {
    const FixedModel whole = *fixed_of(kind_of(name));
    const auto hash = [](const FixedModel& model) {
      const tb_dynamic_model d = model.dynamic_model();
      const tb_elam_model e = model.elam_model();
      return model.dynamic ? tb_dynamic_hash(&d) : tb_elam_hash(&e);
    };
    CHECK(hash(whole) == whole.hash());
    for (std::size_t i = 0; i < whole.table.size(); i += 7) {
      FixedModel changed = whole;
      changed.table[i] ^= 1;
      REQUIRE(hash(changed) != whole.hash());
    }
  }
}

TEST_CASE("as Verilog: the loaded words match the hash, a model too large for the module is refused") {
  const Kind kind = kind_of("elam");
  const SensorModel model = sensor_of(kind);
  const FixedModel fixed = quantised(model, device());
  const std::vector<ExportedFile> files = verilog_files(model, fixed, "test");
  std::istringstream memory(std::ranges::find(files, "tb_model.mem", &ExportedFile::name)->text);
  std::uint32_t hash = TB_HASH_START;
  for (unsigned word = 0; memory >> std::hex >> word;) {
    const auto own = static_cast<std::uint16_t>(word);
    hash = tb_hash(hash, &own, 1);
  }
  CHECK(hash == fixed.hash());

  const SensorModel other = sensor_of(kind_of("linearised in time"));
  FixedModel knots = fixed, wide = fixed;
  knots.x.resize(33);
  wide.elam_words[2].front.zero[1] = 0x7FFF;
  const auto refusal = [](const SensorModel& of, const FixedModel& what) {
    try {
      (void)verilog_files(of, what, "test");
    } catch (const AnalysisError& error) {
      CHECK(error.id() == "TB-MODEL-FIXED");
      return std::string(error.what());
    }
    return std::string();
  };
  CHECK(refusal(other, quantised(other, device())).find("ELAM") != std::string::npos);
  CHECK(refusal(model, knots).find("33") != std::string::npos);
  CHECK(refusal(model, wide).find("taxel 2") != std::string::npos);
}

TEST_CASE("fixed export: a value that does not fit the device's words is refused, with the taxel") {
  struct Case {
    const char* kind;
    std::function<void(SensorModel&, FixedOptions&)> change;
    const char* where;
  };
  const Case cases[] = {
      {"linearised in time", [](SensorModel& m, FixedOptions&) { m.taxels[2].creep_scale = 30.0; }, "taxel 2"},
      {"linearised in time", [](SensorModel& m, FixedOptions&) { m.taxels[0].noise = 1e-5; }, "taxel 0"},
      {"linearised in time", [](SensorModel& m, FixedOptions&) { m.taxels[2].lag_share = 0.9; }, "taxel 2"},
      {"linearised in time", [](SensorModel&, FixedOptions& o) { o.frame_rate_hz = 0.0; }, "frames/s"},
      {"linearised in time", [](SensorModel&, FixedOptions& o) { o.per_count = 0.0; }, "count"},
      {"linearised", [](SensorModel&, FixedOptions&) {}, "linearised"},
      {"elam", [](SensorModel& m, FixedOptions&) { m.taxels[0].noise = 0.0; }, "taxel 0"},
      {"elam", [](SensorModel& m, FixedOptions&) { m.taxels[2].gain = -1.0; }, "taxel 2"},
      {"elam with memory", [](SensorModel&, FixedOptions&) {}, "taxel 0"},
      {"gpi", [](SensorModel&, FixedOptions&) {}, "gpi"},
  };
  for (const Case& c : cases) {
    const Kind kind = kind_of(c.kind);
    SensorModel model = sensor_of(kind);
    FixedOptions options = device();
    c.change(model, options);
    INFO(c.kind << ", " << c.where);
    try {
      (void)quantised(model, options);
      FAIL_CHECK("taken");
    } catch (const AnalysisError& error) {
      CHECK(error.id() == "TB-MODEL-FIXED");
      CHECK(std::string(error.what()).find(c.where) != std::string::npos);
    }
  }
  SensorModel model = sensor_of(kind_of("linearised in time"));
  model.taxels[0].noise = 1e-5;
  FixedOptions options = device();
  options.noise = 5e-4;
  CHECK_NOTHROW(quantised(model, options));
}
