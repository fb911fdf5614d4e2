// A whole run as one HDF5 file, for NumPy and MATLAB.
#pragma once

#include <cstddef>
#include <string>

#include "bench/cli/export/hdf5_file.h"
#include "db/run_store.h"

namespace tactbench::bench {

// What the file of a run holds. Groups: /frames (one array a column, counts as frames x scans x rows x columns),
// /trace, /branches, /events, /checks, /series, /verdicts, /devices/N with their calibration, /recipes/N,
// /configuration. The members of run_json() are attributes of the root, of /recipes/N and of /devices/N, under the same
// names: truth is 0 or 1, a list of texts one text, what is not known NaN or empty; overrides and notes are texts below
// /configuration. Units are attributes of the arrays. Throws Error TB-EXPORT-HDF5 for frames of several shapes;
// StoreError.
void put_run(Hdf5File& file, const db::RunStore& store, const db::RunRecord& run);

// The file appears whole or not at all; returns its bytes. Throws as put_run(), and Error TB-EXPORT-HDF5, also when the
// program was built without libhdf5.
std::size_t write_run_hdf5(const db::RunStore& store, const db::RunRecord& run, const std::string& path);

}  // namespace tactbench::bench
