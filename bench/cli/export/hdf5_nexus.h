// The run's HDF5 file as NeXus describes one (https://manual.nexusformat.org): an NXentry with NXdata, NXsensor,
// NXsample and NXuser, made of second names for what the file has.
#pragma once

#include "bench/cli/export/hdf5_file.h"
#include "db/record.h"

namespace tactbench::bench {

// After all else was written. Throws Error TB-EXPORT-HDF5.
void add_nexus(Hdf5File& file, const db::RunRecord& run);

}  // namespace tactbench::bench
