// Registers a sensor: `sensors add`, and `calibrate` for a new sensor.
#pragma once

#include <string>

#include "db/run_store.h"

namespace tactbench::bench {

struct SensorEntry {
  std::string serial, type_file = "sensor.toml", scanner, note;  // scanner: serial; empty: any
};
// Stores the sensor in the store `db`, which is made if absent, and returns its record. Throws
// sequences::FileError for the type file, db::StoreError for a serial that is registered already or cannot be stored.
db::SensorRecord register_sensor(const std::string& db, const SensorEntry& entry);

}  // namespace tactbench::bench
