#include "devices/force/rdt_record.h"

#include <catch2/catch.hpp>
#include <limits>
#include <vector>

#include "devices/force/netft_xml.h"
#include "tests/devices/test_chamber.h"

using namespace tactbench::devices;
using Bytes = std::vector<std::uint8_t>;

namespace {

template <class Message>
Bytes bytes_of(const Message& message) {
  const auto bytes = encode(message);
  return {bytes.begin(), bytes.end()};
}

const char* const kPage =
    "<?xml version=\"1.0\"?><netft><prodname>Net F/T</prodname><cfgcalsn>FT99901</cfgcalsn><scfgfu>N</scfgfu>"
    "<scfgtu>Nm</scfgtu><cfgcpf>1000000</cfgcpf><cfgcpt> 1000000 </cfgcpt><cfgmr>12;12;17;0.12;0.12;0.12</cfgmr>"
    "<comrdtrate>7000</comrdtrate><mfgdigsn>B1</mfgdigsn><mfgdigver>2.2.59</mfgdigver></netft>";

std::string changed(const std::string& from, const std::string& to) {
  std::string text = kPage;
  REQUIRE(text.find(from) != std::string::npos);
  return text.replace(text.find(from), from.size(), to);
}

}  // namespace

TEST_CASE("RDT: requests are the manual's bytes") {
  CHECK(bytes_of(RdtRequest{RdtCommand::kStartRealtime, 0}) == Bytes{0x12, 0x34, 0, 2, 0, 0, 0, 0});
  CHECK(bytes_of(RdtRequest{RdtCommand::kStop, 0}) == Bytes{0x12, 0x34, 0, 0, 0, 0, 0, 0});
  CHECK(bytes_of(RdtRequest{RdtCommand::kSetBias, 0}) == Bytes{0x12, 0x34, 0, 0x42, 0, 0, 0, 0});
  CHECK(bytes_of(RdtRequest{RdtCommand::kResetLatch, 0}) == Bytes{0x12, 0x34, 0, 0x41, 0, 0, 0, 0});
  CHECK(bytes_of(RdtRequest{RdtCommand::kStartBuffered, 0x01020304}) == Bytes{0x12, 0x34, 0, 3, 1, 2, 3, 4});
  CHECK(decode_rdt_request(Bytes{0x12, 0x34, 0, 4, 0, 0, 0, 5}) == RdtRequest{RdtCommand::kStartMultiUnit, 5});
}

TEST_CASE("RDT: other bytes are not decoded as a request") {
  CHECK_FALSE(decode_rdt_request(Bytes{0x12, 0x34, 0, 2, 0, 0, 0}));
  CHECK_FALSE(decode_rdt_request(Bytes{0x12, 0x34, 0, 2, 0, 0, 0, 0, 0}));
  CHECK_FALSE(decode_rdt_request(Bytes{0x34, 0x12, 0, 2, 0, 0, 0, 0}));
  CHECK_FALSE(decode_rdt_request(Bytes{0x12, 0x34, 0, 1, 0, 0, 0, 0}));
  CHECK_FALSE(decode_rdt_request(Bytes{}));
}

TEST_CASE("RDT: a record's bytes and values") {
  const Bytes bytes{0x00, 0x00, 0x00, 0x07, 0x01, 0x02, 0x03, 0x04, 0x80, 0x02, 0x00, 0x00,
                    0x00, 0x0F, 0x42, 0x40, 0xFF, 0xF0, 0xBD, 0xC0, 0x7F, 0xFF, 0xFF, 0xFF,
                    0x80, 0x00, 0x00, 0x00, 0xFF, 0xFF, 0xFF, 0xFF, 0x00, 0x00, 0x00, 0x01};
  const auto record = decode_rdt_record(bytes);
  REQUIRE(record);
  CHECK(record->rdt_sequence == 7);
  CHECK(record->ft_sequence == 0x01020304);
  CHECK(record->status == 0x80020000);
  constexpr auto kLow = std::numeric_limits<std::int32_t>::min();
  constexpr auto kHigh = std::numeric_limits<std::int32_t>::max();
  CHECK(record->counts == std::array<std::int32_t, 6>{1'000'000, -1'000'000, kHigh, kLow, -1, 1});
  CHECK(bytes_of(*record) == bytes);
  CHECK_FALSE(decode_rdt_record(std::span(bytes).first(35)));
  CHECK_FALSE(decode_rdt_record(Bytes(72)));
}

TEST_CASE("RDT: status bits are named, a tripped monitor is not an error") {
  CHECK(rdt_status_text(0) == "healthy");
  CHECK(rdt_status_text(0x80020000) == "error summary, saturation or A/D error");
  CHECK(rdt_status_text(0x80010000) == "error summary, monitor condition latched");
  CHECK(rdt_status_text(0x00008001) == "bit 15, bit 0");
  CHECK_FALSE(rdt_status_is_error(0));
  CHECK_FALSE(rdt_status_is_error(0x80010000));
  CHECK(rdt_status_is_error(0x80000000));
  CHECK(rdt_status_is_error(0x80020000));
  CHECK(rdt_status_is_error(0x80030000));
  CHECK(rdt_status_is_error(0x00000004));
}

