// The whole simulated rig: one plant, and simulated instruments for all entries of a bench file, each with a real
// connection (socket or pseudo-terminal). A bench of origin "simulated" has it in its own process; `tactbench simulate`
// serves it to any client.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "bench/common/private_files.h"
#include "bench/config/instrument_kinds.h"
#include "bench/simulation/ephemeral_addresses.h"
#include "bench/simulation/plant.h"
#include "bench/simulation/simulated_lines.h"

namespace tactbench::bench {

class SimulatedRig {
 public:
  // Starts the simulated instruments of `config` and writes their addresses into it. `clock` must outlive this.
  // `free_running`: the clock runs by itself, and instruments send the same unsolicited data as the real ones. Throws
  // Fault, Error TB-FOLDER-UNSAFE.
  SimulatedRig(BenchConfig& config, const devices::Clock& clock, bool free_running);
  ~SimulatedRig();
  SimulatedRig(const SimulatedRig&) = delete;
  SimulatedRig& operator=(const SimulatedRig&) = delete;
  [[nodiscard]] Plant& plant() { return plant_; }
  [[nodiscard]] const std::vector<Served>& served() const { return served_; }
  // What the bench file of a client states of its instruments other than modules.
  [[nodiscard]] const std::vector<sequences::Override>& addresses() const { return addresses_; }
  [[nodiscard]] const EphemeralAddresses& ephemeral_addresses() const { return ephemeral_addresses_; }

 private:
  [[nodiscard]] devices::StageStall stall_at(devices::Nanoseconds time) const;
  Plant plant_;
  ScratchFolder sockets_{"tactbench-sim"};
  std::vector<Served> served_;
  std::vector<sequences::Override> addresses_;
  EphemeralAddresses ephemeral_addresses_;
  std::unique_ptr<SimulatedLines> lines_;
  std::vector<SimulatedEnd> ends_;
};

}  // namespace tactbench::bench
