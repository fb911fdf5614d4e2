// Writes an HDF5 file: groups, arrays and attributes by path. libhdf5 is optional, and lies in a module of its own that
// is loaded when it is asked for: with what it depends on it takes more than half of the time of each start.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace tactbench::bench {

// Every failure throws Error TB-EXPORT-HDF5.
class Hdf5File {
 public:
  using Reals = std::vector<double>;
  using Integers = std::vector<std::int64_t>;
  using Counts = std::vector<std::uint16_t>;
  using Texts = std::vector<std::string>;
  using Shape = std::vector<std::size_t>;

  virtual ~Hdf5File() = default;

  virtual void group(const std::string& path) = 0;  // its parent exists
  [[nodiscard]] virtual bool has(const std::string& path) const = 0;
  // Row-major; an empty shape: one dimension. `unit` becomes the attribute "units" unless it is empty. Large arrays are
  // compressed, first index by first index.
  virtual void array(const std::string& path, const Reals& values, const std::string& unit = {},
                     const Shape& shape = {}) = 0;
  virtual void array(const std::string& path, const Integers& values, const std::string& unit = {}) = 0;
  virtual void array(const std::string& path, const Counts& values, const std::string& unit, const Shape& shape) = 0;
  virtual void array(const std::string& path, const Texts& values) = 0;
  // An array 0, 1, 2 ... that is the scale of a dimension (HDF5's dimension scales, netCDF's dimensions).
  virtual void axis(const std::string& path, std::size_t length) = 0;
  virtual void axis(const std::string& path, const Texts& names) = 0;
  // The dimensions of the array at `path`, in order, by axes of its group.
  virtual void axes_of(const std::string& path, const Texts& axes) = 0;
  virtual void link(const std::string& there, const std::string& path) = 0;  // a second name for what is there
  virtual void text(const std::string& path, const std::string& value) = 0;  // a single string, of any length
  virtual void attribute(const std::string& object, const std::string& name, const std::string& value) = 0;  // to 60 kB
  virtual void attribute(const std::string& object, const std::string& name, const Texts& values) = 0;
  virtual void attribute(const std::string& object, const std::string& name, double value) = 0;
  virtual void attribute(const std::string& object, const std::string& name, std::int64_t value) = 0;
  virtual void close() = 0;  // flushes and closes the file
};

// Overwrites an existing file. Throws Error TB-EXPORT-HDF5, also where there is no module or no libhdf5.
std::unique_ptr<Hdf5File> make_hdf5_file(const std::string& path);

using MakeHdf5File = Hdf5File*(const std::string& path);
inline constexpr const char* kHdf5Module = "tactbench_hdf5.so";
inline constexpr const char* kMakeHdf5File = "tactbench_hdf5_file";

}  // namespace tactbench::bench
