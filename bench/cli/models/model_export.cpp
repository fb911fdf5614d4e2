#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>

#include "analysis/export/write_export.h"
#include "bench/cli/models/fixed_options.h"
#include "bench/cli/runs/source.h"
#include "bench/cli/session.h"
#include "bench/common/build_info.h"
#include "bench/common/output_file.h"

namespace tactbench::bench {

namespace {

struct ExportOptions {
  std::string model, output, format = "json";
  analysis::FixedOptions device;
};

void export_model(const ExportOptions& options, const Session& session) {
  namespace fs = std::filesystem;
  const analysis::SensorModel model = load_model(options.model, session);
  if (options.format == "json") {
    write_output(options.output, analysis::to_text(model), session.replace);
    return;
  }
  const analysis::FixedModel fixed = fixed_model(options.model, model, options.device, session);
  const fs::path folder = fs::absolute(options.output).lexically_normal();
  const std::string name = (folder.has_filename() ? folder : folder.parent_path()).filename().string();
  const std::vector<analysis::ExportedFile> files =
      options.format == "c" ? analysis::export_files(model, fixed, name, build_info().version)
                            : analysis::verilog_files(model, fixed, build_info().version);
  auto written = nlohmann::ordered_json::array();
  for (const analysis::ExportedFile& file : files) {
    const std::string path = (folder / file.name).string();
    if (fs::exists(path) && !session.replace)
      throw Error("TB-FILE-EXISTS", fmt::format("'{}' exists already", path), path,
                  "give another folder, or --replace to overwrite it");
    check_output(path, "a file of tactbench model export", session.replace);  // never over a store
  }
  for (const analysis::ExportedFile& file : files) {
    write_output((folder / file.name).string(), file.text, true);
    written.push_back(file.name);
  }
  if (session.json) {
    print_json("model.export", {{"folder", options.output},
                                {"files", written},
                                {"taxels", fixed.taxels},
                                {"unit", model.input_unit},
                                {"lowest", fixed.x_low},
                                {"per_count", fixed.per_pressure},
                                {"hash", fmt::format("{:08x}", fixed.hash())}});
    return;
  }
  tty::print("{}: {} taxels, pressure = {:.6g} + {:.6g} x count, in {}; hash {:08x}\n", options.output, fixed.taxels,
             fixed.x_low, fixed.per_pressure, model.input_unit, fixed.hash());
}

}  // namespace

void add_model_export(CLI::App& model, Session& session) {
  auto options = std::make_shared<ExportOptions>();
  CLI::App* verb =
      model.add_subcommand("export", "write a model as its JSON document, as C for a microcontroller, or as Verilog");
  verb->add_option("model", options->model, "a .json that fit -o wrote, or RUN or RUN:FIT of the store")->required();
  verb->add_option("-o,--output", options->output,
                   "file to write; c, verilog: folder, whose name is also that of the Arduino sketch")
      ->required();
  verb->add_option("--format", options->format,
                   "json; c: tables and header for a microcontroller, in integers, of a dynamic model or of ELAM; "
                   "verilog: the same integers as a circuit, of ELAM")
      ->check(CLI::IsMember({"json", "c", "verilog"}))
      ->capture_default_str();
  add_device_options(*verb, options->device);
  verb->add_option("--conditioned", options->device.conditioned_s,
                   "c, dynamic: seconds for which the pressure cycles over its range just before each start")
      ->check(CLI::Range(0.0, 1e9))
      ->capture_default_str();
  add_replace(*verb, session);
  add_void_too(*verb, session);
  verb->callback([options, &session] { export_model(*options, session); });
}

}  // namespace tactbench::bench
