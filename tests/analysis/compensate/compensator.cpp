// Properties of every compensator, for all models.
#include "analysis/compensate/compensator.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <limits>
#include <stdexcept>

#include "tests/analysis/compensate/kinds.h"

using namespace synthetic;

namespace {

constexpr double kNoise = 1.0 / 2000.0, kNaN = std::numeric_limits<double>::quiet_NaN();

struct Errors {
  double sum = 0.0, squares = 0.0, most = 0.0, count = 0.0, within = 0.0, flagged = 0.0;
  void add(const Compensated& now, double x, double hidden) {
    const double off = std::abs(now.pressure_psi - x);
    sum += now.pressure_psi - x;
    squares += off * off;
    most = std::max(most, off);
    count += 1.0;
    within += off <= hidden ? 1.0 : 0.0;
    flagged += now.out_of_range || now.held || now.unknown ? 1.0 : 0.0;
  }
  [[nodiscard]] double mean() const { return std::abs(sum / count); }
  [[nodiscard]] double rms() const { return std::sqrt(squares / count); }
};

Errors follow(Compensator& stream, const Walk& walk) {
  Errors errors;
  for (std::size_t i = 0; i < walk.x.size(); ++i)
    errors.add(stream.step(walk.output[i], walk.seconds), walk.x[i], walk.hidden[i]);
  return errors;
}

double x_of(const Kind& kind, double level) { return kind.model->x_low() + kind.span() * level / 60.0; }

bool same(const Compensated& a, const Compensated& b) {
  return a.pressure_psi == b.pressure_psi && a.uncertainty_psi == b.uncertainty_psi && a.unknown == b.unknown &&
         a.held == b.held && a.flat == b.flat && a.out_of_range == b.out_of_range;
}

}  // namespace

TEST_CASE("compensators: recover the input along random reversals, as far as noise allows") {
  for (const Kind& kind : kinds())
    for (const double step : {2.0, 0.3})
      for (const unsigned seed : {1U, 2U}) {
        const Errors errors =
            follow(*kind.stream(kNoise), walk_of(kind, reversals(kind, 800, step, seed), kNoise, seed + 50));
        INFO(kind.name << ", steps of " << step << ", seed " << seed << ": within " << errors.within / errors.count
                       << ", rms " << errors.rms() << ", most " << errors.most);
        CHECK(errors.within >= 0.99 * errors.count);
        CHECK(errors.flagged <= 0.001 * errors.count);
      }
}

TEST_CASE("compensators without lag and creep: small steps and a jump to a turning point give the same pressure") {
  // Pieces of curves are kept from sample to sample, and hold to the branch's end at most.
  for (const Kind& kind : kinds()) {
    if (kind.in_time) continue;
    constexpr double kLittle = 1e-9;
    const auto small = kind.stream(kLittle), jumped = kind.stream(kLittle);
    for (const std::vector<double>& turns : std::vector<std::vector<double>>{
             {48, 12, 40, 20, 44, 5, 50, 0, 60, 18, 30, 24, 60, 0}, {20, 10, 34, 15, 49, 2, 5, 1, 60}}) {
      std::vector<double> way{0.0};
      small->start(Start::kAtRest);
      jumped->start(Start::kAtRest);
      Walker walker(kind, kLittle, 1);
      const auto check = [&](double now) {
        REQUIRE(now == Approx(walker.walk.x.back()).margin(walker.walk.hidden.back() + 1e-5 * kind.span()));
      };
      for (const double turn : turns) {
        for (int i = 1; i <= 37; ++i) {
          walker.go(way.back() + (turn - way.back()) * i / 37.0);
          INFO(kind.name << ", on the way to " << turn);
          check(small->step(walker.walk.output.back(), 0.0).pressure_psi);
        }
        way.push_back(turn);
        INFO(kind.name << ", at " << turn);
        check(jumped->step(walker.walk.output.back(), 0.0).pressure_psi);
      }
    }
  }
}

