#include <catch2/catch.hpp>
#include <limits>
#include <map>
#include <vector>

#include "devices/force/netft_xml.h"
#include "devices/force/rdt_record.h"
#include "tests/devices/check_codec.h"
#include "tests/devices/fault_of.h"

using namespace tactbench::devices;
using Bytes = std::vector<std::uint8_t>;

namespace {

template <class Message>
Bytes bytes_of(const Message& message) {
  const auto bytes = encode(message);
  return {bytes.begin(), bytes.end()};
}

}  // namespace

TEST_CASE("RDT: requests encode to and decode from the manual's bytes") {
  for (const auto& [request, bytes] : std::vector<std::pair<RdtRequest, Bytes>>{
           {{RdtCommand::kStartRealtime, 0}, {0x12, 0x34, 0, 2, 0, 0, 0, 0}},
           {{RdtCommand::kStop, 0}, {0x12, 0x34, 0, 0, 0, 0, 0, 0}},
           {{RdtCommand::kSetBias, 0}, {0x12, 0x34, 0, 0x42, 0, 0, 0, 0}},
           {{RdtCommand::kResetLatch, 0}, {0x12, 0x34, 0, 0x41, 0, 0, 0, 0}},
           {{RdtCommand::kStartBuffered, 0x01020304}, {0x12, 0x34, 0, 3, 1, 2, 3, 4}},
           {{RdtCommand::kStartMultiUnit, 5}, {0x12, 0x34, 0, 4, 0, 0, 0, 5}}})
    check_codec(bytes, request, bytes_of<RdtRequest>, [](const Bytes& one) { return decode_rdt_request(one); });
}

TEST_CASE("RDT: bytes of another length, header or command do not decode as a request") {
  CHECK_FALSE(decode_rdt_request(Bytes{0x12, 0x34, 0, 2, 0, 0, 0}));
  CHECK_FALSE(decode_rdt_request(Bytes{0x12, 0x34, 0, 2, 0, 0, 0, 0, 0}));
  CHECK_FALSE(decode_rdt_request(Bytes{0x34, 0x12, 0, 2, 0, 0, 0, 0}));
  CHECK_FALSE(decode_rdt_request(Bytes{0x12, 0x34, 0, 1, 0, 0, 0, 0}));
  CHECK_FALSE(decode_rdt_request(Bytes{}));
}

TEST_CASE("RDT: a record encodes to its bytes and decodes to its values") {
  const Bytes bytes{0x00, 0x00, 0x00, 0x07, 0x01, 0x02, 0x03, 0x04, 0x80, 0x02, 0x00, 0x00,
                    0x00, 0x0F, 0x42, 0x40, 0xFF, 0xF0, 0xBD, 0xC0, 0x7F, 0xFF, 0xFF, 0xFF,
                    0x80, 0x00, 0x00, 0x00, 0xFF, 0xFF, 0xFF, 0xFF, 0x00, 0x00, 0x00, 0x01};
  constexpr auto kLow = std::numeric_limits<std::int32_t>::min();
  constexpr auto kHigh = std::numeric_limits<std::int32_t>::max();
  const RdtRecord record{7, 0x01020304, 0x80020000, {1'000'000, -1'000'000, kHigh, kLow, -1, 1}};
  check_codec(bytes, record, bytes_of<RdtRecord>, [](const Bytes& one) { return decode_rdt_record(one); });
  CHECK_FALSE(decode_rdt_record(std::span(bytes).first(35)));
  CHECK_FALSE(decode_rdt_record(Bytes(72)));
}

TEST_CASE("RDT: every status bit is an error, except the tripped monitor with its summary bit") {
  CHECK_FALSE(rdt_status_is_error(0));
  CHECK_FALSE(rdt_status_is_error(0x80010000));
  for (std::size_t bit = 0; bit < 32; ++bit) {
    INFO("bit " << bit);
    const std::uint32_t status = 1U << bit;
    CHECK(rdt_status_is_error(status) == (bit != 16));  // the summary alone is an error that no bit names
    CHECK(rdt_status_is_error(status | 0x80010000U) == (bit != 16 && bit != 31));
    CHECK((rdt_status_text(status) != "bit " + std::to_string(bit)) ==
          (bit != 0 && bit != 15));  // these two are reserved
  }
  CHECK(rdt_status_text(0x00008001) == "bit 15, bit 0");
  CHECK(rdt_status_text(0x00000020) == "supply low");
  CHECK(rdt_status_text(0x00000040) == "supply high");
}

