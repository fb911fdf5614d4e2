// The Net F/T's page netftapi2.xml, which holds the scale of its counts. Text to values and back, no I/O.
//
// Elements, anywhere below the root: prodname, cfgcpf and cfgcpt (counts per force and torque unit), scfgfu
// and scfgtu (units), each exactly once; cfgcalsn (calibration's serial), cfgmr (ranges of six axes in these units,
// separated by semicolons), comrdtrate (records per second), mfgdigsn and mfgdigver (the box's serial and firmware),
// each at most once. The optional ones were seen on one sensor's page only (not verified on hardware).
#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>

namespace tactbench::devices {

struct NetFtPage {
  std::string product;
  std::string box_serial;
  std::string firmware;
  std::string calibration_serial;
  double counts_per_force = 1e6;   // above 0, per force_unit
  double counts_per_torque = 1e6;  // above 0, per torque_unit
  std::string force_unit = "N";
  std::string torque_unit = "Nmm";
  std::optional<std::array<double, 6>> range;  // as written: force_unit and torque_unit, each above 0
  double records_per_second = 7000.0;          // above 0; 7000 when the page does not state it
  bool operator==(const NetFtPage&) const = default;

  [[nodiscard]] double newtons_per_count() const;
  [[nodiscard]] double newton_millimetres_per_count() const;
  [[nodiscard]] std::optional<std::array<double, 6>> range_n_nmm() const;
};

// `where` names the page in faults. Throws Fault TB-FORCE-CALIBRATION, naming the missing, duplicate or invalid
// element.
NetFtPage parse_netft_page(std::string_view xml, const std::string& where);
std::string format_netft_page(const NetFtPage& page);

}  // namespace tactbench::devices