TEST_CASE("compensators: noise within the dead band leaves no memory, oscillation on a hold no error beyond its size") {
  for (const Kind& kind : kinds())
    for (const double level : {12.0, 35.0, 45.0}) {
      INFO(kind.name << ", held at " << level);
      Walker walker(kind, 0.0, 1, 0.02);
      for (const double to : {0.0, 60.0, 0.0, level}) walker.go(to);
      const auto quiet = kind.stream(kNoise), wiggled = kind.stream(kNoise);
      for (const double output : walker.walk.output) {
        quiet->step(output, 0.02);
        wiggled->step(output, 0.02);
      }
      const double held = walker.walk.output.back();
      for (int i = 0; i < 400; ++i) {
        quiet->step(held, 0.02);
        wiggled->step(held + 2.0 * kNoise * kOutputGain * kind.full() * std::sin(0.7 * i), 0.02);
      }
      walker.go(55.0);
      walker.go(3.0);
      for (std::size_t i = walker.walk.x.size() - 2; i < walker.walk.x.size(); ++i) {
        const double a = quiet->step(walker.walk.output[i], 0.02).pressure_psi;
        CHECK(wiggled->step(walker.walk.output[i], 0.02).pressure_psi == Approx(a).margin(0.01 * kind.span()));
      }
      // Half a psi to and fro once a second for two minutes, at 50 samples per second.
      Walker trembling(kind, kNoise, 2, 0.02, 5.5);
      for (const double to : {0.0, 60.0, 0.0, level}) trembling.go(to);
      const auto stream = kind.stream(kNoise);
      follow(*stream, trembling.walk);
      Errors errors, last;
      for (int i = 0; i < 6000; ++i) {
        trembling.go(level + 0.5 * std::sin(6.2831853 * 0.02 * i));
        const Walk& walk = trembling.walk;
        const Compensated now = stream->step(walk.output.back(), 0.02);
        errors.add(now, walk.x.back(), 0.0);
        if (i >= 5500) last.add(now, walk.x.back(), 0.0);
      }
      // Outputs within the dead band are as good as the same.
      const double most = 0.5 + *std::max_element(trembling.walk.hidden.begin() + 4, trembling.walk.hidden.end());
      INFO("mean error " << errors.mean() << ", at last " << last.mean() << " psi of " << most);
      CHECK(errors.mean() < most);
      CHECK(last.mean() < most);
    }
}

TEST_CASE("compensators: impossible samples are held or flagged, and later readings are as without them") {
  for (const Kind& kind : kinds()) {
    const double full = kOutputGain * kind.full(), margin = 0.1 * full;
    Random draw(7);
    double within = 0.0, others = 0.0;
    const Walk walk = walk_of(kind, reversals(kind, 3000, 0.4, 11), kNoise, 12);
    const auto clean = kind.stream(kNoise), spiked = kind.stream(kNoise);
    const double low = kind.measured(kind.model->state()->output_at(kind.model->x_low()));
    int left = 0, next = 20, spikes = 0;
    for (std::size_t i = 0; i < walk.x.size(); ++i) {
      const Compensated a = clean->step(walk.output[i], walk.seconds);
      if (static_cast<int>(i) == next) {
        left = 1 + static_cast<int>(draw(0.0, 2.999));
        next += 10 + static_cast<int>(draw(0.0, 38.0));
        ++spikes;
      }
      if (left-- > 0) {
        const double kind_of = draw(0.0, 5.0), by = margin + draw(0.0, 3.0) * full;
        const double output = kind_of < 1.0   ? kNaN
                              : kind_of < 1.5 ? std::copysign(HUGE_VAL, kind_of - 1.25)
                              : kind_of < 3.0 ? low - by
                                              : low + full + by;
        const Compensated b = spiked->step(output, walk.seconds);
        INFO(kind.name << ", sample " << i << ", " << output << " after " << walk.output[i - 1]);
        CHECK((b.held || b.out_of_range));
        CHECK(b.out_of_range != std::isnan(output));
        if (b.held) CHECK(b.pressure_psi == Approx(walk.x[i - 1]).margin(0.2 * kind.span()));
        continue;
      }
      const Compensated b = spiked->step(walk.output[i], walk.seconds);
      others += 1.0;
      within += std::abs(a.pressure_psi - b.pressure_psi) <= walk.hidden[i] ? 1.0 : 0.0;
      CHECK((b.held == a.held && b.out_of_range == a.out_of_range));
    }
    INFO(kind.name << ": " << within << " of " << others << " as without");
    CHECK(spikes >= 90);
    CHECK(within >= 0.99 * others);
  }
}

