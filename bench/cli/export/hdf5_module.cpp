// The module that uses libhdf5: hdf5_file.cpp loads it.
#include <fmt/format.h>
#include <hdf5.h>
#include <hdf5_hl.h>

#include <algorithm>
#include <numeric>

#include "bench/cli/export/hdf5_file.h"
#include "bench/common/error.h"

namespace tactbench::bench {

namespace {

[[noreturn]] void hdf5_failed(const std::string& doing, const std::string& path) {
  throw Error(ExitCode::kUsage, "TB-EXPORT-HDF5", fmt::format("libhdf5 could not {}", doing), path,
              "check that the folder exists, is writable and has space");
}

// One of the library's identifiers, closed with its own function.
class Hdf5Id {
 public:
  Hdf5Id(hid_t id, herr_t (*close)(hid_t), const std::string& doing, const std::string& path) : id_(id), close_(close) {
    if (id_ < 0) hdf5_failed(doing, path);
  }
  ~Hdf5Id() { close_(id_); }
  Hdf5Id(const Hdf5Id&) = delete;
  Hdf5Id& operator=(const Hdf5Id&) = delete;
  [[nodiscard]] hid_t get() const { return id_; }

 private:
  hid_t id_;
  herr_t (*close_)(hid_t);
};

Hdf5Id hdf5_text_type(const std::string& path) {
  const hid_t type = H5Tcopy(H5T_C_S1);
  if (type < 0 || H5Tset_size(type, H5T_VARIABLE) < 0 || H5Tset_cset(type, H5T_CSET_UTF8) < 0)
    hdf5_failed("make a type of text", path);
  return Hdf5Id(type, H5Tclose, "make a type of text", path);
}

class Hdf5Written final : public Hdf5File {
 public:
  explicit Hdf5Written(const std::string& path);
  ~Hdf5Written() override;
  Hdf5Written(const Hdf5Written&) = delete;
  Hdf5Written& operator=(const Hdf5Written&) = delete;

  void group(const std::string& path) override;
  [[nodiscard]] bool has(const std::string& path) const override;
  void array(const std::string& path, const Reals& values, const std::string& unit, const Shape& shape) override;
  void array(const std::string& path, const Integers& values, const std::string& unit) override;
  void array(const std::string& path, const Counts& values, const std::string& unit, const Shape& shape) override;
  void array(const std::string& path, const Texts& values) override;
  void axis(const std::string& path, std::size_t length) override;
  void axis(const std::string& path, const Texts& names) override;
  void axes_of(const std::string& path, const Texts& axes) override;
  void link(const std::string& there, const std::string& path) override;
  void text(const std::string& path, const std::string& value) override;
  void attribute(const std::string& object, const std::string& name, const std::string& value) override;
  void attribute(const std::string& object, const std::string& name, const Texts& values) override;
  void attribute(const std::string& object, const std::string& name, double value) override;
  void attribute(const std::string& object, const std::string& name, std::int64_t value) override;
  void close() override;

