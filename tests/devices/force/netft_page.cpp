// The page of a Net F/T element by element: each that has to be there, once, with a text that it can have.
#include <catch2/catch.hpp>
#include <map>

#include "devices/force/netft_xml.h"
#include "tests/devices/fault_of.h"

using namespace tactbench::devices;

namespace {

using Elements = std::map<std::string, std::string>;

Elements all_elements() {
  return {{"prodname", "Net F/T"}, {"cfgcalsn", "FT9"}, {"scfgfu", "lbf"},        {"scfgtu", "lbf-in"},
          {"cfgcpf", "2000"},      {"cfgcpt", "4000"},  {"cfgmr", "1;2;3;4;5;6"}, {"comrdtrate", "125"},
          {"mfgdigsn", "B1"},      {"mfgdigver", "2.2"}};
}

std::string page_of(const Elements& elements) {
  std::string text = "<netft>";
  for (const auto& [name, value] : elements) text += "<" + name + ">" + value + "</" + name + ">";
  return text + "</netft>";
}

NetFtPage parsed(const Elements& elements) { return parse_netft_page(page_of(elements), "P"); }

// The complaint behind "reading the configuration P: ".
std::string complaint_about(const std::string& text) {
  const auto fault = fault_of([&] { (void)parse_netft_page(text, "P"); });
  if (!fault) return "";
  CHECK((fault->id() == "TB-FORCE-CALIBRATION" && fault->device() == "force sensor"));
  const std::string what = fault->what(), front = "reading the configuration P: ";
  REQUIRE(what.starts_with(front));
  return what.substr(front.size());
}
std::string complaint_with(const std::string& name, const std::string& value) {
  Elements elements = all_elements();
  elements[name] = value;
  return complaint_about(page_of(elements));
}

}  // namespace

TEST_CASE("Net F/T page told: each element is read for itself, without the blanks around it") {
  for (const char* blank : {"", " ", "\t", "\n", "\r\n  \t"}) {
    Elements elements = all_elements();
    for (auto& [name, value] : elements) value = blank + value + blank;
    const NetFtPage page = parsed(elements);
    CHECK((page.product == "Net F/T" && page.calibration_serial == "FT9" && page.box_serial == "B1"));
    CHECK((page.firmware == "2.2" && page.force_unit == "lbf" && page.torque_unit == "lbf-in"));
    CHECK((page.counts_per_force == 2000.0 && page.counts_per_torque == 4000.0 && page.records_per_second == 125.0));
    CHECK(page.range == std::array<double, 6>{1, 2, 3, 4, 5, 6});
    CHECK(parse_netft_page(format_netft_page(page), "P") == page);
  }
  Elements inner = all_elements();
  inner["prodname"] = " a  b ";
  CHECK(parsed(inner).product == "a  b");
}

TEST_CASE("Net F/T page told: what has to be there is missed, what need not be is not") {
  for (const auto& [name, value] : all_elements()) {
    INFO(name);
    const bool required =
        name == "prodname" || name == "scfgfu" || name == "scfgtu" || name == "cfgcpf" || name == "cfgcpt";
    Elements elements = all_elements();
    elements.erase(name);
    CHECK(complaint_about(page_of(elements)) == (required ? name + " is missing" : ""));
    for (const char* nothing : {"", " \n"})
      CHECK(complaint_with(name, nothing) == (required ? name + " is empty" : ""));
    std::string twice = page_of(all_elements());
    twice.insert(7, "<deep><er><" + name + ">" + value + "</" + name + "></er></deep>");
    CHECK(complaint_about(twice) == name + " is present more than once");
  }
  Elements few = all_elements();
  for (const char* name : {"cfgcalsn", "cfgmr", "comrdtrate", "mfgdigsn", "mfgdigver"}) few.erase(name);
  const NetFtPage page = parsed(few);
  CHECK((page.calibration_serial.empty() && page.box_serial.empty() && page.firmware.empty() && !page.range));
  CHECK(page.records_per_second == NetFtPage().records_per_second);
}

TEST_CASE("Net F/T page told: counts, rates and ranges are numbers above 0") {
  for (const std::string name : {"cfgcpf", "cfgcpt", "comrdtrate"}) {
    for (const std::string bad : {"0", "-0.5", "nan", "x", "1 2"})
      CHECK(complaint_with(name, bad) == name + " is '" + bad + "', not a number above 0");
    CHECK(complaint_with(name, "0.5").empty());
    CHECK(complaint_with(name, "1").empty());
  }
  for (const std::string name : {"cfgcpf", "cfgcpt"}) {
    for (const std::string extreme : {"1e-310", "1.7e308"}) {
      Elements elements = all_elements();
      elements["scfgfu"] = "N";
      elements["scfgtu"] = "Nmm";
      elements[name] = extreme;
      CHECK(complaint_about(page_of(elements)) == "cfgcpf or cfgcpt is not a valid number of counts");
    }
  }
  for (std::size_t at = 0; at < 6; ++at) {
    const auto with = [&](const std::string& value) {
      std::string range;
      for (std::size_t i = 0; i < 6; ++i) range += (i == 0 ? "" : ";") + (i == at ? value : std::string("7"));
      return std::pair{range, complaint_with("cfgmr", range)};
    };
    for (const char* good : {"0.5", "1e-9", "999999999"}) CHECK(with(good).second.empty());
    for (const char* bad : {"0", "-1", "1e9", "1e300"}) {
      const auto [range, complaint] = with(bad);
      CHECK(complaint == "cfgmr '" + range + "' holds an invalid range");
    }
    const auto [range, complaint] = with("x");
    CHECK(complaint == "cfgmr '" + range + "' are not six numbers");
  }
}

TEST_CASE("Net F/T page told: units that it can have, and pages that are none") {
  CHECK(complaint_with("scfgfu", "stone") == "scfgfu 'stone' is unknown; known: N, kN, lbf, lb, klbf, klb, kg, kgf, g");
  CHECK(complaint_with("scfgtu", "N") ==
        "scfgtu 'N' is unknown; known: N-mm, Nmm, N-m, Nm, kN-m, kNm, lbf-in, lb-in, in-lbf, in-lb, lbf-ft, lb-ft, "
        "ft-lbf, ft-lb, kg-cm, kgcm");
  CHECK(complaint_about(std::string(262'145, ' ')) == "it has 262145 bytes, at most 262144");
  CHECK_THAT(complaint_about("<netft></nett>"), Catch::StartsWith("it is not XML: ") && Catch::EndsWith(" at byte 9"));
}
