#include "analysis/export/write_export.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <memory>
#include <random>
#include <span>
#include <string>

#include "analysis/error.h"
#include "analysis/export/quantise.h"
#include "analysis/identify/stored/model_document.h"

namespace tactbench::analysis {
namespace {

// One row of a vector: where a taxel's counts go.
class Stimulus {
 public:
  Stimulus(const tb_front& words, unsigned shift, unsigned flip, unsigned number)
      : zero_(std::ldexp(static_cast<double>(tb_signed(words.zero[0], words.zero[1])), -static_cast<int>(shift))),
        flip_(flip),
        nested_(number % 3 == 0),
        random_(number + 1) {
    if (words.gain == 0) return;
    per_noise_ = std::ldexp(256.0 * 65536.0 / words.gain, -static_cast<int>(shift));
    span_ = tb_signed(words.top[0], words.top[1]) / 256.0 * per_noise_;
    now_ = part(1.0);  // anywhere: the start is unknown
    turn();
  }
  std::uint16_t rest() { return written(zero_ + 0.01 * span_ * part(1.0)); }
  std::uint16_t next() {
    if (std::abs(to_ - now_) <= step_)
      turn();
    else
      now_ += std::copysign(step_, to_ - now_);
    if (random_() % 64 == 0) {  // a spike
      const std::uint16_t spikes[] = {0, 65535, static_cast<std::uint16_t>(random_())};
      return spikes[random_() % 3];
    }
    return written(zero_ + span_ * now_ + per_noise_ * (part(6.0) - 3.0));
  }
  void begin_at_rest() { now_ = to_ = 0.0; }

 private:
  // Evenly within 0 and `most`; of integers, so that every library draws the same.
  double part(double most) { return most * static_cast<double>(random_() % 4096) / 4096.0; }
  // Nested: each swing ends inside the one before, until they are too small; else anywhere.
  void turn() {
    now_ = to_;
    low_to_ = !low_to_;
    if (nested_ && high_ - low_ > 0.04) {
      (low_to_ ? low_ : high_) += (low_to_ ? 0.09 : -0.09) * (high_ - low_);
      to_ = low_to_ ? low_ : high_;
      step_ = 0.34 * (high_ - low_) + 0.01;
      return;
    }
    low_ = 0.0;
    high_ = 1.0;
    to_ = std::clamp(part(1.5) - 0.25, -0.03, 1.03);
    const double steps[] = {0.0, 0.01, 0.05, 0.2, 0.6};
    step_ = steps[random_() % 5];
    if (step_ == 0.0) {  // a halt
      to_ = now_ + 0.004;
      step_ = 0.0002;
    }
  }
  [[nodiscard]] std::uint16_t written(double count) const {
    return static_cast<std::uint16_t>(static_cast<unsigned>(std::lround(std::clamp(count, 0.0, 65535.0))) ^ flip_);
  }
  double zero_, per_noise_ = 0.0, span_ = 0.0;
  unsigned flip_;
  bool nested_, low_to_ = false;
  double now_ = 0.0, to_ = 0.0, step_ = 0.1, low_ = 0.0, high_ = 1.0;
  std::mt19937 random_;
};

std::string words_text(std::span<const std::uint16_t> words) {
  std::string text;
  for (std::size_t i = 0; i < words.size(); ++i) text += fmt::format("{}{}", words[i], (i + 1) % 20 == 0 ? ",\n" : ",");
  if (!text.ends_with('\n')) text += '\n';
  return text;
}

std::string front_text(const tb_front& w) {
  return fmt::format("{{{}, {{{}, {}}}, {{{}, {}}}, {{{}, {}}}, {}, {}, {}}}", w.gain, w.zero[0], w.zero[1], w.top[0],
                     w.top[1], w.limit[0], w.limit[1], w.place, w.up, w.down);
}

// Of the model in C; `kind`: "dynamic" or "elam".
std::string functions_text(const char* kind) {
  return fmt::format(R"(typedef struct {{
  tb_frames frames;
  tb_{0}_taxel taxels[TB_TAXELS];
}} tb_state;

/* 1: the tables are those that were exported. All histories are unknown. */
static inline int tb_init(tb_state* state) {{ return tb_{0}_init(&tb_model, &state->frames, state->taxels); }}
/* `counts` are those of the unloaded sensor at rest. How many taxels were too far off: they keep their zero. */
static inline uint32_t tb_tare(tb_state* state, const uint16_t* counts) {{
  return tb_{0}_tare(&tb_model, &state->frames, state->taxels, counts);
}}
/* TB_TAXELS counts, pressures and states, row by row. */
static inline void tb_frame(tb_state* state, const uint16_t* counts, uint16_t* pressures, uint16_t* status) {{
  tb_{0}_frame(&tb_model, &state->frames, state->taxels, counts, pressures, status);
}}
/* A frame was lost. */
static inline void tb_lost_frame(tb_state* state, uint16_t* pressures, uint16_t* status) {{
  tb_{0}_lost_frame(&tb_model, &state->frames, state->taxels, pressures, status);
}}
)",
                     kind);
}