 private:
  void write(const std::string& name, hid_t type, const void* values, const std::vector<std::size_t>& shape,
             std::size_t element_bytes) const {
    const std::vector<hsize_t> extent(shape.begin(), shape.end());
    const Hdf5Id space(shape.empty() ? H5Screate(H5S_SCALAR)
                                     : H5Screate_simple(static_cast<int>(extent.size()), extent.data(), nullptr),
                       H5Sclose, "describe " + name, path_);
    const Hdf5Id how(H5Pcreate(H5P_DATASET_CREATE), H5Pclose, "describe " + name, path_);
    // No time stamps: the same run gives the same bytes.
    if (H5Pset_obj_track_times(how.get(), false) < 0) hdf5_failed("describe " + name, path_);
    std::size_t row = element_bytes, all = element_bytes;
    for (std::size_t i = 0; i < shape.size(); ++i) {
      all *= shape[i];
      if (i > 0) row *= shape[i];
    }
    constexpr std::size_t kSmall = 1024, kChunk = 65536;
    if (element_bytes > 0 && all > kSmall) {
      std::vector<hsize_t> chunk = extent;
      chunk[0] = std::clamp<hsize_t>(kChunk / std::max<std::size_t>(row, 1), 1, extent[0]);
      if (H5Pset_chunk(how.get(), static_cast<int>(chunk.size()), chunk.data()) < 0 || H5Pset_shuffle(how.get()) < 0 ||
          H5Pset_deflate(how.get(), 4) < 0)
        hdf5_failed("compress " + name, path_);
    }
    const Hdf5Id set(H5Dcreate2(file_, name.c_str(), type, space.get(), H5P_DEFAULT, how.get(), H5P_DEFAULT), H5Dclose,
                     "make " + name, path_);
    if (all > 0 || element_bytes == 0) {
      if (H5Dwrite(set.get(), type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values) < 0) hdf5_failed("write " + name, path_);
    }
  }

  // Without a length: one value, else a list.
  void write_attribute(const std::string& object, const std::string& name, hid_t type, const void* value,
                       std::size_t length = 0) const {
    const hsize_t extent = length;
    const Hdf5Id space(length == 0 ? H5Screate(H5S_SCALAR) : H5Screate_simple(1, &extent, nullptr), H5Sclose,
                       "describe " + name, path_);
    const Hdf5Id made(H5Acreate_by_name(file_, object.c_str(), name.c_str(), type, space.get(), H5P_DEFAULT,
                                        H5P_DEFAULT, H5P_DEFAULT),
                      H5Aclose, fmt::format("make the attribute {} of {}", name, object), path_);
    if (H5Awrite(made.get(), type, value) < 0) hdf5_failed("write the attribute " + name, path_);
  }

  void make_scale(const std::string& object) const {
    const Hdf5Id set(H5Dopen2(file_, object.c_str(), H5P_DEFAULT), H5Dclose, "open " + object, path_);
    if (H5DSset_scale(set.get(), object.substr(object.rfind('/') + 1).c_str()) < 0)
      hdf5_failed("make a scale of " + object, path_);
  }