TEST_CASE("compensators: persistent output out of range reads as the loop's end, immediately if it came from nearby") {
  for (const Kind& kind : kinds()) {
    INFO(kind.name);
    const double full = kOutputGain * kind.full();
    const auto stream = kind.stream(kNoise);
    Walker walker(kind, 0.0, 1);
    walker.go_along(levels_of({0, 60}));
    follow(*stream, walker.walk);
    const double top = walker.walk.output.back() + (kind.in_time ? 0.1 * full : 0.0);
    double before = 0.0;
    for (const double share : {0.0, 0.01, 0.03, 0.2, 0.4}) {
      const Compensated now = stream->step(top + share * full, walker.walk.seconds);
      CHECK_FALSE(now.held);
      CHECK(now.out_of_range == (share > 0.05 || kind.in_time));
      if (!now.out_of_range) CHECK(now.uncertainty_psi > before);
      before = now.uncertainty_psi;
      CHECK(now.pressure_psi == Approx(kind.model->x_high()).margin(0.02 * kind.span()));
    }
    stream->start(Start::kAtRest);
    Walker half(kind, 0.0, 1);
    half.go_along(levels_of({0, 30}));
    follow(*stream, half.walk);
    for (int i = 0; i < 6; ++i) {
      const Compensated now = stream->step(top + 0.4 * full, half.walk.seconds);
      CHECK(now.out_of_range);
      CHECK(now.held == (i < 3));
      CHECK(now.pressure_psi == Approx(x_of(kind, i < 3 ? 30.0 : 60.0)).margin(0.03 * kind.span()));
    }
  }
}

TEST_CASE("compensators: after an unknown start twice the uncertainty covers the input until the state is known") {
  for (const Kind& kind : kinds()) {
    double unknown = 0.0, within = 0.0;
    for (const unsigned seed : {1U, 2U, 3U, 4U}) {
      INFO(kind.name << ", seed " << seed);
      const Walk walk = walk_of(kind, reversals(kind, 700, 1.5, seed), kNoise, seed + 9);
      const auto knows = kind.stream(kNoise), late = kind.stream(kNoise);
      late->start(Start::kUnknown);
      bool now_unknown = true;
      for (std::size_t i = 0; i < walk.x.size(); ++i) {
        const Compensated known = knows->step(walk.output[i], walk.seconds);
        if (i < 150 + 10 * seed) continue;
        const Compensated now = late->step(walk.output[i], walk.seconds);
        now_unknown = now.unknown;
        if (now.unknown) {
          unknown += 1.0;
          within += std::abs(now.pressure_psi - walk.x[i]) <= 2.0 * now.uncertainty_psi + walk.hidden[i] ? 1.0 : 0.0;
        } else if (i > 600) {  // what crept before the start is forgotten more slowly
          CHECK(std::abs(now.pressure_psi - known.pressure_psi) <=
                walk.hidden[i] + (kind.in_time ? 0.06 : 0.01) * kind.span());
        }
      }
      CHECK_FALSE(now_unknown);
    }
    INFO(kind.name << ": " << within << " of " << unknown << " unknown samples within");
    CHECK((unknown > 0.0 || kind.name == "monotone"));
    CHECK(within >= 0.9 * unknown);
  }
}

TEST_CASE(
    "compensators: tare and lost samples keep the reading, falling output is mirrored, invalid times are refused") {
  for (const Kind& kind : kinds()) {
    INFO(kind.name);
    const Walk walk = walk_of(kind, reversals(kind, 200, 2.0, 3), 0.0, 1);
    const double full = kOutputGain * kind.full(), low = walk.output.front();
    const auto plain = kind.stream(kNoise);
    std::vector<Compensated> expected;
    for (const double output : walk.output) expected.push_back(plain->step(output, walk.seconds));

    // At rest again it reads the same; a tare moves all by what the zero moved, at most a fifth of the span.
    const auto moved = kind.stream(kNoise);
    moved->step(low + 0.5 * full, 1.0);
    CHECK(moved->tare(low + 0.15 * full));
    for (std::size_t i = 0; i < expected.size(); ++i)
      REQUIRE(moved->step(walk.output[i] + 0.15 * full, walk.seconds).pressure_psi ==
              Approx(expected[i].pressure_psi).margin(1e-5 * kind.span()));
    CHECK_FALSE(moved->tare(low + 0.40 * full));
    CHECK((moved->step(low + 0.5 * full, 1.0).unknown || kind.name == "monotone"));
    CHECK(plain->at_rest(low));
    CHECK(plain->at_rest(low + 0.009 * full));
    CHECK_FALSE(plain->at_rest(low + 0.02 * full));

    // The mirrored output is the same stream.
    CompensatorSetup mirrored = kind.setup(kNoise);
    mirrored.zero = -mirrored.zero;
    mirrored.gain = -mirrored.gain;
    const auto falling = make_compensator(*kind.model, mirrored);
    for (std::size_t i = 0; i < expected.size(); ++i)
      REQUIRE(same(falling->step(-walk.output[i], walk.seconds), expected[i]));

    // A wrong time changes nothing.
    const auto stream = kind.stream(kNoise);
    for (std::size_t i = 0; i < expected.size(); ++i) {
      for (const double wrong : {-1.0, kNaN, HUGE_VAL}) {
        CHECK_THROWS_AS(stream->step(low + 0.7 * full, wrong), std::invalid_argument);
        CHECK_THROWS_AS(stream->lost(wrong), std::invalid_argument);
        CHECK_THROWS_AS(stream->work(wrong), std::invalid_argument);
        CHECK_THROWS_AS(stream->rest(wrong), std::invalid_argument);
      }
      REQUIRE(same(stream->step(walk.output[i], walk.seconds), expected[i]));
    }

    // A lost sample is held; the next sample is used without averaging.
    stream->rest(1000.0);
    Walker held(kind, 0.0, 1);
    for (int i = 0; i < 100; ++i) held.go(30.0);
    follow(*stream, held.walk);
    const double before = stream->step(held.walk.output.back(), 0.0).pressure_psi;
    const Compensated lost = stream->lost(0.0);
    CHECK((lost.held && !lost.out_of_range && lost.pressure_psi == before));
    const double near = held.walk.output.back() + 4.0 * kNoise * full;  // nearer than a jump
    const auto averaging = kind.stream(kNoise);
    follow(*averaging, held.walk);
    averaging->step(held.walk.output.back(), 0.0);
    CHECK(stream->step(near, 0.0).pressure_psi > averaging->step(near, 0.0).pressure_psi);
  }
}

