#include "bench/cli/export/hdf5_nexus.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <string>

namespace tactbench::bench {
namespace {

void nexus_group(Hdf5File& file, const std::string& path, const char* kind) {
  file.group(path);
  file.attribute(path, "NX_class", std::string(kind));
}

// What a device measures, and where its values lie.
struct Measured {
  const char *quantity, *values;
};
const std::map<std::string, Measured>& measured_by_role() {
  static const std::map<std::string, Measured> by_role = {{"regulator", {"pressure", "/frames/feedback_psi"}},
                                                          {"pressure reference", {"pressure", "/frames/reference_psi"}},
                                                          {"tactile scanner", {"voltage", "/frames/counts"}},
                                                          {"force sensor", {"force", "/frames/wrench"}}};
  return by_role;
}

std::string name_of_group(const std::string& role, std::size_t number) {
  std::string name = role.empty() ? "device" : role;
  std::ranges::replace_if(
      name, [](char c) { return (c < 'a' || c > 'z') && (c < '0' || c > '9'); }, '_');
  return fmt::format("{}_{}", name, number);
}

void nexus_device(Hdf5File& file, const db::DeviceRecord& device, std::size_t number) {
  const bool stage = device.role.starts_with("stage");
  const auto measured = measured_by_role().find(device.role);
  const bool environment = device.role.ends_with(" sensor") && measured == measured_by_role().end();
  const bool sensor = measured != measured_by_role().end() || environment;
  const std::string path = fmt::format("/entry/instrument/{}", name_of_group(device.role, number));
  nexus_group(file, path, sensor ? "NXsensor" : stage ? "NXpositioner" : "NXcollection");
  file.text(path + "/name", device.role);
  file.text(path + (sensor ? "/model" : "/description"), device.model);
  file.text(path + "/serial_number", device.serial);
  file.attribute(path, "origin", device.origin);
  if (environment) file.text(path + "/measurement", device.role.substr(0, device.role.size() - 7));
  if (measured == measured_by_role().end()) return;
  file.text(path + "/measurement", measured->second.quantity);
  if (file.has(measured->second.values)) file.link(measured->second.values, path + "/value");
}

}  // namespace

void add_nexus(Hdf5File& file, const db::RunRecord& run) {
  file.attribute("/", "NX_class", std::string("NXroot"));
  file.attribute("/", "default", std::string("entry"));
  nexus_group(file, "/entry", "NXentry");
  file.attribute("/entry", "default", std::string("data"));
  file.attribute("/entry", "origin", run.origin);
  file.text("/entry/title",
            fmt::format("{}run {} of sensor {}{}{}", run.origin == "simulated" ? "SIMULATED DATA: " : "", run.run,
                        run.sensor_serial, run.purpose.empty() ? "" : ": ", run.purpose));
  file.text("/entry/entry_identifier_uuid", run.uuid);
  file.text("/entry/start_time", run.started_utc);
  file.text("/entry/end_time", run.ended_utc);
  file.text("/entry/program_name", "tactbench");
  file.attribute("/entry/program_name", "version", run.program_version);
  nexus_group(file, "/entry/user", "NXuser");
  file.text("/entry/user/name", run.operator_name);
  nexus_group(file, "/entry/sample", "NXsample");
  file.text("/entry/sample/name", run.sensor_serial);
  nexus_group(file, "/entry/instrument", "NXinstrument");
  file.text("/entry/instrument/name", run.bench_id);
  for (std::size_t i = 0; i < run.devices.size(); ++i) nexus_device(file, run.devices[i], i);
  file.attribute("/frames", "NX_class", std::string("NXdata"));
  file.attribute("/frames", "signal", std::string("counts"));
  file.attribute("/frames", "axes", std::vector<std::string>{"frame", "scan", "row", "column"});
  file.attribute("/frames", "target", std::string("/frames"));
  file.link("/frames", "/entry/data");
}

}  // namespace tactbench::bench
