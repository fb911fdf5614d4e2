// Parameters of the simulated rig, set by the table [simulation] of a bench file.
#pragma once

#include <cstdint>
#include <vector>

#include "bench/config/chamber_options.h"
#include "bench/config/contact_options.h"
#include "bench/config/instrument_options.h"
#include "bench/config/planned_fault.h"
#include "bench/config/specimen_options.h"

namespace tactbench::bench {

struct ScannerFrontEnd {
  double volts_per_count = 5.0 / 65535.0;  // 16 bit over 0-5 V
  double noise_v = 0.0015;                 // standard deviation per sample
  double relay_settle_s = 0.004;           // waited after a row's relay closes
  double relay_time_constant_s = 0.0006;   // what is left of the row before decays with this
};

struct PlantOptions {
  std::uint64_t seed = 1;  // noise
  ChamberOptions chamber;
  SpecimenOptions specimen;
  ScannerFrontEnd scanner;
  ContactOptions contact;
  InstrumentOptions instruments;
  std::vector<PlannedFault> faults;
  double supply_bar = 8.0;  // compressed air in front of the regulator
};

}  // namespace tactbench::bench