TEST_CASE("compensators: samples on a hold are averaged, and a step is followed at once") {
  for (const Kind& kind : kinds()) {
    const double noise = 0.002;
    const auto averaging = kind.stream(noise);
    CompensatorSetup alone = kind.setup(noise);
    alone.options.longest_mean = 1;
    const auto single = make_compensator(*kind.model, alone);
    Walker walker(kind, noise, 5);
    walker.go_along({0, 30});
    for (int i = 0; i < 300; ++i) walker.go(30.0);
    Errors of_means, of_singles;
    for (std::size_t i = 0; i < walker.walk.x.size(); ++i) {
      const Compensated mean = averaging->step(walker.walk.output[i], 0.4);
      const Compensated one = single->step(walker.walk.output[i], 0.4);
      if (i < 60) continue;  // the step counts as a move until then
      of_means.add(mean, walker.walk.x[i], 0.0);
      of_singles.add(one, walker.walk.x[i], 0.0);
    }
    INFO(kind.name << ": " << of_means.rms() << " of means, " << of_singles.rms() << " of single samples");
    CHECK(of_means.rms() < 0.7 * of_singles.rms());
    for (const double to : {36.0, 20.0}) {
      walker.go(to);
      CHECK(std::abs(averaging->step(walker.walk.output.back(), 0.4).pressure_psi - walker.walk.x.back()) <=
            walker.walk.hidden.back());
    }
  }
}

TEST_CASE("compensators: lag and creep are removed by the elapsed time, including times of work and rest") {
  for (const Kind& kind : kinds()) {
    if (!kind.in_time) continue;
    const Walk walk = walk_of(kind, reversals(kind, 600, 2.0, 4), kNoise / 10.0, 1);
    CompensatorSetup setup = kind.setup(kNoise / 10.0);
    const auto own = make_compensator(*kind.model, setup), shared = make_compensator(*kind.model, setup);
    setup.time = nullptr;
    const auto deaf = make_compensator(*kind.model, setup);
    Errors told, untold;
    for (std::size_t i = 0; i < walk.x.size(); ++i) {
      const Compensated now = own->step(walk.output[i], walk.seconds);
      REQUIRE(same(now, shared->step(walk.output[i], walk.seconds)));
      told.add(now, walk.x[i], walk.hidden[i]);
      untold.add(deaf->step(walk.output[i], walk.seconds), walk.x[i], walk.hidden[i]);
    }
    INFO(kind.name << ": rms " << told.rms() << " psi, without time " << untold.rms());
    CHECK(told.within >= 0.95 * told.count);
    CHECK(untold.rms() > 2.5 * told.rms());

    // A film that was worked has already crept: the same output means less input. Rest lets it creep back.
    const auto after = [&](const std::function<void(Compensator&)>& act) {
      own->start(Start::kAtRest);
      act(*own);
      return own->step(kind.measured(0.5 * kind.full()), 0.4).pressure_psi;
    };
    const double rested = after([](Compensator&) {}), worked = after([](Compensator& c) { c.work(600.0); });
    CHECK(worked < rested - 0.2);
    CHECK(after([](Compensator& c) {
            c.work(600.0);
            c.rest(1e5);
          }) == Approx(rested));
    setup = kind.setup(kNoise / 10.0);
    setup.worked_s = 600.0;
    CHECK(make_compensator(*kind.model, setup)->step(kind.measured(0.5 * kind.full()), 0.4).pressure_psi ==
          Approx(worked));
  }
}

