// Bench files: the strict TOML reader, which must read back what it writes, and the reader of benches on top of it.
#include <cstdint>
#include <cstdlib>
#include <string>

#include "bench/config/config.h"
#include "devices/device.h"
#include "sequences/toml/strict_toml.h"

using namespace tactbench;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string text(reinterpret_cast<const char*>(data), size);
  try {
    const std::string written = sequences::TomlDocument::from_text(text, "fuzzed.toml").to_text();
    if (sequences::TomlDocument::from_text(written, "written.toml").to_text() != written) std::abort();
  } catch (const sequences::FileError& error) {
    if (error.id() != "TB-FILE-SYNTAX") std::abort();
  }
  try {
    const bench::BenchConfig config = bench::parse_bench(text, "fuzzed.toml", {});
    // No file may raise what the shipped rig's chamber bears, whatever it asks for.
    if (!(config.limits.command_psi <= 100.0) || !(config.limits.command_psi <= config.limits.trip_psi)) std::abort();
    if (config.in_process != config.simulation.has_value() || config.settings.empty()) std::abort();
  } catch (const sequences::FileError& error) {
    if (error.id().empty() || error.where().empty() || error.remedy().empty()) std::abort();
  } catch (const devices::Fault& fault) {
    if (fault.id().empty()) std::abort();
  }
  return 0;
}