// Text for a comment or string of C.
std::string plain(const std::string& text) {
  std::string safe = or_not_stated(text);
  std::ranges::replace_if(
      safe, [](char c) { return c == '*' || c == '"' || c == '\\' || c < ' '; }, '?');
  return safe;
}

std::string model_text(const SensorModel& model, const FixedModel& fixed, const std::string& program_version) {
  const char* const kind = fixed.dynamic ? "dynamic" : "elam";
  std::string text = fmt::format(
      "/* {} of {} ({}), sensor {}, sha256 {}; written by tactbench {}.\n * Frames a second (0: any) {:g}, scans "
      "averaged into "
      "a count {}, {} of a count {:.10g}. */\n"
      "#ifndef TB_MODEL_H\n#define TB_MODEL_H\n\n#include \"tb_{}.h\"\n\n"
      "#define TB_TAXELS {}U\n#define TB_ROWS {}U\n#define TB_COLUMNS {}U\n"
      "/* pressure = TB_LOWEST + TB_PER_COUNT * count, TB_HIGHEST the largest count. */\n"
      "#define TB_UNIT \"{}\"\n#define TB_LOWEST {:#.10g}\n#define TB_PER_COUNT {:#.12g}\n#define TB_HIGHEST {}U\n\n",
      plain(label_of(model)), plain(model.source), plain(model.origin), plain(model.sensor_serial),
      sha256_of(model).substr(0, 12), plain(program_version), fixed.dynamic ? fixed.options.frame_rate_hz : 0.0,
      fixed.options.scans, plain(model.output_unit), fixed.options.per_count, kind, fixed.taxels, model.rows,
      model.columns, plain(model.input_unit), fixed.x_low, fixed.per_pressure, fixed.highest);
  text += fmt::format("static const tb_{}_words tb_words[TB_TAXELS] = {{\n", kind);
  for (const tb_dynamic_words& w : fixed.dynamic_words)
    text += fmt::format("{{{}, {}, {}, {}}},\n", front_text(w.front), w.divider, w.creep, w.lag);
  for (const tb_elam_words& w : fixed.elam_words)
    text += fmt::format("{{{}, {}, {}, {}, {}, {}}},\n", front_text(w.front), w.alpha_d, w.beta_d, w.beta_a,
                        w.split_short, w.split_long);
  text += "};\n";
  if (!fixed.dynamic) text += "static const uint16_t tb_x[] = {\n" + words_text(fixed.x) + "};\n";
  text += "static const uint16_t tb_table[] = {\n" + words_text(fixed.table) + "};\n";
  if (fixed.dynamic) {
    const tb_dynamic_model& m = fixed.of_dynamic;
    const auto list = [](const auto& own) { return fmt::format("{{{}}}", fmt::join(own, ", ")); };
    text += fmt::format(
        "static const tb_dynamic_model tb_model = {{0x{:08X}U, {}, {}, {}, {}, {}, {}, {}, {}, {}, {}, {}, tb_words, "
        "tb_table}};\n\n",
        m.hash, m.taxels, m.intervals, m.every, m.flip, m.count_shift, m.place_shift, list(m.decay),
        list(m.decay_shift), list(m.split), list(m.rested), list(m.half));
  } else {
    const tb_elam_model& m = fixed.of_elam;
    text += fmt::format(
        "static const tb_elam_model tb_model = {{0x{:08X}U, {}, {}, {}, {}, {}, {}, tb_x, tb_words, tb_table}};\n\n",
        m.hash, m.taxels, m.knots, m.flip, m.count_shift, m.place_shift, m.exact_outer);
  }
  return text + functions_text(kind) + "\n#endif\n";
}