TEST_CASE("RDT: only the numbers of the six commands decode as a request") {
  for (unsigned number = 0; number < 0x100; ++number) {
    const auto request = decode_rdt_request(Bytes{0x12, 0x34, 0, static_cast<std::uint8_t>(number), 9, 8, 7, 6});
    CHECK(request.has_value() == (number == 0 || (number >= 2 && number <= 4) || number == 0x41 || number == 0x42));
    if (request) CHECK((static_cast<unsigned>(request->command) == number && request->count == 0x09080706));
    CHECK_FALSE(decode_rdt_request(Bytes{0x12, 0x34, 1, static_cast<std::uint8_t>(number), 0, 0, 0, 0}));
  }
}

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

// The subject of the refusal; empty: there is none.
void check_page(const std::string& text, const std::string& about) {
  INFO(text);
  const auto read = [&] { (void)parse_netft_page(text, "P"); };
  if (about.empty()) CHECK_NOTHROW(read());
  if (!about.empty()) check_fault(read, "TB-FORCE-CALIBRATION", "force sensor", about);
}

void check_page_with(const std::string& name, const std::string& value, const std::string& about) {
  Elements elements = all_elements();
  elements[name] = value;
  check_page(page_of(elements), about);
}

}  // namespace

TEST_CASE("Net F/T XML: each element is read separately, without surrounding white space") {
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

TEST_CASE("Net F/T XML: refuses a missing required element or a duplicate, and accepts a missing optional one") {
  for (const auto& [name, value] : all_elements()) {
    INFO(name);
    const bool required =
        name == "prodname" || name == "scfgfu" || name == "scfgtu" || name == "cfgcpf" || name == "cfgcpt";
    Elements elements = all_elements();
    elements.erase(name);
    check_page(page_of(elements), required ? name : "");
    for (const char* nothing : {"", " \n"}) check_page_with(name, nothing, required ? name : "");
    std::string twice = page_of(all_elements());
    twice.insert(7, "<deep><er><" + name + ">" + value + "</" + name + "></er></deep>");
    check_page(twice, name);
  }
  Elements few = all_elements();
  for (const char* name : {"cfgcalsn", "cfgmr", "comrdtrate", "mfgdigsn", "mfgdigver"}) few.erase(name);
  const NetFtPage page = parsed(few);
  CHECK((page.calibration_serial.empty() && page.box_serial.empty() && page.firmware.empty() && !page.range));
  CHECK(page.records_per_second == NetFtPage().records_per_second);
}

TEST_CASE("Net F/T XML: counts, rates and ranges must be numbers above 0") {
  for (const std::string name : {"cfgcpf", "cfgcpt", "comrdtrate"}) {
    for (const std::string bad : {"0", "-0.5", "nan", "x", "1 2"}) check_page_with(name, bad, name);
    for (const std::string good : {"0.5", "1"}) check_page_with(name, good, "");
  }
  for (const std::string name : {"cfgcpf", "cfgcpt"}) {
    for (const std::string extreme : {"1e-310", "1.7e308"}) {
      Elements elements = all_elements();
      elements["scfgfu"] = "N";
      elements["scfgtu"] = "Nmm";
      elements[name] = extreme;
      check_page(page_of(elements), "cfgcp");
    }
  }
  for (std::size_t at = 0; at < 6; ++at) {
    const auto check_range = [&](const std::string& value, const std::string& about) {
      std::string range;
      for (std::size_t i = 0; i < 6; ++i) range += (i == 0 ? "" : ";") + (i == at ? value : std::string("7"));
      check_page_with("cfgmr", range, about);
    };
    for (const char* good : {"0.5", "1e-9", "999999999"}) check_range(good, "");
    for (const char* bad : {"0", "-1", "1e9", "1e300", "x"}) check_range(bad, "cfgmr");
  }
}

TEST_CASE("Net F/T XML: refuses unsupported units, oversized pages and text that is not XML") {
  check_page_with("scfgfu", "stone", "scfgfu");
  check_page_with("scfgtu", "N", "scfgtu");
  check_page(std::string(262'145, ' '), "262145");
  for (const char* text : {"", "<netft>", "<netft></nett>"}) check_page(text, "XML");
}
