// What NeXus is told of each kind of device, against a file that only keeps what is written into it.
#include "bench/cli/export/hdf5_nexus.h"

#include <catch2/catch.hpp>
#include <map>
#include <set>
#include <string>
#include <vector>

using namespace tactbench;

namespace {

class KeptFile : public bench::Hdf5File {
 public:
  void group(const std::string& path) override { groups.insert(path); }
  [[nodiscard]] bool has(const std::string& path) const override { return path != "/frames/wrench"; }
  void array(const std::string&, const Reals&, const std::string&, const Shape&) override {}
  void array(const std::string&, const Integers&, const std::string&) override {}
  void array(const std::string&, const Counts&, const std::string&, const Shape&) override {}
  void array(const std::string&, const Texts&) override {}
  void axis(const std::string&, std::size_t) override {}
  void axis(const std::string&, const Texts&) override {}
  void axes_of(const std::string&, const Texts&) override {}
  void link(const std::string& there, const std::string& path) override { links[path] = there; }
  void text(const std::string& path, const std::string& value) override { texts[path] = value; }
  void attribute(const std::string& object, const std::string& name, const std::string& value) override {
    attributes[object + "@" + name] = value;
  }
  void attribute(const std::string&, const std::string&, const Texts&) override {}
  void attribute(const std::string&, const std::string&, double) override {}
  void attribute(const std::string&, const std::string&, std::int64_t) override {}
  void close() override {}

  std::set<std::string> groups;
  std::map<std::string, std::string> links, texts, attributes;
};

KeptFile written_nexus(const std::vector<db::DeviceRecord>& devices) {
  db::RunRecord run;
  run.run = 7;
  run.origin = "simulated";
  run.sensor_serial = "S-1";
  run.purpose = "to see";
  run.program_version = "1.2";
  run.devices = devices;
  KeptFile file;
  bench::add_nexus(file, run);
  return file;
}

}  // namespace

TEST_CASE("NeXus: each kind of device has its class, its place and its quantity") {
  KeptFile file = written_nexus({{"regulator", "R", "1", "", "simulated", ""},
                                 {"pressure reference", "P", "2", "", "simulated", ""},
                                 {"tactile scanner", "T", "3", "", "simulated", ""},
                                 {"force sensor", "F", "4", "", "simulated", ""},
                                 {"temperature sensor", "K", "5", "", "hardware", ""},
                                 {"stage x", "X", "6", "", "simulated", ""},
                                 {"analog module", "M", "7", "", "simulated", ""},
                                 {"", "N", "8", "", "simulated", ""},
                                 {"az09 AZ:`{/", "O", "9", "", "simulated", ""}});
  const std::string at = "/entry/instrument/";
  const auto kind = [&](const std::string& name) { return file.attributes[at + name + "@NX_class"]; };
  for (const char* sensor :
       {"regulator_0", "pressure_reference_1", "tactile_scanner_2", "force_sensor_3", "temperature_sensor_4"}) {
    CHECK(kind(sensor) == "NXsensor");
    CHECK(file.texts.contains(at + sensor + "/model"));
    CHECK_FALSE(file.texts.contains(at + sensor + "/description"));
  }
  CHECK(kind("stage_x_5") == "NXpositioner");
  for (const char* other : {"analog_module_6", "device_7", "az09________8"}) {
    INFO(other);
    CHECK(kind(other) == "NXcollection");
    CHECK(file.texts.contains(at + other + "/description"));
    CHECK_FALSE(file.texts.contains(at + other + "/measurement"));
  }
  CHECK(file.texts[at + "regulator_0/measurement"] == "pressure");
  CHECK(file.texts[at + "tactile_scanner_2/measurement"] == "voltage");
  CHECK(file.texts[at + "force_sensor_3/measurement"] == "force");
  CHECK(file.texts[at + "temperature_sensor_4/measurement"] == "temperature");
  CHECK_FALSE(file.texts.contains(at + "stage_x_5/measurement"));
  CHECK(file.texts[at + "temperature_sensor_4/serial_number"] == "5");
  CHECK(file.attributes[at + "temperature_sensor_4@origin"] == "hardware");
  CHECK(file.links == std::map<std::string, std::string>{{at + "regulator_0/value", "/frames/feedback_psi"},
                                                         {at + "pressure_reference_1/value", "/frames/reference_psi"},
                                                         {at + "tactile_scanner_2/value", "/frames/counts"},
                                                         {"/entry/data", "/frames"}});
}

TEST_CASE("NeXus: the entry says what the run is") {
  KeptFile file = written_nexus({});
  CHECK(file.texts["/entry/title"] == "SIMULATED DATA: run 7 of sensor S-1: to see");
  CHECK(file.texts["/entry/program_name"] == "tactbench");
  CHECK(file.attributes["/entry/program_name@version"] == "1.2");
  CHECK(file.attributes["/@NX_class"] == "NXroot");
  CHECK(file.attributes["/frames@signal"] == "counts");
  for (const char* group : {"/entry", "/entry/user", "/entry/sample", "/entry/instrument"})
    CHECK(file.groups.contains(group));
}
