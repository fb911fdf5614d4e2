#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <string>

#include "analysis/error.h"
#include "analysis/export/write_export.h"
#include "analysis/identify/stored/model_document.h"

namespace tactbench::analysis {
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
