#include "devices/library_versions.h"

#include <fmt/format.h>
#include <hidapi.h>
#include <libserialport.h>
#include <modbus.h>

#include <Eigen/Core>
#include <pugixml.hpp>

namespace tactbench::devices {

std::vector<std::pair<std::string, std::string>> library_versions() {
  return {
      {"libmodbus", fmt::format("{}.{}.{}", libmodbus_version_major, libmodbus_version_minor, libmodbus_version_micro)},
      {"libserialport", sp_get_package_version_string()},
      {"hidapi", hid_version_str()},
      {"pugixml", fmt::format("{}.{}", PUGIXML_VERSION / 1000, PUGIXML_VERSION % 1000 / 10)},
      {"Eigen", fmt::format("{}.{}.{}", EIGEN_WORLD_VERSION, EIGEN_MAJOR_VERSION, EIGEN_MINOR_VERSION)},
  };
}

}  // namespace tactbench::devices