std::string readme_text(const SensorModel& model, const FixedModel& fixed, const std::string& name,
                        const std::string& program_version) {
  const FixedOptions& o = fixed.options;
  std::string options = fmt::format("--per-count {:.17g} --scans {}", o.per_count, o.scans);
  if (fixed.dynamic) options += fmt::format(" --frame-rate {:g}", o.frame_rate_hz);
  if (o.noise > 0.0) options += fmt::format(" --noise {:g}", o.noise);
  if (o.conditioned_s > 0.0) options += fmt::format(" --conditioned {:g}", o.conditioned_s);
  const std::size_t table = fixed.table.size() + fixed.x.size();
  const std::size_t row = fixed.dynamic ? sizeof(tb_dynamic_words) : sizeof(tb_elam_words);
  const std::size_t state = fixed.dynamic ? sizeof(tb_dynamic_taxel) : sizeof(tb_elam_taxel);
  return fmt::format(
      R"(# {0}: {1} of {2} ({3} data)

Counts of a converter in, counts of pressure out, in integers. C99 or C++11, no library, no allocation, at most 32 bits.
Not verified on hardware.

| file | is |
|---|---|
| tb_model.h | the model: {4} taxels, {5} bytes of tables |
| tb_fixed.h, tb_{6}.h | the compensator; what `tactbench compensate --as fixed` runs |
| {0}.ino | example: an Arduino sketch, and a C program that checks vectors.csv |
| vectors.csv | counts, and the pressures and states that must come out |

**Scale.** Pressure = {7:.6g} + {8:.9g} x count, in {9}; the largest count is {10}. A count of the converter is {11:.9g} {12}, 0 to 65535:
shift the counts of a converter of fewer bits to the left.

**Calls.** `tb_state` takes {13} bytes.
`tb_init(&state)` gives 1 when the tables have the hash that was exported (0x{14:08x}), else they are damaged: do not go on.
`tb_tare(&state, counts)` with the sensor unloaded makes these counts the zero, and tells how many taxels were too far off.
Then, {15}, `tb_frame(&state, counts, pressures, status)`, {4} of each, row by row ({16} x {17});
in place of a frame that did not come `tb_lost_frame(&state, pressures, status)`.

**Status.** 1 valid; 4 out of range: a count that the taxel cannot give, the last pressure again or the loop's end; 8 dead, pressure 0; 32 unknown:
not tared and neither at its zero nor at its top yet, so that the history is not known; 64 lost.

**Check.** On the host, and the same on the device's compiler:

    cc -std=c99 -O2 -x c {0}.ino -o check && ./check < vectors.csv

**Recompute a log.** Its counts, a column a taxel or one with `--taxel N`, give the same counts of pressure, bit for bit:

    tactbench compensate MODEL log.csv --as fixed --counts {18}

With `--tared` where the log begins with the frame that was tared by.

(sha256 of MODEL: {19}; tactbench {20})
)",
      name, label_of(model), model.source, model.origin, fixed.taxels, 2 * table + row * fixed.taxels,
      fixed.dynamic ? "dynamic" : "elam", fixed.x_low, fixed.per_pressure, or_not_stated(model.input_unit),
      fixed.highest, o.per_count, or_not_stated(model.output_unit), state * fixed.taxels + sizeof(tb_frames),
      fixed.hash(), fixed.dynamic ? fmt::format("{:g} times a second", o.frame_rate_hz) : std::string("at any rate"),
      model.rows, model.columns, options, sha256_of(model), program_version);
}

}  // namespace

