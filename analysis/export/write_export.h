// Writes a model as a folder for a microcontroller: tables of 16-bit integers, the C header that evaluates them, test
// vectors, an example program, a README.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "analysis/export/quantise.h"

namespace tactbench::analysis {

struct ExportedFile {
  std::string name, text;
};

// A file of analysis/export/fixed or verilog, by its name. The build makes this function's source.
std::string_view device_file(std::string_view name);

// `fixed` is of `model`. `name`: of the folder, by which Arduino's sketch is called. The files: tb_model.h, tb_fixed.h,
// tb_dynamic.h or tb_elam.h, NAME.ino, vectors.csv, README.md.
std::vector<ExportedFile> export_files(const SensorModel& model, const FixedModel& fixed, const std::string& name,
                                       const std::string& program_version);

// The same model for a circuit: tb_elam.v and what it includes, tb_model.vh, tb_model.mem, tb_bench.v, tb_pins.v,
// vectors.csv, README.md. Throws AnalysisError TB-MODEL-FIXED for a dynamic model and for what the module has no room
// for.
std::vector<ExportedFile> verilog_files(const SensorModel& model, const FixedModel& fixed,
                                        const std::string& program_version);

// Frames of counts that reach all steps of the arithmetic (turns inside turns, halts, jumps, spikes, both ends, lost
// frames, an unknown start, a tare), and what the integers make of them, as rows of a CSV: event ("frame", "tare",
// "lost"), then the counts, the pressures and the states of all taxels.
std::string vectors_of(const FixedModel& fixed, int frames);

}  // namespace tactbench::analysis
