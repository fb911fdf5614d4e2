#include "bench/cli/export/hdf5_file.h"

#include "analysis/module_symbol.h"
#include "bench/common/error.h"

namespace tactbench::bench {

std::unique_ptr<Hdf5File> make_hdf5_file(const std::string& path) {
  static auto* const make = reinterpret_cast<MakeHdf5File*>(analysis::module_symbol(kHdf5Module, kMakeHdf5File));
  if (make == nullptr)
    throw Error(ExitCode::kUsage, "TB-EXPORT-HDF5",
                "this program was built without libhdf5, or libhdf5 is not installed", path,
                "install libhdf5-dev and build again, or take --format json or csv");
  return std::unique_ptr<Hdf5File>(make(path));
}

}  // namespace tactbench::bench