std::string vectors_of(const FixedModel& fixed, int frames) {
  FixedFrames stream(std::make_shared<const FixedModel>(fixed));
  std::vector<Stimulus> stimuli;
  const unsigned shift = fixed.dynamic ? fixed.of_dynamic.count_shift : fixed.of_elam.count_shift;
  const unsigned flip = fixed.dynamic ? fixed.of_dynamic.flip : fixed.of_elam.flip;
  for (std::size_t t = 0; t < fixed.taxels; ++t)
    stimuli.emplace_back(fixed.dynamic ? fixed.dynamic_words[t].front : fixed.elam_words[t].front, shift, flip,
                         static_cast<unsigned>(t));
  std::vector<std::uint16_t> counts(fixed.taxels), pressures(fixed.taxels), status(fixed.taxels);
  std::string text;
  for (int i = 0; i < frames; ++i) {
    const bool tares = i == frames / 4;
    const bool lost = i % 60 == 40 || (i >= frames * 3 / 4 && i <= frames * 3 / 4 + TB_LONGEST_GAP);
    if (tares)
      for (std::size_t t = 0; t < fixed.taxels; ++t) {
        counts[t] = stimuli[t].rest();
        stimuli[t].begin_at_rest();
      }
    else
      std::ranges::transform(stimuli, counts.begin(), [](Stimulus& own) { return own.next(); });
    if (tares)
      (void)stream.tare(counts);
    else if (lost)
      stream.lost_frame(pressures, status);
    else
      stream.frame(counts, pressures, status);
    text += fmt::format("{},{},{},{}\n",
                        tares  ? "tare"
                        : lost ? "lost"
                               : "frame",
                        fmt::join(counts, ","), fmt::join(pressures, ","), fmt::join(status, ","));
  }
  return text;
}

std::vector<ExportedFile> export_files(const SensorModel& model, const FixedModel& fixed, const std::string& name,
                                       const std::string& program_version) {
  constexpr int kFrames = 240;
  std::vector<ExportedFile> files = {{"tb_model.h", model_text(model, fixed, program_version)}};
  for (const char* const own : {"tb_fixed.h", fixed.dynamic ? "tb_dynamic.h" : "tb_elam.h"})
    files.push_back({own, std::string(device_file(own))});
  files.push_back({name + ".ino", std::string(device_file("example.ino"))});
  files.push_back({"vectors.csv", vectors_of(fixed, kFrames)});
  files.push_back({"README.md", readme_text(model, fixed, name, program_version)});
  return files;
}