TEST_CASE("compensators: twice the real creep correction causes no reversal on a hold and a bounded error") {
  for (const Kind& kind : kinds()) {
    if (!kind.in_time) continue;
    std::vector<double> way = levels_of({0, 40});
    way.resize(way.size() + 500, way.back());
    const Walk walk = walk_of(kind, way, kNoise / 10.0, 2);
    CompensatorSetup setup = kind.setup(kNoise / 10.0);
    for (double& share : setup.time->dynamics.creep_share) share *= 2.0;
    const auto stream = make_compensator(*kind.model, setup);
    for (std::size_t i = 0; i < walk.x.size(); ++i) {
      const Compensated now = stream->step(walk.output[i], walk.seconds);
      INFO(kind.name << ", sample " << i << ": " << now.pressure_psi << " psi");
      REQUIRE(stream->ascending());
      REQUIRE(std::abs(now.pressure_psi - walk.x[i]) < 0.12 * kind.span());
    }
  }
}

TEST_CASE("compensators: a gain error of 1 % is found at the top, which reduces the error and widens the uncertainty") {
  for (const Kind& kind : kinds())
    for (const double gain : {0.99, 1.01}) {
      if (kind.in_time || kind.name == "elam") continue;
      Walk walk = walk_of(kind, levels_of({0, 60, 0, 60, 0, 60, 10, 50, 20, 60, 0, 40, 0}), kNoise, 3);
      const double low = kind.measured(kind.model->state()->output_at(kind.model->x_low()));
      for (double& output : walk.output) output = low + gain * (output - low);
      CompensatorSetup setup = kind.setup(kNoise);
      setup.residual = {0.1, 0.1};
      const auto blind = make_compensator(*kind.model, setup);
      setup.options.top_share = 0.02;
      const auto finds = make_compensator(*kind.model, setup);
      setup.options.top_doubt = 0.0;
      const auto sure = make_compensator(*kind.model, setup);
      Errors without, with;
      double doubt = 0.0, none = 0.0;
      for (std::size_t i = 0; i < walk.x.size(); ++i) {
        const Compensated a = blind->step(walk.output[i], 0.4), b = finds->step(walk.output[i], 0.4);
        const double known = sure->step(walk.output[i], 0.4).uncertainty_psi;
        if (i < 70) continue;
        without.add(a, walk.x[i], 0.0);
        with.add(b, walk.x[i], 0.0);
        none += known;
        doubt += b.uncertainty_psi;
      }
      INFO(kind.name << ", gain " << gain << ": rms " << with.rms() << ", without " << without.rms());
      CHECK(with.rms() < 0.6 * without.rms());
      CHECK(doubt > none);
    }
}

TEST_CASE("compensators: uncertainty is larger until creep has settled, and grows with the amount of creep") {
  for (const Kind& kind : kinds()) {
    if (kind.name != "linearised in time") continue;  // as fitted
    INFO(kind.name);
    const auto widths = [&](double creep) {  // a second, and an hour after a load
      CompensatorSetup setup = kind.setup(0.0);
      for (double& share : setup.time->dynamics.creep_share) share *= creep;
      const auto stream = make_compensator(*kind.model, setup);
      const double output = kind.measured(0.5 * kind.full());
      const double at_once = stream->step(output, 1.0).uncertainty_psi;
      return std::pair{at_once, stream->step(output, 3600.0).uncertainty_psi};
    };
    const auto [at_once, settled] = widths(4.0);
    CHECK(at_once > 0.002 * kind.span());
    CHECK(settled < 0.1 * at_once);
    CHECK(at_once > widths(1.0).first);
  }
}