TEST_CASE("RDT: every bit of the status has its name, and only the monitor's and the summary's are no errors") {
  const std::array<const char*, 32> names{"bit 0",
                                          "HTTP",
                                          "temperature",
                                          "reference voltage",
                                          "link data",
                                          "supply low",
                                          "supply high",
                                          "ground",
                                          "excitation low",
                                          "excitation high",
                                          "analog watchdog",
                                          "flash memory",
                                          "EEPROM",
                                          "stack",
                                          "watchdog",
                                          "bit 15",
                                          "monitor condition latched",
                                          "saturation or A/D error",
                                          "DeviceNet",
                                          "EtherNet/IP",
                                          "RDT",
                                          "CAN",
                                          "network",
                                          "configuration against calibration",
                                          "settings",
                                          "halted by configuration",
                                          "program memory",
                                          "serial link",
                                          "analog board",
                                          "digital board",
                                          "CPU or RAM",
                                          "error summary"};
  std::string all;
  for (std::size_t bit = 32; bit-- > 0;) {
    const std::uint32_t status = 1U << bit;
    CHECK(rdt_status_text(status) == names[bit]);
    CHECK(rdt_status_is_error(status) == (bit != 16));  // the summary alone is an error that no bit names
    CHECK(rdt_status_is_error(status | 0x80010000U) == (bit != 16 && bit != 31));
    all += (all.empty() ? "" : ", ") + std::string(names[bit]);
  }
  CHECK(rdt_status_text(0xFFFFFFFF) == all);
}

TEST_CASE("RDT: each command has its number, and numbers beside them are none") {
  for (unsigned number = 0; number < 0x100; ++number) {
    const auto request = decode_rdt_request(Bytes{0x12, 0x34, 0, static_cast<std::uint8_t>(number), 9, 8, 7, 6});
    CHECK(request.has_value() == (number == 0 || (number >= 2 && number <= 4) || number == 0x41 || number == 0x42));
    if (request) CHECK((static_cast<unsigned>(request->command) == number && request->count == 0x09080706));
    CHECK_FALSE(decode_rdt_request(Bytes{0x12, 0x34, 1, static_cast<std::uint8_t>(number), 0, 0, 0, 0}));
  }
}

TEST_CASE("Net F/T page: every field, anywhere below the root") {
  const auto page = parse_netft_page(kPage, "page");
  CHECK(page.product == "Net F/T");
  CHECK(page.calibration_serial == "FT99901");
  CHECK(page.firmware == "2.2.59");
  CHECK(page.box_serial == "B1");
  CHECK(page.newtons_per_count() == Approx(1e-6));
  CHECK(page.newton_millimetres_per_count() == Approx(1e-3));
  CHECK(page.range_n_nmm() == std::array<double, 6>{12, 12, 17, 120, 120, 120});
  CHECK(page.records_per_second == 7000.0);
  CHECK(parse_netft_page(format_netft_page(page), "page") == page);
  const auto nested = parse_netft_page(changed("<scfgfu>N</scfgfu>", "<units><scfgfu>lbf</scfgfu></units>"), "page");
  CHECK(nested.newtons_per_count() == Approx(4.4482216152605e-6));
  auto little = changed("<cfgmr>12;12;17;0.12;0.12;0.12</cfgmr><comrdtrate>7000</comrdtrate>", "");
  CHECK_FALSE(parse_netft_page(little, "page").range);
}

TEST_CASE("Net F/T page: missing, duplicate and invalid elements are reported") {
  using Catch::Contains;
  const auto complaint = [](const std::string& text) {
    const auto fault = fault_of([&] { (void)parse_netft_page(text, "http://sensor/netftapi2.xml"); });
    REQUIRE(fault);
    CHECK(fault->id() == "TB-FORCE-CALIBRATION");
    CHECK_THAT(fault->what(), Contains("http://sensor/netftapi2.xml"));
    return std::string(fault->what());
  };
  CHECK_THAT(complaint(""), Contains("not XML"));
  CHECK_THAT(complaint("<netft>"), Contains("not XML"));
  CHECK_THAT(complaint("<netft/>"), Contains("prodname is missing"));
  CHECK_THAT(complaint(changed("<cfgcpf>1000000</cfgcpf>", "")), Contains("cfgcpf is missing"));
  CHECK_THAT(complaint(changed("1000000</cfgcpf>", "</cfgcpf>")), Contains("cfgcpf is empty"));
  CHECK_THAT(complaint(changed("<cfgcpf>", "<cfgcpf>1</cfgcpf><cfgcpf>")),
             Contains("cfgcpf is present more than once"));
  CHECK_THAT(complaint(changed("1000000</cfgcpf>", "0</cfgcpf>")), Contains("cfgcpf is '0'"));
  CHECK_THAT(complaint(changed("1000000</cfgcpf>", "1e6x</cfgcpf>")), Contains("1e6x"));
  CHECK_THAT(complaint(changed("1000000</cfgcpf>", "1e-310</cfgcpf>")), Contains("cfgcpf"));
  CHECK_THAT(complaint(changed(">Nm<", ">N<")), Contains("scfgtu 'N'") && Contains("Nmm"));
  CHECK_THAT(complaint(changed("12;12;17;", "12;17;")), Contains("not six numbers"));
  CHECK_THAT(complaint(changed("12;12;17;", "12;0;17;")), Contains("invalid range"));
  CHECK_THAT(complaint(changed(">7000<", ">fast<")), Contains("comrdtrate"));
  CHECK_THAT(complaint(std::string(300'000, ' ')), Contains("300000 bytes"));
}
