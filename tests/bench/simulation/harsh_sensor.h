// Simulated sensors by their seeds, for the tests of the harsh specimen and the foam.
#pragma once

#include <array>
#include <cstdint>

#include "bench/config/plant_options.h"

namespace tactbench::bench::testing {

// Constants were set with seeds 1 to 3 and inspected with two others, not with these.
inline constexpr std::array<std::uint64_t, 2> kNewSensors = {52163, 880417};

inline SpecimenOptions harsh_sensor(std::uint64_t sensor, std::uint64_t run = 1234) {
  SpecimenOptions options;
  options.kind = SpecimenKind::kHarsh;
  options.sensor_seed = sensor;
  options.seed = run;
  return options;
}

inline SpecimenOptions foam_sensor(std::uint64_t sensor, std::uint64_t run = 1234) {
  SpecimenOptions options = harsh_sensor(sensor, run);
  options.kind = SpecimenKind::kFoam;
  return options;
}

inline SpecimenOptions paper_sensor(std::uint64_t sensor) {
  SpecimenOptions options;
  options.sensor_seed = sensor;
  return options;
}

inline PlantOptions harsh_plant(std::uint64_t sensor, std::uint64_t run) {
  PlantOptions options;
  options.seed = run;
  options.specimen = harsh_sensor(sensor);
  return options;
}

}  // namespace tactbench::bench::testing