TEST_CASE("make_compensator: each invalid number of the setup is refused") {
  using Spoil = std::function<void(CompensatorSetup&)>;
  const std::vector<Kind> all = kinds();
  const auto refused = [](const Kind& kind, const Spoil& spoil) {
    CompensatorSetup setup = kind.setup(kNoise);
    setup.residual = {0.1, 0.2};
    CHECK_NOTHROW(make_compensator(*kind.model, setup));
    spoil(setup);
    CHECK_THROWS_AS(make_compensator(*kind.model, setup), std::invalid_argument);
  };
  std::vector<Spoil> spoils, in_time;
  const auto out_of = [](std::vector<Spoil>& list, auto place, const std::vector<double>& values) {
    for (const double value : values) list.push_back([=](CompensatorSetup& s) { place(s) = value; });
  };
  using S = CompensatorSetup;
  out_of(spoils, [](S& s) -> double& { return s.noise; }, {-1e-9, kNaN, 2e9});
  out_of(spoils, [](S& s) -> double& { return s.gain; }, {0.0, kNaN, 2e9, 1e-10, HUGE_VAL});
  out_of(spoils, [](S& s) -> double& { return s.zero; }, {kNaN, 2e9, -2e9});
  out_of(spoils, [](S& s) -> double& { return s.residual[1]; }, {-0.1, kNaN, 2e9});
  out_of(spoils, [](S& s) -> double& { return s.worked_s; }, {-1.0, kNaN, 2e9});
  out_of(spoils, [](S& s) -> double& { return s.highest; }, {kNaN, HUGE_VAL});
  for (auto option :
       {&CompensatorOptions::moving, &CompensatorOptions::jump_in_noises, &CompensatorOptions::lead_in_noises,
        &CompensatorOptions::band_in_noises, &CompensatorOptions::rest_in_noises, &CompensatorOptions::hold_in_noises,
        &CompensatorOptions::flat_in_noises, &CompensatorOptions::flat_share, &CompensatorOptions::known_share,
        &CompensatorOptions::tare_share, &CompensatorOptions::possible_share, &CompensatorOptions::top_forget,
        &CompensatorOptions::top_doubt, &CompensatorOptions::creep_doubt, &CompensatorOptions::swift_doubt})
    out_of(spoils, [=](S& s) -> double& { return s.options.*option; }, {-0.1, kNaN, 2e9});
  out_of(spoils, [](S& s) -> double& { return s.options.top_share; }, {-0.1, kNaN, 1.0});
  spoils.push_back([](S& s) { s.options.longest_mean = 0; });
  spoils.push_back([](S& s) { s.options.longest_spike = -1; });
  spoils.push_back([](S& s) { s.residual.pop_back(); });
  spoils.push_back([](S& s) { s.noise = 1e6; });  // the full output is below a thousandth of it
  out_of(in_time, [](S& s) -> double& { return s.time->dynamics.creep_s[1]; }, {0.0, -1.0, kNaN, HUGE_VAL});
  out_of(in_time, [](S& s) -> double& { return s.time->dynamics.creep_share[2]; }, {-0.01, kNaN, 0.91});
  out_of(in_time, [](S& s) -> double& { return s.time->dynamics.creep_half; }, {0.0, kNaN, 2e9});
  out_of(in_time, [](S& s) -> double& { return s.time->dynamics.lag_s; }, {0.0, kNaN, HUGE_VAL});
  out_of(in_time, [](S& s) -> double& { return s.creep_scale; }, {-0.1, kNaN, 10.1});
  out_of(in_time, [](S& s) -> double& { return s.lag_share; }, {-0.1, kNaN, 0.91});
  for (const Kind& kind : all) {
    INFO(kind.name);
    for (std::size_t i = 0; i < spoils.size(); ++i) {
      INFO("place " << i);
      refused(kind, spoils[i]);
    }
    for (const Spoil& spoil : kind.in_time ? in_time : std::vector<Spoil>()) refused(kind, spoil);
  }
  const std::vector<double> x{0, 60}, far{2e9, 2e9 + 60}, wide{0, 2e9}, y{0, 3};
  CHECK_THROWS_AS(make_compensator(MonotoneModel(PatternCurve(far, y, 0.0, 3.0)), {}), std::invalid_argument);
  CHECK_THROWS_AS(make_compensator(MonotoneModel(PatternCurve(wide, y, 0.0, 3.0)), {}), std::invalid_argument);
  CHECK_THROWS_AS(make_compensator(PreisachModel(0.0, 60.0, 0.0, std::vector<double>(5151, 1.0)), {}),
                  std::invalid_argument);                                                              // 101 intervals
  CHECK_THROWS_AS(make_compensator(PreisachModel(0.0, 60.0, 0.0, {0.0}), {}), std::invalid_argument);  // no output
}
