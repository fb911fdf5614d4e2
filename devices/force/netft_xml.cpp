#include "devices/force/netft_xml.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>
#include <pugixml.hpp>
#include <sstream>

#include "devices/device.h"
#include "devices/force/ati_calibration.h"

namespace tactbench::devices {
namespace {

constexpr std::size_t kLargestDocument = std::size_t{1} << 18U;
constexpr double kLargestRange = 1e9;

[[noreturn]] void fail(const std::string& where, const std::string& what) {
  throw Fault("TB-FORCE-CALIBRATION", "force sensor", fmt::format("reading the configuration {}: {}", where, what),
              "Open netftapi2.xml of the sensor in a browser and compare, or select its configuration again there.");
}

// The text of the one element of that name; empty when there is none and none is needed.
std::string only(const pugi::xml_document& document, const std::string& where, const char* name, bool required) {
  struct Finder final : pugi::xml_tree_walker {
    explicit Finder(std::string_view wanted) : name(wanted) {}
    bool for_each(pugi::xml_node& node) override {
      if (name == node.name()) {
        ++count;
        text = node.text().get();
      }
      return true;
    }
    std::string_view name;
    int count = 0;
    std::string text;
  } finder(name);
  pugi::xml_node root = document.document_element();
  root.traverse(finder);
  if (finder.count > 1) fail(where, fmt::format("{} is present more than once", name));
  constexpr const char* kSpaces = " \t\r\n";
  const auto begin = finder.text.find_first_not_of(kSpaces);
  if (begin != std::string::npos) {
    return finder.text.substr(begin, finder.text.find_last_not_of(kSpaces) - begin + 1);
  }
  if (required) fail(where, fmt::format("{} is {}", name, finder.count == 0 ? "missing" : "empty"));
  return "";
}

double above_zero(const std::string& where, const char* name, const std::string& text) {
  const auto value = finite_number(text);
  if (!value || !(*value > 0.0)) fail(where, fmt::format("{} is '{}', not a number above 0", name, text));
  return *value;
}

}  // namespace

double NetFtPage::newtons_per_count() const { return newtons_in(force_unit).value() / counts_per_force; }

double NetFtPage::newton_millimetres_per_count() const {
  return newton_millimetres_in(torque_unit).value() / counts_per_torque;
}

std::optional<std::array<double, 6>> NetFtPage::range_n_nmm() const {
  auto scaled = range;
  for (std::size_t i = 0; scaled && i < 6; ++i) {
    (*scaled)[i] *= i < 3 ? newtons_in(force_unit).value() : newton_millimetres_in(torque_unit).value();
  }
  return scaled;
}

NetFtPage parse_netft_page(std::string_view xml, const std::string& where) {
  if (xml.size() > kLargestDocument)
    fail(where, fmt::format("it has {} bytes, at most {}", xml.size(), kLargestDocument));
  pugi::xml_document document;
  const auto parsed = document.load_buffer(xml.data(), xml.size());
  if (!parsed) fail(where, fmt::format("it is not XML: {} at byte {}", parsed.description(), parsed.offset));
  const auto text = [&](const char* name, bool required) { return only(document, where, name, required); };

  NetFtPage page;
  page.product = text("prodname", true);
  page.counts_per_force = above_zero(where, "cfgcpf", text("cfgcpf", true));
  page.counts_per_torque = above_zero(where, "cfgcpt", text("cfgcpt", true));
  page.force_unit = text("scfgfu", true);
  if (!newtons_in(page.force_unit)) {
    fail(where, fmt::format("scfgfu '{}' is unknown; known: {}", page.force_unit, known_force_units()));
  }
  page.torque_unit = text("scfgtu", true);
  if (!newton_millimetres_in(page.torque_unit)) {
    fail(where, fmt::format("scfgtu '{}' is unknown; known: {}", page.torque_unit, known_torque_units()));
  }
  for (const double factor : {page.newtons_per_count(), page.newton_millimetres_per_count()}) {
    if (!std::isnormal(factor)) fail(where, "cfgcpf or cfgcpt is not a valid number of counts");
  }
  page.calibration_serial = text("cfgcalsn", false);
  page.box_serial = text("mfgdigsn", false);
  page.firmware = text("mfgdigver", false);
  if (const auto rate = text("comrdtrate", false); !rate.empty()) {
    page.records_per_second = above_zero(where, "comrdtrate", rate);
  }
  if (const auto ranges = text("cfgmr", false); !ranges.empty()) {
    page.range = six_numbers(ranges, ';');
    if (!page.range) fail(where, fmt::format("cfgmr '{}' are not six numbers", ranges));
    for (const double value : *page.range) {
      if (!(value > 0.0 && value < kLargestRange))
        fail(where, fmt::format("cfgmr '{}' holds an invalid range", ranges));
    }
  }
  return page;
}

std::string format_netft_page(const NetFtPage& page) {
  pugi::xml_document document;
  pugi::xml_node root = document.append_child("netft");
  const auto add = [&](const char* name, const std::string& text) {
    if (!text.empty()) root.append_child(name).text().set(text.c_str());
  };
  add("prodname", page.product);
  add("cfgcalsn", page.calibration_serial);
  add("scfgfu", page.force_unit);
  add("scfgtu", page.torque_unit);
  add("cfgcpf", fmt::format("{}", page.counts_per_force));  // shortest text that reads back the same
  add("cfgcpt", fmt::format("{}", page.counts_per_torque));
  if (page.range) add("cfgmr", fmt::format("{}", fmt::join(*page.range, ";")));
  add("comrdtrate", fmt::format("{}", page.records_per_second));
  add("mfgdigsn", page.box_serial);
  add("mfgdigver", page.firmware);
  std::ostringstream out;
  document.save(out, "", pugi::format_raw);
  return out.str();
}

}  // namespace tactbench::devices
