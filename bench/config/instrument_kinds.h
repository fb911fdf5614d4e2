// The registry of what is plugged in beside the pressure side: [scanner], [stage], [force]. A kind is one row of
// config_scanner.cpp, config_stage.cpp or config_force.cpp: its name and keys in the bench file, its driver, its
// simulated end and, of a stage, what makes it safe without the program; scanner and force sensor move nothing. A
// further kind is a driver with its options and its simulated end in devices, and a row.
#pragma once

#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "bench/config/config.h"
#include "devices/fault_injection.h"
#include "devices/force/force_sensor.h"
#include "devices/pressure/chamber_port.h"
#include "devices/stage/stage.h"
#include "devices/tactile/simulated_scanner.h"
#include "devices/tactile/tactile_array.h"
#include "devices/wire/byte_stream.h"
#include "sequences/toml/key_table.h"

namespace tactbench::bench {

struct SimulatedWorld {  // what a simulated end answers from
  devices::ChamberPort& chamber;
  devices::TactilePort& array;
  devices::ForcePort& force;
  std::function<devices::StageStall()> stall;
  devices::FaultInjector inject;  // of its own wire
  const devices::Clock& clock;
  bool free_running;   // the clock runs by itself
  std::string folder;  // of sockets
};

struct Served {
  std::string what;   // "tactile scanner, frame-source protocol"
  std::string where;  // "127.0.0.1:40001"
};

struct SimulatedEnd {
  std::shared_ptr<void> server;  // serves as long as it is held
  std::vector<Served> served;
  std::vector<sequences::Override> address;   // what the bench file of a client states
  const devices::StageView* stage = nullptr;  // part of the server
};

// Serves it and writes where into `config`, which has a `simulation`. Throws Fault TB-SIM-LISTEN.
using Serve = SimulatedEnd (*)(BenchConfig& config, const SimulatedWorld& world);

struct ScannerRow {
  const char* word;                                                      // of the key `kind`
  void (*read)(const sequences::TomlTable& table, BenchConfig& config);  // its own keys, after those of every kind
  Serve serve;                                                           // null: it has no simulated end
  // Opens it. Throws Fault.
  std::unique_ptr<devices::TactileArray> (*make)(const devices::ScannerOptions& scanner, devices::Clock& clock);
};

struct ForceRow {  // likewise
  const char* word;
  void (*read)(const sequences::TomlTable& table, const BenchConfig& config, ForceConfig& force);
  Serve serve;
  std::unique_ptr<devices::ForceSensor> (*make)(const devices::ForceOptions& force, devices::Clock& clock);
};

struct StageRow {
  using OpenLine = std::function<std::unique_ptr<devices::ByteStream>()>;
  Serve serve;
  // `open_line` opens the line at its address, here or in the dead-man. Talks to nothing yet.
  std::unique_ptr<devices::Stage> (*make)(const devices::StageOptions& stage, OpenLine open_line,
                                          devices::Clock& clock);
  // What the dead-man does over that line: stops all axes and backs z off, as zaber_retreat.h says. Throws Fault.
  devices::StageRetreat (*retreat)(std::unique_ptr<devices::ByteStream> line, const devices::StageOptions& stage,
                                   devices::Millimetres back_off, devices::Nanoseconds move_timeout);
};

// In the order of devices::ScannerKind, ForceKind and StageKind; of stages there is one kind, and no key for it.
std::span<const ScannerRow> scanner_kinds();
std::span<const ForceRow> force_kinds();
std::span<const StageRow> stage_kinds();

const auto& row_of(const auto& rows, auto kind) { return rows[static_cast<std::size_t>(kind)]; }

std::vector<std::string> words_of(const auto& rows) {
  std::vector<std::string> words;
  for (const auto& row : rows) words.emplace_back(row.word);
  return words;
}

sequences::Key terminal_key(devices::DaqmxTerminal& terminal, const char* meaning);  // of an NI card

// Need the origin to be read already.
void read_scanner(const sequences::TomlTable& table, BenchConfig& config);
void read_stage(const sequences::TomlTable& table, BenchConfig& config);
void read_force(const sequences::TomlTable& table, BenchConfig& config);
void add_scanner_keys(std::vector<sequences::KeyFacts>& all);
void add_stage_keys(std::vector<sequences::KeyFacts>& all);
void add_force_keys(std::vector<sequences::KeyFacts>& all);

}  // namespace tactbench::bench
