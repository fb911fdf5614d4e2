// Writes an HDF5 file: groups, arrays and attributes by path. Only this unit uses libhdf5, which is optional: without
// it available() is false and everything else throws.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace tactbench::bench {

class Hdf5File {
 public:
  static bool available();

  // Overwrites an existing file. Every failure throws Error TB-EXPORT-HDF5.
  explicit Hdf5File(const std::string& path);
  ~Hdf5File();
  Hdf5File(const Hdf5File&) = delete;
  Hdf5File& operator=(const Hdf5File&) = delete;

  void group(const std::string& path);  // its parent exists
  [[nodiscard]] bool has(const std::string& path) const;
  // Row-major; an empty shape: one dimension. `unit` becomes the attribute "units" unless it is empty. Large arrays are
  // compressed, first index by first index.
  void array(const std::string& path, const std::vector<double>& values, const std::string& unit = {},
             const std::vector<std::size_t>& shape = {});
  void array(const std::string& path, const std::vector<std::int64_t>& values, const std::string& unit = {});
  void array(const std::string& path, const std::vector<std::uint16_t>& values, const std::string& unit,
             const std::vector<std::size_t>& shape);
  void array(const std::string& path, const std::vector<std::string>& values);
  // An array 0, 1, 2 ... that is the scale of a dimension (HDF5's dimension scales, netCDF's dimensions).
  void axis(const std::string& path, std::size_t length);
  void axis(const std::string& path, const std::vector<std::string>& names);
  // The dimensions of the array at `path`, in order, by axes of its group.
  void axes_of(const std::string& path, const std::vector<std::string>& axes);
  void link(const std::string& there, const std::string& path);  // a second name for what is there
  void text(const std::string& path, const std::string& value);  // a single string, of any length
  void attribute(const std::string& object, const std::string& name, const std::string& value);  // up to 60 kB
  void attribute(const std::string& object, const std::string& name, const std::vector<std::string>& values);
  void attribute(const std::string& object, const std::string& name, double value);
  void attribute(const std::string& object, const std::string& name, std::int64_t value);
  void close();  // flushes and closes the file

 private:
  struct Open;
  std::unique_ptr<Open> open_;
};

}  // namespace tactbench::bench