namespace {

constexpr std::size_t kMostTaxels = 256, kLeastKnots = 3, kMostKnots = 32;  // a page of the module's memories
constexpr long kMostSum = 1L << 25;  // half of what the module's signed 27 bits hold

[[noreturn]] void refuse(const std::string& what, const std::string& remedy) {
  throw AnalysisError("TB-MODEL-FIXED", "the model as Verilog: " + what, remedy);
}

// What the header's 32 bits hold, and the module's 27 may not.
void check_widths(const FixedModel& fixed) {
  const tb_elam_model& m = fixed.of_elam;
  for (std::size_t i = 0; i < fixed.taxels; ++i) {
    const tb_front& w = fixed.elam_words[i].front;
    const long most = std::max((65535L << m.count_shift) + std::labs(tb_signed(w.zero[0], w.zero[1])),
                               static_cast<long>(tb_signed(w.limit[0], w.limit[1])) << m.place_shift);
    if (w.gain != 0 && most >= kMostSum)
      refuse(fmt::format("a sum of taxel {} would be {}, and {} is the most", i, most, kMostSum - 1),
             "give a larger --noise, or --format c");
  }
}

std::vector<std::uint16_t> words_of(const FixedModel& fixed) {
  std::vector<std::uint16_t> words = fixed.x;
  for (const tb_elam_words& own : fixed.elam_words) {
    const tb_front& w = own.front;
    words.insert(words.end(), {w.gain, w.zero[0], w.zero[1], w.top[0], w.top[1], w.limit[0], w.limit[1], w.place, w.up,
                               w.down, own.alpha_d, own.beta_d, own.beta_a, own.split_short, own.split_long});
  }
  words.insert(words.end(), fixed.table.begin(), fixed.table.end());
  return words;
}

std::string readme_text(const SensorModel& model, const FixedModel& fixed, const std::string& program_version) {
  return fmt::format(
      R"(# {0} of {1} ({2} data), in Verilog

Counts of a converter in, counts of pressure out: the integers of tb_elam.h (`model export --format c`), bit for bit. Verilog-2005.
Not verified on hardware.

| file | is |
|---|---|
| tb_elam.v, tb_steps.vh, tb_direction.vh, tb_memory.v | the module, which takes {3} taxels one after another |
| tb_model.vh | its parameters, among them the hash of the words |
| tb_model.mem | {4} words, to be loaded in this order after each reset |
| tb_bench.v | test bench: loads them and holds the module against vectors.csv |
| vectors.csv | counts, and the pressures and states that must come out: those of the C export |
| tb_pins.v | the module between 11 pins, to place it by itself |

**Scale.** Pressure = {5:.6g} + {6:.9g} x count, in {7}; the largest count is 65535. A count of the converter is {8:.9g} {9}, 0 to 65535.

**Check.** The second line is seen at the end of either:

    iverilog -g2005 -o bench tb_bench.v tb_elam.v tb_memory.v && vvp bench +rows=20
    PASSED

    verilator --binary --timing -Wno-fatal --top-module tb_bench tb_bench.v tb_elam.v tb_memory.v && obj_dir/Vtb_bench

**Load.** After a reset {4} words with `load_valid`, while `load_ready`. The module then reads its memories back; at `loaded`, `hash` must
be 0x{10:08x}: else they are damaged, do not go on.

**Run.** {3} counts a frame, row by row, each with `in_valid` until `in_ready`; `in_event` 0: a frame, 1: in place of one that was lost,
2: tare, by the counts of the unloaded sensor. A reading comes out for each, pressure and status: 1 valid, 4 out of range, 8 dead,
32 history unknown, 64 lost; of a tare 1, or 36 where the taxel was too far off. The test bench prints the most cycles a taxel that the module can take.

(sha256 of MODEL: {11}; tactbench {12})
)",
      label_of(model), model.source, model.origin, fixed.taxels, words_of(fixed).size(), fixed.x_low,
      fixed.per_pressure, or_not_stated(model.input_unit), fixed.options.per_count, or_not_stated(model.output_unit),
      fixed.hash(), sha256_of(model), program_version);
}

}  // namespace

std::vector<ExportedFile> verilog_files(const SensorModel& model, const FixedModel& fixed,
                                        const std::string& program_version) {
  constexpr int kFrames = 240;
  const std::size_t knots = fixed.x.size();
  if (fixed.dynamic) refuse("there is a module for ELAM alone", "fit RUN --model elam, or --format c");
  if (fixed.taxels > kMostTaxels || knots < kLeastKnots || knots > kMostKnots)
    refuse(fmt::format("{} taxels, {} knots; up to {}, and {} to {}", fixed.taxels, knots, kMostTaxels, kLeastKnots,
                       kMostKnots),
           "use --format c");
  check_widths(fixed);
  const std::vector<std::uint16_t> words = words_of(fixed);
  const tb_elam_model& m = fixed.of_elam;
  std::string memory;
  for (const std::uint16_t word : words) memory += fmt::format("{:04x}\n", word);
  std::vector<ExportedFile> files = {
      {"tb_model.vh",
       fmt::format(
           "`define TB_TAXELS {}\n`define TB_KNOTS {}\n`define TB_FLIP {}\n`define TB_COUNT_SHIFT {}\n"
           "`define TB_PLACE_SHIFT {}\n`define TB_EXACT_OUTER {}\n`define TB_WORDS {}\n`define TB_HASH 32'h{:08x}\n",
           m.taxels, m.knots, m.flip, m.count_shift, m.place_shift, m.exact_outer, words.size(), m.hash)},
      {"tb_model.mem", memory}};
  for (const char* const own :
       {"tb_elam.v", "tb_steps.vh", "tb_direction.vh", "tb_memory.v", "tb_bench.v", "tb_pins.v"})
    files.push_back({own, std::string(device_file(own))});
  files.push_back({"vectors.csv", vectors_of(fixed, kFrames)});
  files.push_back({"README.md", readme_text(model, fixed, program_version)});
  return files;
}

}  // namespace tactbench::analysis
