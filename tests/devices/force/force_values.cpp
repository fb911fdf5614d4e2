// Units, ranges and records of force at their edges, each by its definition.

#include <catch2/catch.hpp>

#include <cmath>
#include <fstream>
#include <limits>
#include <map>
#include <vector>

#include "devices/force/ati_calibration.h"
#include "devices/force/ati_matrix.h"
#include "devices/force/digital_record.h"
#include "devices/force/force_checks.h"
#include "devices/force/netft_xml.h"
#include "devices/force/rdt_record.h"
#include "tests/devices/check_codec.h"
#include "tests/devices/fault_of.h"
#include "tests/devices/force/invented_calibration.h"
#include "tests/devices/force/scripted_digital.h"
#include "tests/devices/test_chamber.h"

using namespace tactbench::devices;

using Bytes = std::vector<std::uint8_t>;

namespace {

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  REQUIRE(text.find(from) != std::string::npos);
  return text.replace(text.find(from), from.size(), to);
}

Vector6 unit_vector(int i) { return Vector6::Unit(i); }

}  // namespace

TEST_CASE("force units: units of force, torque, length and angle convert by their definitions") {
  // 1 lbf = 0.45359237 kg x 9.80665 m/s^2 = 4.4482216152605 N, 1 in = 25.4 mm, 1 ft = 12 in (NIST SP 811, exact).
  const double pound = 4.4482216152605, kilogram = 9.80665;
  for (const auto& [name, value] : std::vector<std::pair<const char*, double>>{{"N", 1},
                                                                               {"kN", 1000},
                                                                               {"lbf", pound},
                                                                               {"lb", pound},
                                                                               {"klbf", 1000 * pound},
                                                                               {"klb", 1000 * pound},
                                                                               {"kg", kilogram},
                                                                               {"kgf", kilogram},
                                                                               {"g", 0.00980665}}) {
    INFO(name);
    REQUIRE(newtons_in(name));
    CHECK(*newtons_in(name) == Approx(value).epsilon(1e-14));
  }
  const double inches = 112.98482902761668, feet = 1355.8179483314002;  // of a pound, in N*mm
  for (const auto& [name, value] : std::vector<std::pair<const char*, double>>{{"N-mm", 1},
                                                                               {"Nmm", 1},
                                                                               {"N-m", 1000},
                                                                               {"Nm", 1000},
                                                                               {"kN-m", 1e6},
                                                                               {"kNm", 1e6},
                                                                               {"lbf-in", inches},
                                                                               {"lb-in", inches},
                                                                               {"in-lbf", inches},
                                                                               {"in-lb", inches},
                                                                               {"lbf-ft", feet},
                                                                               {"lb-ft", feet},
                                                                               {"ft-lbf", feet},
                                                                               {"ft-lb", feet},
                                                                               {"kg-cm", 98.0665},
                                                                               {"kgcm", 98.0665}}) {
    INFO(name);
    REQUIRE(newton_millimetres_in(name));
    CHECK(*newton_millimetres_in(name) == Approx(value).epsilon(1e-14));
  }
  for (const auto& [name, value] :
       std::vector<std::pair<const char*, double>>{{"mm", 1}, {"cm", 10}, {"m", 1000}, {"in", 25.4}, {"ft", 304.8}}) {
    INFO(name);
    REQUIRE(millimetres_in(name));
    CHECK(*millimetres_in(name) == Approx(value).epsilon(1e-14));
  }
  for (const char* name : {"degrees", "degree", "deg"}) CHECK(degrees_in(name) == 1.0);
  for (const char* name : {"radians", "radian", "rad"})
    CHECK(*degrees_in(name) == Approx(57.29577951308232).epsilon(1e-14));
  CHECK(
      (!newtons_in("n") && !newtons_in("") && !newton_millimetres_in("N") && !millimetres_in("N") && !degrees_in("N")));
}

TEST_CASE("six_numbers: accepts six numbers separated by white space or the separator, and nothing else") {
  const std::array<double, 6> values{1, -2.5, 3, 40, 5, 6};
  CHECK(six_numbers("1 -2.5 3 40 5 6") == values);
  CHECK(six_numbers("\t1 -2.5\n3 40\r5 +6 ") == values);
  CHECK(six_numbers("1;-2.5;3;40;5;6;", ';') == values);
  CHECK(six_numbers(";1;-2.5; 3;40;5;6", ';') == values);
  for (const char* none : {"1;-2.5;3;40;5;6", "1 -2.5 3 40 5", "1 -2.5 3 40 5 6 7", "1 -2.5 x 40 5 6", ""})
    CHECK_FALSE(six_numbers(none));
  CHECK(finite_number("+5") == 5.0);
  CHECK(finite_number("7") == 7.0);
  CHECK(finite_number("\r\n -1e3\t ") == -1000.0);
}

