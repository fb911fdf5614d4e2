#include "analysis/export/quantise.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "analysis/compensate/compensator.h"
#include "analysis/compensate/curves.h"
#include "analysis/error.h"
#include "analysis/models/elam.h"
#include "analysis/models/linearised.h"
#include "analysis/models/preisach.h"

namespace tactbench::analysis {
namespace {

constexpr double kWord = 65536.0, kPerNoise = 256.0;
constexpr double kMostNoises = 32000.0;       // from zero to the top
constexpr double kMostFixedCreep = 0.85;      // of the output
constexpr double kPreisachTop = 0.8 * kWord;  // u of the top: 1.25 times it are 16 bits
constexpr unsigned kMostIntervals = 31;       // x: 11 bits of fraction, 16 in all
constexpr unsigned kMostShift = 14;
constexpr double kRenewal = 0.1;  // s, about

const char* const kOfTheModel = "the model";

[[noreturn]] void refuse(const std::string& where, const std::string& what, const std::string& remedy) {
  throw AnalysisError("TB-MODEL-FIXED", where + ": " + what, remedy);
}

std::string taxel_name(const ModelTaxel& taxel) { return fmt::format("taxel {}", taxel.taxel); }

// `value` rounded, when that is a word of 16 bits.
std::uint16_t word(const std::string& where, const char* name, double value) {
  if (!(value > -0.5 && value < kWord - 0.5))
    refuse(where, fmt::format("its {} would be {:.6g}, and a word is 0 to 65535", name, value),
           "fit it again, or leave this taxel out of the array");
  return static_cast<std::uint16_t>(std::lround(value));
}

std::uint16_t share(const std::string& where, const char* name, double value) {
  if (!(value >= 0.0 && value <= 1.0))
    refuse(where, fmt::format("its {} is {:.6g}, not within 0 and 1", name, value), "fit it again");
  return word(where, name, std::min(kWord * value, kWord - 1.0));
}

void put_long(double value, std::uint16_t (&words)[2]) {
  const auto whole = static_cast<std::uint32_t>(static_cast<std::int32_t>(std::lround(value)));
  words[0] = static_cast<std::uint16_t>(whole & 0xFFFFU);
  words[1] = static_cast<std::uint16_t>(whole >> 16);
}

// A taxel in numbers of the rule.
struct Front {
  const ModelTaxel* taxel = nullptr;
  double zero = 0.0, per_unit = 0.0;  // count of the lowest input; noises / 256 a count
  double top = 0.0, limit = 0.0;      // noises / 256
  double output = 0.0;                // of the model, of a noise / 256
  double least_factor = 1.0;          // of creep
};

Front front_of(const SensorModel& model, const ModelTaxel& taxel, double low, double top, const FixedOptions& o) {
  const std::string where = taxel_name(taxel);
  if (!(taxel.gain > 0.0)) refuse(where, fmt::format("its gain is {:.6g}", taxel.gain), "fit it again");
  const double noise =
      std::max(o.noise, taxel.noise * std::sqrt(static_cast<double>(model.scans) / o.scans)) / taxel.gain;
  if (!(noise > 0.0))
    refuse(where, "the model does not know its noise", "state the standard deviation of a count's output: --noise");
  Front f;
  f.taxel = &taxel;
  f.output = noise / kPerNoise;
  f.top = top / f.output;
  if (!(f.top <= kMostNoises * kPerNoise))
    refuse(where,
           fmt::format("its top is {:.0f} noises from its zero, and {:.0f} are the most", top / noise, kMostNoises),
           fmt::format("state a larger noise: --noise {:.2g}", top * taxel.gain / kMostNoises));
  const CompensatorOptions rule;
  f.limit = f.top + std::max(rule.possible_share * f.top, kPerNoise * rule.band_in_noises);
  const double zero = (taxel.zero + taxel.gain * low) / o.per_count;
  f.zero = model.falling ? 65535.0 + zero : zero;
  f.per_unit = o.per_count / taxel.gain / f.output;
  return f;
}

// The least shift with which `largest` / 2^shift is a word.
unsigned shift_of(const char* name, double largest) {
  unsigned shift = 0;
  while (shift < kMostShift && largest >= kWord - 1.0) {
    largest /= 2.0;
    ++shift;
  }
  if (!(largest < kWord - 1.0))
    refuse(kOfTheModel,
           fmt::format("its {} would be {:.6g} with {} bits of shift, and a word is 0 to 65535", name, largest, shift),
           "state a larger noise: --noise");
  return shift;
}

// `place`: what a noise / 256 is of 2^20.
tb_front words_of(const Front& f, unsigned shift, double place, unsigned place_shift) {
  const std::string where = taxel_name(*f.taxel);
  tb_front w = {};
  w.gain = word(where, "gain", std::ldexp(kWord * f.per_unit, -static_cast<int>(shift)));
  if (w.gain == 0) refuse(where, "its gain would be less than a word", "leave this taxel out of the array");
  const double zero = std::ldexp(f.zero, static_cast<int>(shift));
  if (!(std::abs(zero) < std::ldexp(1.0, 30)))
    refuse(where, fmt::format("its zero would be {:.6g} counts", f.zero), "state what a count is: --per-count");
  put_long(zero, w.zero);
  put_long(f.top, w.top);
  put_long(f.limit, w.limit);
  w.place = word(where, "place", std::ldexp(kWord * place, -static_cast<int>(place_shift)));
  w.up = word(where, "range", std::min(f.limit / f.per_unit, kWord - 1.0));
  w.down = word(where, "range", std::min((f.limit - f.top) / f.per_unit, kWord - 1.0));
  return w;
}

void check_shift(const std::vector<Front>& fronts, unsigned place_shift) {
  for (const Front& f : fronts)
    if (f.taxel != nullptr && !(std::ldexp(f.limit, static_cast<int>(place_shift)) < std::ldexp(1.0, 30)))
      refuse(taxel_name(*f.taxel), fmt::format("its top would be {:.6g}, beyond 30 bits", f.top),
             "state a larger noise: --noise");
}

unsigned count_shift_of(const std::vector<Front>& fronts) {
  double largest = 0.0;
  for (const Front& f : fronts)
    if (f.taxel != nullptr)
      largest = std::max(largest, 1.01 * kWord * f.per_unit / f.least_factor);  // 1 / 0.995: the top
  return shift_of("gain", largest);
}

struct Film {
  std::shared_ptr<const PreisachCurve::Film> film;
  double low = 0.0;  // output at the lowest input
};

Film film_of(const SensorModel& model, const ModelTaxel& taxel) {
  const LinearisedModel* const outer = linearised_of(taxel);
  const Divider divider = outer == nullptr ? Divider() : outer->divider();
  const auto* const film =
      dynamic_cast<const PreisachModel*>(outer == nullptr ? taxel.fit.model.get() : &outer->inner());
  if (film == nullptr || !model.dynamics)
    refuse(taxel_name(taxel), "it is " + model.model, "export a dynamic model or ELAM: tactbench fit RUN");
  try {
    return {PreisachCurve::film_of(*film, divider), divider.zero + (divider.per_amplitude > 0.0 ? 0.0 : film->y_low())};
  } catch (const std::invalid_argument& error) {
    refuse(taxel_name(taxel), error.what(), "fit it again: tactbench fit RUN");
  }
}

void put_dynamics(const SensorModel& model, FixedModel& made, double half) {
  const FixedOptions& o = made.options;
  const Dynamics& d = model.dynamics->shared;
  if (!(o.frame_rate_hz >= 5.0 && o.frame_rate_hz <= 10000.0))
    refuse(kOfTheModel,
           fmt::format("it undoes creep and lag, and {:g} frames/s are not within 5 and 10000", o.frame_rate_hz),
           "state the device's: --frame-rate HZ");
  tb_dynamic_model& to = made.of_dynamic;
  to.every = static_cast<std::uint16_t>(std::max(1L, std::lround(kRenewal * o.frame_rate_hz)));
  const double renewal_s = to.every / o.frame_rate_hz;
  const double sum = d.creep_share[0] + d.creep_share[1] + d.creep_share[2];
  DynamicsState rested;
  work_unseen(d, rested, o.conditioned_s, made.per_pressure * made.highest);
  for (std::size_t j = 0; j <= kCreepElements; ++j) {
    double rate = kWord * -std::expm1(-renewal_s / (j < kCreepElements ? d.creep_s[j] : d.lag_s));
    for (to.decay_shift[j] = 0; rate < kWord / 4 && to.decay_shift[j] < 12; ++to.decay_shift[j]) rate *= 2.0;
    to.decay[j] = word(kOfTheModel, "decay", std::min(rate, kWord - 1.0));
    if (j == kCreepElements) break;
    to.split[j] = share(kOfTheModel, "share of creep", sum > 0.0 ? d.creep_share[j] / sum : 0.0);
    to.rested[j] = share(kOfTheModel, "creep at rest", rested.psi[j]);
  }
  if (!(half >= 1.0 && half < std::ldexp(1.0, 20) - kWord))
    refuse(kOfTheModel, fmt::format("its creep has half its target at {:.6g} of the device's counts of pressure", half),
           "fit it again");
  put_long(half, to.half);
}

void put_dynamic(const SensorModel& model, FixedModel& made) {
  const std::span<const ModelTaxel> array = model.array();
  std::vector<Front> fronts(array.size());
  std::vector<Film> films(array.size());
  const double sum = model.dynamics->shared.creep_share[0] + model.dynamics->shared.creep_share[1] +
                     model.dynamics->shared.creep_share[2];
  std::size_t n = 0;
  double steepest = 0.0;
  const auto place = [&](std::size_t i) { return std::ldexp(0.8 * fronts[i].output / films[i].film->top(), 20); };
  const auto divides = [&](std::size_t i) {
    return std::ldexp(films[i].film->divider.per_amplitude * fronts[i].output, 20);
  };
  for (std::size_t i = 0; i < array.size(); ++i) {
    if (!array[i].fitted()) continue;
    films[i] = film_of(model, array[i]);
    const PreisachCurve::Film& film = *films[i].film;
    fronts[i] = front_of(model, array[i], films[i].low, film.divider.output(film.top()), made.options);
    const double creep = array[i].creep_scale * sum;
    if (!(creep >= 0.0 && creep <= kMostFixedCreep))
      refuse(taxel_name(array[i]),
             fmt::format("its creep is {:.4g} of its output, and {} are the most", creep, kMostFixedCreep),
             "leave this taxel out of the array, or use the library: docs/how-to-use-a-model-on-a-robot.md");
    fronts[i].least_factor = 1.0 - creep;
    if (n == 0) {
      n = film.n;
      made.x_low = film.x_low;
      made.per_pressure = (film.x_high - film.x_low) / static_cast<double>(n) / 2048.0;
      made.highest = static_cast<unsigned>(n) << 11;
    }
    if (film.n != n || film.x_low != made.x_low || n > kMostIntervals)
      refuse(taxel_name(array[i]),
             fmt::format("its {} intervals are not those of all, 1 to {}", film.n, kMostIntervals),
             "fit it again: tactbench fit RUN");
    steepest = std::max({steepest, place(i), divides(i)});
  }
  put_dynamics(model, made, model.dynamics->shared.creep_half / made.per_pressure);
  tb_dynamic_model& to = made.of_dynamic;
  to.intervals = static_cast<std::uint16_t>(n);
  to.count_shift = static_cast<std::uint16_t>(count_shift_of(fronts));
  to.place_shift = static_cast<std::uint16_t>(shift_of("place", kWord * steepest));
  check_shift(fronts, to.place_shift);
  made.dynamic_words.resize(array.size());
  for (std::size_t i = 0; i < array.size(); ++i) {
    const std::size_t table = made.table.size();
    made.table.resize(table + n * (n + 1) / 2);
    if (fronts[i].taxel == nullptr) continue;
    const std::string where = taxel_name(array[i]);
    const PreisachCurve::Film& film = *films[i].film;
    tb_dynamic_words& w = made.dynamic_words[i];
    w.front = words_of(fronts[i], to.count_shift, place(i), to.place_shift);
    w.divider = word(where, "divider", std::ldexp(kWord * divides(i), -to.place_shift));
    w.creep = share(where, "creep", array[i].creep_scale * sum);
    const double passed_s = 0.5 * (to.every + 1) / made.options.frame_rate_hz;
    const double left = array[i].lag_share * std::exp(-passed_s / model.dynamics->shared.lag_s);
    w.lag = word(where, "lag", 16384.0 * left / (1.0 - left));
    for (std::size_t row = 1; row <= n; ++row)
      for (std::size_t j = 0; j < row; ++j)
        made.table[table + row * (row - 1) / 2 + j] = word(where, "table", kPreisachTop / film.top() * film.at(row, j));
  }
}

void put_elam(const SensorModel& model, FixedModel& made) {
  const std::span<const ModelTaxel> array = model.array();
  std::vector<Front> fronts(array.size());
  double steepest = 0.0;
  const auto place = [&](std::size_t i) { return 16.0 * TB_ELAM_Y / fronts[i].top; };
  const auto elam_of_taxel = [&](std::size_t i) -> const ElamModel& {
    const ElamModel* const elam = paper_elam_of(array[i]);
    if (elam == nullptr)
      refuse(taxel_name(array[i]), "it is ELAM with memory or with more than one split",
             "fit it without --memory and --splits");
    return *elam;
  };
  const ElamModel& first = elam_of_taxel(model.fitted().front());
  for (std::size_t i = 0; i < array.size(); ++i) {
    if (!array[i].fitted()) continue;
    const ElamModel& elam = elam_of_taxel(i);
    if (!std::ranges::equal(elam.ascending.x(), first.ascending.x()) ||
        elam.options.exact_outer != first.options.exact_outer)
      refuse(taxel_name(array[i]), "its pressures are not those of the other taxels",
             "fit it again: tactbench fit RUN");
    fronts[i] = front_of(model, array[i], elam.y0(), elam.yu() - elam.y0(), made.options);
    steepest = std::max(steepest, place(i));
  }
  made.x_low = first.x0();
  made.per_pressure = (first.xu() - first.x0()) / TB_ELAM_X;
  made.highest = TB_ELAM_X;
  for (const double x : first.ascending.x())
    made.x.push_back(word(kOfTheModel, "pressure", (x - made.x_low) / made.per_pressure));
  tb_elam_model& to = made.of_elam;
  to.knots = static_cast<std::uint16_t>(made.x.size());
  to.exact_outer = first.options.exact_outer ? 1 : 0;
  to.count_shift = static_cast<std::uint16_t>(count_shift_of(fronts));
  to.place_shift = static_cast<std::uint16_t>(shift_of("place", kWord * steepest));
  check_shift(fronts, to.place_shift);
  made.elam_words.resize(array.size());
  made.table.assign(2 * array.size() * made.x.size(), 0);
  for (std::size_t i = 0; i < array.size(); ++i) {
    if (fronts[i].taxel == nullptr) continue;
    const std::string where = taxel_name(array[i]);
    const ElamModel& elam = elam_of_taxel(i);
    const ElamParameters& p = elam.parameters;
    tb_elam_words& w = made.elam_words[i];
    w.front = words_of(fronts[i], to.count_shift, place(i), to.place_shift);
    w.alpha_d = share(where, "alpha_d", p.alpha_d);
    w.beta_d = share(where, "beta_d", p.beta_d);
    w.beta_a = share(where, "beta_a", p.beta_a);
    const auto split = [&](double length) { return std::clamp(p.alpha_a1 * length + p.alpha_a0, 0.0, 1.0); };
    w.split_short = share(where, "split", split(0.0));
    w.split_long = share(where, "split", split(elam.xu() - elam.x0()));
    for (std::size_t falls = 0; falls < 2; ++falls) {
      const PatternCurve& pattern = falls == 0 ? elam.ascending : elam.descending;
      for (std::size_t k = 0; k < made.x.size(); ++k)
        made.table[(2 * i + falls) * made.x.size() + k] =
            word(where, "pattern", TB_ELAM_Y * (pattern.y()[k] - elam.y0()) / (elam.yu() - elam.y0()));
    }
  }
}

}  // namespace

tb_dynamic_model FixedModel::dynamic_model() const {
  tb_dynamic_model made = of_dynamic;
  made.words = dynamic_words.data();
  made.everett = table.data();
  return made;
}

tb_elam_model FixedModel::elam_model() const {
  tb_elam_model made = of_elam;
  made.x = x.data();
  made.words = elam_words.data();
  made.patterns = table.data();
  return made;
}

std::uint32_t FixedModel::hash() const { return dynamic ? of_dynamic.hash : of_elam.hash; }

FixedModel quantised(const SensorModel& model, const FixedOptions& options) {
  if (!(options.per_count > 0.0 && std::isfinite(options.per_count)))
    refuse(kOfTheModel, "it is not known what one count of the device is in " + or_not_stated(model.output_unit),
           "name a run of the store, whose scanner says it, or state it: --per-count");
  const std::vector<std::size_t> fitted = model.fitted();
  if (fitted.empty()) refuse(kOfTheModel, "none of its taxels is fitted", "fit a run of the array: tactbench fit RUN");
  FixedModel made;
  made.options = options;
  made.taxels = model.array().size();
  made.dynamic = elam_of(model.array()[fitted.front()]) == nullptr;
  const auto taxels = static_cast<std::uint16_t>(std::min<std::size_t>(made.taxels, 65535));
  const std::uint16_t flip = model.falling ? 65535 : 0;
  if (made.dynamic) {
    if (!model.dynamics)
      refuse(kOfTheModel, "it is " + model.model, "export a dynamic model or ELAM: tactbench fit RUN");
    put_dynamic(model, made);
    made.of_dynamic.taxels = taxels;
    made.of_dynamic.flip = flip;
    const tb_dynamic_model whole = made.dynamic_model();
    made.of_dynamic.hash = tb_dynamic_hash(&whole);
  } else {
    put_elam(model, made);
    made.of_elam.taxels = taxels;
    made.of_elam.flip = flip;
    const tb_elam_model whole = made.elam_model();
    made.of_elam.hash = tb_elam_hash(&whole);
  }
  return made;
}

namespace {

void demand(bool holds) {
  if (!holds) throw std::invalid_argument("fixed frames: the number of values is not that of the taxels");
}

}  // namespace

FixedFrames::FixedFrames(std::shared_ptr<const FixedModel> model)
    : model_(std::move(model)), dynamic_(model_->dynamic_model()), elam_(model_->elam_model()) {
  if (model_->dynamic) {
    dynamic_taxels_.resize(model_->taxels);
    (void)tb_dynamic_init(&dynamic_, &frames_, dynamic_taxels_.data());
  } else {
    elam_taxels_.resize(model_->taxels);
    (void)tb_elam_init(&elam_, &frames_, elam_taxels_.data());
  }
}

void FixedFrames::frame(std::span<const std::uint16_t> counts, std::span<std::uint16_t> pressures,
                        std::span<std::uint16_t> status) {
  demand(counts.size() == model_->taxels && pressures.size() == model_->taxels && status.size() == model_->taxels);
  if (model_->dynamic)
    tb_dynamic_frame(&dynamic_, &frames_, dynamic_taxels_.data(), counts.data(), pressures.data(), status.data());
  else
    tb_elam_frame(&elam_, &frames_, elam_taxels_.data(), counts.data(), pressures.data(), status.data());
}

void FixedFrames::lost_frame(std::span<std::uint16_t> pressures, std::span<std::uint16_t> status) {
  demand(pressures.size() == model_->taxels && status.size() == model_->taxels);
  if (model_->dynamic)
    tb_dynamic_lost_frame(&dynamic_, &frames_, dynamic_taxels_.data(), pressures.data(), status.data());
  else
    tb_elam_lost_frame(&elam_, &frames_, elam_taxels_.data(), pressures.data(), status.data());
}

std::size_t FixedFrames::tare(std::span<const std::uint16_t> counts) {
  demand(counts.size() == model_->taxels);
  return model_->dynamic ? tb_dynamic_tare(&dynamic_, &frames_, dynamic_taxels_.data(), counts.data())
                         : tb_elam_tare(&elam_, &frames_, elam_taxels_.data(), counts.data());
}

FixedTaxel::FixedTaxel(std::shared_ptr<const FixedModel> model, std::size_t place)
    : model_(std::move(model)),
      place_(static_cast<std::uint32_t>(place)),
      dynamic_(model_->dynamic_model()),
      elam_(model_->elam_model()) {
  demand(place < model_->taxels);
  if (model_->dynamic) {
    const tb_dynamic_words& words = dynamic_.words[place];
    dynamic_taxel_.at.zero = tb_signed(words.front.zero[0], words.front.zero[1]);
    tb_dynamic_start(&dynamic_, &words, &dynamic_taxel_, 0);
  } else {
    const tb_elam_words& words = elam_.words[place];
    elam_taxel_.at.zero = tb_signed(words.front.zero[0], words.front.zero[1]);
    tb_elam_start(&elam_, &words, &elam_taxel_, 0);
  }
}

int FixedTaxel::renews() { return frame_++ % dynamic_.every == place_ % dynamic_.every ? 1 : 0; }

FixedReading FixedTaxel::step(std::uint16_t count) {
  gap_ = 0;
  if (model_->dynamic) {
    const std::uint16_t status = tb_dynamic_step(&dynamic_, place_, &dynamic_taxel_, count, renews());
    return {dynamic_taxel_.at.pressure, status};
  }
  const std::uint16_t status = tb_elam_step(&elam_, place_, &elam_taxel_, count);
  return {elam_taxel_.at.pressure, status};
}

FixedReading FixedTaxel::lost() {
  const int forgets = ++gap_ > TB_LONGEST_GAP ? 1 : 0;
  if (model_->dynamic) {
    const std::uint16_t status = tb_dynamic_lose(&dynamic_, place_, &dynamic_taxel_, forgets, renews());
    return {dynamic_taxel_.at.pressure, status};
  }
  const std::uint16_t status = tb_elam_lose(&elam_, place_, &elam_taxel_, forgets);
  return {elam_taxel_.at.pressure, status};
}

bool FixedTaxel::tare(std::uint16_t count) {
  frame_ = gap_ = 0;
  if (model_->dynamic) return tb_dynamic_tare_taxel(&dynamic_, place_, &dynamic_taxel_, count) != 0;
  return tb_elam_tare_taxel(&elam_, place_, &elam_taxel_, count) != 0;
}

std::uint16_t count_of(const FixedModel& model, double output) {
  return static_cast<std::uint16_t>(std::lround(std::clamp(output / model.options.per_count, 0.0, 65535.0)));
}

}  // namespace tactbench::analysis