  std::string path_;
  hid_t file_ = -1;
};

void Hdf5Written::axis(const std::string& path, std::size_t length) {
  std::vector<std::int64_t> numbers(length);
  std::iota(numbers.begin(), numbers.end(), 0);
  array(path, numbers, {});
  make_scale(path);
}

void Hdf5Written::axis(const std::string& path, const std::vector<std::string>& names) {
  array(path, names);
  make_scale(path);
}

void Hdf5Written::axes_of(const std::string& path, const std::vector<std::string>& axes) {
  const std::string group = path.substr(0, path.rfind('/') + 1);
  const Hdf5Id set(H5Dopen2(file_, path.c_str(), H5P_DEFAULT), H5Dclose, "open " + path, path_);
  for (std::size_t i = 0; i < axes.size(); ++i) {
    const std::string name = group + axes[i];
    const Hdf5Id scale(H5Dopen2(file_, name.c_str(), H5P_DEFAULT), H5Dclose, "open " + name, path_);
    if (H5DSattach_scale(set.get(), scale.get(), static_cast<unsigned>(i)) < 0)
      hdf5_failed("give the dimensions of " + path, path_);
  }
}

bool Hdf5Written::has(const std::string& path) const { return H5Lexists(file_, path.c_str(), H5P_DEFAULT) > 0; }

void Hdf5Written::link(const std::string& there, const std::string& path) {
  if (H5Lcreate_hard(file_, there.c_str(), file_, path.c_str(), H5P_DEFAULT, H5P_DEFAULT) < 0)
    hdf5_failed("make the link " + path, path_);
}

Hdf5Written::Hdf5Written(const std::string& path) : path_(path) {
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);  // the errors below report it
  const Hdf5Id how(H5Pcreate(H5P_FILE_CREATE), H5Pclose, "make the file", path);
  if (H5Pset_obj_track_times(how.get(), false) < 0) hdf5_failed("make the file", path);
  file_ = H5Fcreate(path.c_str(), H5F_ACC_TRUNC, how.get(), H5P_DEFAULT);
  if (file_ < 0) hdf5_failed("make the file", path);
}

Hdf5Written::~Hdf5Written() {
  if (file_ >= 0) H5Fclose(file_);
}

void Hdf5Written::group(const std::string& path) {
  const Hdf5Id how(H5Pcreate(H5P_GROUP_CREATE), H5Pclose, "make " + path, path_);
  if (H5Pset_obj_track_times(how.get(), false) < 0) hdf5_failed("make " + path, path_);
  const Hdf5Id group(H5Gcreate2(file_, path.c_str(), H5P_DEFAULT, how.get(), H5P_DEFAULT), H5Gclose, "make " + path,
                     path_);
}

void Hdf5Written::array(const std::string& path, const std::vector<double>& values, const std::string& unit,
                        const std::vector<std::size_t>& shape) {
  write(path, H5T_NATIVE_DOUBLE, values.data(), shape.empty() ? std::vector{values.size()} : shape, sizeof(double));
  if (!unit.empty()) attribute(path, "units", unit);
}

void Hdf5Written::array(const std::string& path, const std::vector<std::int64_t>& values, const std::string& unit) {
  write(path, H5T_NATIVE_INT64, values.data(), {values.size()}, sizeof(std::int64_t));
  if (!unit.empty()) attribute(path, "units", unit);
}

void Hdf5Written::array(const std::string& path, const std::vector<std::uint16_t>& values, const std::string& unit,
                        const std::vector<std::size_t>& shape) {
  write(path, H5T_NATIVE_UINT16, values.data(), shape, sizeof(std::uint16_t));
  if (!unit.empty()) attribute(path, "units", unit);
}

void Hdf5Written::array(const std::string& path, const std::vector<std::string>& values) {
  const Hdf5Id type = hdf5_text_type(path_);
  std::vector<const char*> pointers;
  pointers.reserve(values.size());
  for (const std::string& value : values) pointers.push_back(value.c_str());
  write(path, type.get(), pointers.data(), {values.size()}, 0);
}

void Hdf5Written::text(const std::string& path, const std::string& value) {
  const Hdf5Id type = hdf5_text_type(path_);
  const char* pointer = value.c_str();
  write(path, type.get(), &pointer, {}, 0);
}

void Hdf5Written::attribute(const std::string& object, const std::string& name, const std::string& value) {
  const Hdf5Id type = hdf5_text_type(path_);
  const char* pointer = value.c_str();
  write_attribute(object, name, type.get(), &pointer);
}

void Hdf5Written::attribute(const std::string& object, const std::string& name,
                            const std::vector<std::string>& values) {
  const Hdf5Id type = hdf5_text_type(path_);
  std::vector<const char*> pointers;
  for (const std::string& value : values) pointers.push_back(value.c_str());
  write_attribute(object, name, type.get(), pointers.data(), pointers.size());
}

void Hdf5Written::attribute(const std::string& object, const std::string& name, double value) {
  write_attribute(object, name, H5T_NATIVE_DOUBLE, &value);
}

void Hdf5Written::attribute(const std::string& object, const std::string& name, std::int64_t value) {
  write_attribute(object, name, H5T_NATIVE_INT64, &value);
}

void Hdf5Written::close() {
  const hid_t file = file_;
  file_ = -1;
  if (H5Fclose(file) < 0) hdf5_failed("close the file", path_);
}

}  // namespace

}  // namespace tactbench::bench

extern "C" __attribute__((visibility("default"))) tactbench::bench::Hdf5File* tactbench_hdf5_file(
    const std::string& path) {
  return new tactbench::bench::Hdf5Written(path);
}