TEST_CASE("ATI calibration: accepts up to 1 MiB, from a file or from memory") {
  constexpr std::size_t kMebibyte = 1'048'576;
  std::string text = InventedCalibration().text();
  text.resize(kMebibyte, ' ');
  CHECK_NOTHROW(parse_ati_calibration(text, "t"));
  const TemporaryFolder folder;
  const std::string path = folder.path("t.cal");
  std::ofstream(path) << text;
  CHECK(read_ati_calibration(path).serial == "FT99901");
  std::ofstream(path) << text << "     ";
  // No more is read than shows that it is too much.
  check_fault([&] { (void)read_ati_calibration(path); }, "TB-FORCE-CALIBRATION", {}, "1048577");
}

TEST_CASE("ATI calibration: without a transform the matrix is the scaled rows, and angles may be in radians") {
  InventedCalibration invented;
  invented.basic = "";
  invented.distance_unit = "furlong";  // nobody asks for it
  const Matrix6 bare = working_matrix(parse_ati_calibration(invented.text(), "t"));
  for (int row = 0; row < 6; ++row) {
    for (int gauge = 0; gauge < 6; ++gauge) {
      const auto r = static_cast<std::size_t>(row), g = static_cast<std::size_t>(gauge);
      CHECK((bare * unit_vector(gauge))[row] == Approx(invented.rows[r][g] / invented.scale[r]).epsilon(1e-14));
    }
  }
  invented.distance_unit = "mm";
  const auto transform_of = [&](const std::string& unit, const std::string& angles) {
    invented.basic = "<BasicTransform Dx=\"1\" Dy=\"2\" Dz=\"3\" " + angles + "/>";
    return parse_ati_calibration(replaced(invented.text(), "DistUnits", unit + " DistUnits"), "t").basic;
  };
  const auto degrees = transform_of("", R"(Rx="90" Ry="180" Rz="-45")");
  CHECK(degrees.displacement_mm == std::array<double, 3>{1, 2, 3});
  CHECK(degrees.rotation_deg == std::array<double, 3>{90, 180, -45});
  const auto radians = transform_of("AngleUnits=\"radians\"",
                                    R"(Rx="1.5707963267948966" Ry="3.141592653589793" Rz="-0.7853981633974483")");
  for (std::size_t i = 0; i < 3; ++i) CHECK(radians.rotation_deg[i] == Approx(degrees.rotation_deg[i]).epsilon(1e-14));
}

TEST_CASE("overload: only values beyond the range count, and the fault states axis and value") {
  const SixAxes range{10, 20, 30, 100, 200, 300};
  constexpr std::array<const char*, 6> kAxes{"Fx", "Fy", "Fz", "Tx", "Ty", "Tz"};
  for (std::size_t axis = 0; axis < 6; ++axis) {
    for (const double sign : {1.0, -1.0}) {
      SixAxes load{};
      load[axis] = sign * 0.5 * range[axis];
      CHECK(fault_id_of([&] { check_overload(wrench_of(load), range, 0.5); }) == "none");
      load[axis] = std::nextafter(load[axis], sign * HUGE_VAL);
      check_fault([&] { check_overload(wrench_of(load), range, 0.5); }, "TB-FORCE-OVERLOAD", {}, kAxes[axis]);
    }
  }
  CHECK(fault_id_of([&] { check_overload({{std::nan(""), 0, 0}, {}}, range, 1.0); }) == "TB-FORCE-OVERLOAD");
  for (const char* excess : {"11 N", "-301 N*mm"})
    check_fault([&] { check_overload({{11, 0, 0}, {0, 0, -301}}, range, 1.0); }, "TB-FORCE-OVERLOAD", {}, excess);
}

TEST_CASE("force spread: is the standard deviation of the force axis with the largest one, whatever the mean") {
  ForceSpread spread;
  CHECK(spread.standard_deviation_n() == 0.0);
  for (const double z : {2.0, 4.0, 4.0, 4.0, 5.0, 5.0, 7.0, 9.0}) {  // deviations from 5: squares sum up to 32
    spread.add({{1e6, 0.5 * z, -1000.0 + z}, {100.0 * z, 0, 0}});
    if (z == 2.0) CHECK(spread.standard_deviation_n() == 0.0);
  }
  CHECK(spread.standard_deviation_n() == Approx(std::sqrt(32.0 / 7.0)));
}

TEST_CASE("force values: wrenches subtract per component, and record counts and serial numbers are checked") {
  const Wrench left = Wrench{{1, 2, 3}, {4, 5, 6}} - Wrench{{10, 200, 3000}, {40, 500, 6000}};
  CHECK(left.force_n == std::array<double, 3>{-9, -198, -2997});
  CHECK(left.torque_nmm == std::array<double, 3>{-36, -495, -5994});
  const auto asked = [](int records) { return fault_id_of([&] { check_records(records); }); };
  CHECK((asked(1) == "none" && asked(100'000) == "none"));
  CHECK((asked(0) == "TB-FORCE-RECORDS" && asked(-1) == "TB-FORCE-RECORDS" && asked(100'001) == "TB-FORCE-RECORDS"));
  const auto serial = [](const char* wanted, const char* found) {
    return fault_id_of([&] { check_serial(wanted, found, "x"); });
  };
  CHECK((serial("", "A") == "none" && serial("A", "A") == "none" && serial("A", "B") == "TB-FORCE-SERIAL"));
}

TEST_CASE("Digital F/T: text is cut to its field, and calibration numbers out of range are refused") {
  DigitalCalibration calibration = invented_digital();
  calibration.serial = "12345678";
  calibration.part_number = std::string(32, 'p');
  calibration.date = std::string(20, 'd');
  CHECK(decode_digital_calibration(encode(calibration)) == calibration);
  DigitalCalibration longer = calibration;
  longer.serial += "9";
  longer.part_number += "P";
  longer.date += "D";
  CHECK(encode(longer) == encode(calibration));
  const auto refused = [&](auto change) {
    DigitalCalibration wrong = invented_digital();
    change(wrong);
    return fault_id_of([&] { (void)decode_digital_calibration(encode(wrong)); }) == "TB-FORCE-CALIBRATION";
  };
  for (const std::size_t i : {0U, 5U}) {
    CHECK(refused([&](DigitalCalibration& c) { c.range[i] = 1e6F; }));
    CHECK(refused([&](DigitalCalibration& c) { c.range[i] = -1.0F; }));
    CHECK(refused([&](DigitalCalibration& c) { c.matrix[i][i] = std::numeric_limits<float>::infinity(); }));
    CHECK_FALSE(refused([&](DigitalCalibration& c) { c.range[i] = 999'999.0F; }));
    CHECK_FALSE(refused([&](DigitalCalibration& c) { c.range[i] = 0.001F; }));
  }
  CHECK(refused([](DigitalCalibration& c) { c.counts_per_force = 0; }));
  CHECK(refused([](DigitalCalibration& c) { c.counts_per_torque = 0; }));
  CHECK_FALSE(refused([](DigitalCalibration& c) { c.counts_per_force = c.counts_per_torque = 1; }));
  CHECK(refused([](DigitalCalibration& c) { c.counts_per_torque = -1; }));
  CHECK(refused([](DigitalCalibration& c) { c.range[5] = 0.0F; }));
  CHECK(refused([](DigitalCalibration& c) { c.matrix[2][3] = std::numeric_limits<float>::quiet_NaN(); }));
  for (const auto unit : {1, 3})
    CHECK(refused([&](DigitalCalibration& c) { c.force_unit = static_cast<decltype(c.force_unit)>(unit); }));
  CHECK(refused([](DigitalCalibration& c) { c.torque_unit = 2; }));
  // A frame is a body and two bytes of check sum.
  CHECK(rtu_frame_is_whole(rtu_frame(Bytes{1, 2})));
  CHECK_FALSE(rtu_frame_is_whole(rtu_frame(Bytes{1})));
}

TEST_CASE("Net F/T XML: accepts up to 262144 bytes and ranges below 1e9, and writes no empty element") {
  NetFtPage page;
  page.product = "p";
  page.range = SixAxes{1, 2, 3, 4, 5, 999'999'999};
  std::string text = format_netft_page(page);
  for (const char* absent : {"cfgcalsn", "mfgdigsn", "mfgdigver"}) CHECK(text.find(absent) == std::string::npos);
  CHECK(parse_netft_page(text, "page") == page);
  text.resize(262'144, ' ');
  CHECK(parse_netft_page(text, "page") == page);
  CHECK(fault_id_of([&] { (void)parse_netft_page(text + " ", "page"); }) == "TB-FORCE-CALIBRATION");
  page.range = SixAxes{1, 2, 3, 4, 5, 1e9};
  CHECK(fault_id_of([&] { (void)parse_netft_page(format_netft_page(page), "page"); }) == "TB-FORCE-CALIBRATION");
  page.range.reset();
  CHECK_FALSE(page.range_n_nmm());
  page.range = SixAxes{1, 2, 3, 4, 5, 6};
  page.force_unit = "kN";
  page.torque_unit = "kNm";
  page.counts_per_force = 2000;
  page.counts_per_torque = 4'000'000;
  CHECK(page.newtons_per_count() == 0.5);
  CHECK(page.newton_millimetres_per_count() == 0.25);
  CHECK(page.range_n_nmm() == SixAxes{1e3, 2e3, 3e3, 4e6, 5e6, 6e6});
}

TEST_CASE("Digital F/T: the start request and Modbus frames have the published bytes") {
  CHECK(digital_start_stream(10) == Bytes{0x0A, 0x46, 0x55, 0xA3, 0x9D});
  // The example of the Modbus specification's annex on RTU reads: unit 17, registers 0x6B to 0x6D.
  CHECK(rtu_read_holding(0x11, 0x006B, 3) == Bytes{0x11, 0x03, 0x00, 0x6B, 0x00, 0x03, 0x76, 0x87});
  CHECK(rtu_frame_is_whole(Bytes{0x11, 0x03, 0x00, 0x6B, 0x00, 0x03, 0x76, 0x87}));
  CHECK_FALSE(rtu_frame_is_whole(Bytes{0x11, 0x03, 0x00, 0x6B, 0x00, 0x02, 0x76, 0x87}));
  CHECK_FALSE(rtu_frame_is_whole(Bytes{0xFF, 0xFF}));
}

TEST_CASE("Digital F/T: a sample encodes to and decodes from its bytes, with gauge order and checksum") {
  const auto decoded = [](const Bytes& bytes) { return decode_digital_sample(bytes); };
  Bytes bytes{0x00, 0x01, 0xFF, 0xFE, 0x7F, 0xFF, 0x01, 0x00, 0x80, 0x00, 0x00, 0x05, 0x02};
  // 1 + 0xFF + 0xFE + 0x7F + 0xFF + 1 + 0x80 + 5 = 0x502
  DigitalSample sample{{1, 256, -2, -32768, 32767, 5}, false};
  const auto encoded = [](const DigitalSample& one) { return encode(one); };
  check_codec(bytes, sample, encoded, decoded, Sum::kSevenBits);
  bytes[12] |= 0x80U;
  sample.error = true;
  check_codec(bytes, sample, encoded, decoded, Sum::kSevenBits);
  CHECK_FALSE(decode_digital_sample(std::span(bytes).first(12)));
}

TEST_CASE("Digital F/T: the calibration registers decode in both word orders, and a short block is refused") {
  const auto calibration = invented_digital();
  const auto bytes = encode(calibration);
  CHECK(bytes[0] == 'F');
  CHECK(bytes[208] == 2);
  CHECK(bytes[209] == 3);
  CHECK(std::vector<int>(bytes.begin() + 234, bytes.begin() + 242) ==
        std::vector<int>{0, 0, 3, 0xE8, 0, 0x0F, 0x42, 0x40});
  CHECK(decode_digital_calibration(bytes) == calibration);
  auto turned = bytes;
  const auto turn = [&](std::size_t begin, std::size_t count) {
    for (std::size_t i = 0; i < count; ++i) {
      std::swap(turned[begin + 4 * i], turned[begin + 4 * i + 2]);
      std::swap(turned[begin + 4 * i + 1], turned[begin + 4 * i + 3]);
    }
  };
  turn(64, 36);
  turn(210, 8);
  CHECK(decode_digital_calibration(turned, true) == calibration);
  CHECK(fault_id_of([&] { (void)decode_digital_calibration(std::span(bytes).first(337)); }) == "TB-FORCE-CALIBRATION");
}

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
  for (const Bytes& none : {Bytes{0x12, 0x34, 0, 2, 0, 0, 0}, Bytes{0x12, 0x34, 0, 2, 0, 0, 0, 0, 0},
                            Bytes{0x34, 0x12, 0, 2, 0, 0, 0, 0}, Bytes{0x12, 0x34, 0, 1, 0, 0, 0, 0}, Bytes{}})
    CHECK_FALSE(decode_rdt_request(none));
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
