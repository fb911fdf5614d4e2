#include "devices/tactile/scan_report.h"

#include <catch2/catch.hpp>
#include <limits>
#include <stdexcept>
#include <vector>

#include "tests/devices/check_codec.h"

using namespace tactbench::devices;

namespace {

RowReport some_row() {
  RowReport report{0xFFFE, 0x01020304, 0xA55A, 15, kStatusAtLimit | kStatusSupply, 0xFEDCBA98, {}};
  for (std::size_t i = 0; i < report.samples.size(); ++i)
    report.samples[i] = static_cast<std::uint16_t>(65535 - 257 * i);
  return report;
}

IdentityReport some_identity() { return {7, 16, 16, 7.62939453125e-5F, "SIM-0123456789AB", "1.0"}; }

template <class Encoded, class Decode>
void every_other_length_is_refused(const Encoded& good, Decode decode) {
  std::vector<std::uint8_t> bytes(good.begin(), good.end());
  bytes.push_back(0);
  CHECK_FALSE(decode(bytes).has_value());
  for (std::size_t size = 0; size < good.size(); ++size) {
    CHECK_FALSE(decode(std::span(good).first(size)).has_value());
  }
}

template <std::size_t N>
void reseal(std::array<std::uint8_t, N>& bytes) {
  const std::uint16_t crc = crc16_ccitt(std::span(bytes).first(N - 2));
  bytes[N - 2] = static_cast<std::uint8_t>(crc & 0xFFU);
  bytes[N - 1] = static_cast<std::uint8_t>(crc >> 8U);
}

}  // namespace

TEST_CASE("scan report: CRC-16/CCITT-FALSE has its published check value") {
  const std::string text = "123456789";
  const std::vector<std::uint8_t> bytes(text.begin(), text.end());
  CHECK(crc16_ccitt(bytes) == 0x29B1);
  CHECK(crc16_ccitt({}) == 0xFFFF);
}

TEST_CASE("scan report: fields are at the offsets of the format, little-endian") {
  const auto row = encode(some_row());
  CHECK(row[0] == 0x01);
  CHECK((row[1] == 0xFE && row[2] == 0xFF));
  CHECK((row[3] == 0x04 && row[6] == 0x01));
  CHECK((row[7] == 0x5A && row[8] == 0xA5));
  CHECK((row[9] == 15 && row[10] == 5));
  CHECK((row[11] == 0x98 && row[14] == 0xFE));
  CHECK((row[15] == 0xFF && row[17] == 0xFE && row[18] == 0xFE));
  CHECK(row[47] == 0);
  const auto command = encode(CommandReport{ScanCommand::kScan, 0x1234});
  CHECK((command[0] == 0x02 && command[1] == 1 && command[2] == 0x34 && command[3] == 0x12 && command[4] == 0));
  const auto identity = encode(some_identity());
  CHECK((identity[0] == 0x03 && identity[1] == 7 && identity[3] == 16 && identity[9] == 'S' && identity[25] == '1'));
  CHECK((identity[5] == 0 && identity[8] == 0x38));  // 7.62939453125e-5 = 2^-13.68: 0x38A00000
}

TEST_CASE("scan report: reports survive encoding and decoding, and every single flipped bit is refused") {
  const auto check = [](const auto& report, auto decode) {
    check_codec(
        encode(report), report, [](const auto& one) { return encode(one); }, decode, Sum::kAll);
  };
  for (const RowReport& row : {some_row(), RowReport{}}) check(row, [](auto bytes) { return decode_row(bytes); });
  for (const IdentityReport& identity : {some_identity(), IdentityReport{}})
    check(identity, [](auto bytes) { return decode_identity(bytes); });
  for (const auto command : {ScanCommand::kScan, ScanCommand::kIdentify})
    check(CommandReport{command, 0xBEEF}, [](auto bytes) { return decode_command(bytes); });
}

TEST_CASE("scan report: any other length is refused") {
  every_other_length_is_refused(encode(some_row()), [](auto bytes) { return decode_row(bytes); });
  every_other_length_is_refused(encode(some_identity()), [](auto bytes) { return decode_identity(bytes); });
  every_other_length_is_refused(encode(CommandReport{}), [](auto bytes) { return decode_command(bytes); });
}

TEST_CASE("scan report: invalid content with a correct CRC is refused") {
  auto row = encode(some_row());
  row[0] = 0x03;  // another report's id
  reseal(row);
  CHECK_FALSE(decode_row(row).has_value());
  auto command = encode(CommandReport{});
  command[1] = 3;  // unknown command
  reseal(command);
  CHECK_FALSE(decode_command(command).has_value());
}

TEST_CASE("scan report: every padding byte must be 0") {
  const auto refused_at = [](auto sound, std::size_t at, auto decode) {
    REQUIRE(decode(sound));
    sound[at] = 1;
    reseal(sound);
    return !decode(sound);
  };
  for (std::size_t at = 47; at < 62; ++at)
    CHECK(refused_at(encode(some_row()), at, [](auto bytes) { return decode_row(bytes).has_value(); }));
  for (std::size_t at = 41; at < 62; ++at)
    CHECK(refused_at(encode(some_identity()), at, [](auto bytes) { return decode_identity(bytes).has_value(); }));
  for (std::size_t at = 4; at < 6; ++at)
    CHECK(refused_at(encode(CommandReport{}), at, [](auto bytes) { return decode_command(bytes).has_value(); }));
  // The bytes next to the padding are values: the last sample, the last letter, the tag.
  RowReport row = some_row();
  row.samples.back() = 0xFFFF;
  CHECK(decode_row(encode(row)) == row);
  const IdentityReport longest{7, 1, 2, 1.0F, "SIXTEEN-LETTERS!", "sixteen-letters?"};
  CHECK(decode_identity(encode(longest)) == longest);
  CHECK(decode_command(encode(CommandReport{ScanCommand::kIdentify, 0xFFFF})).value().tag == 0xFFFF);
}

TEST_CASE("scan report: texts are at most sixteen printable ASCII characters, padded with zeros") {
  const auto written = [](const std::string& serial, const std::string& firmware) {
    try {
      (void)encode(IdentityReport{1, 16, 16, 1.0F, serial, firmware});
      return true;
    } catch (const std::invalid_argument&) {
      return false;
    }
  };
  for (std::size_t at = 0; at < 16; ++at) {
    for (const auto& [character, good] : {std::pair{' ', true}, {'~', true}, {'\x1F', false}, {'\x7F', false}}) {
      std::string text(16, 'm');
      text[at] = character;
      CHECK(written(text, "") == good);
      CHECK(written("", text) == good);
      for (const std::size_t field : {9U, 25U}) {
        auto bytes = encode(IdentityReport{1, 16, 16, 1.0F, std::string(16, 'm'), std::string(16, 'm')});
        bytes[field + at] = static_cast<std::uint8_t>(character);
        reseal(bytes);
        const auto identity = decode_identity(bytes);
        CHECK(identity.has_value() == good);
        if (identity) CHECK((field == 9 ? identity->serial : identity->firmware) == text);
      }
    }
  }
  CHECK_FALSE(written(std::string(17, 'm'), ""));
  CHECK_FALSE(written("", std::string(17, 'm')));
  // Behind the first 0 there are only zeros.
  for (const std::size_t field : {9U, 25U}) {
    auto bytes = encode(IdentityReport{1, 16, 16, 1.0F, std::string(16, 'm'), std::string(16, 'm')});
    for (std::size_t at = 16; at-- > 0;) {
      bytes[field + at] = 0;
      reseal(bytes);
      const auto identity = decode_identity(bytes);
      REQUIRE(identity);
      CHECK((field == 9 ? identity->serial : identity->firmware) == std::string(at, 'm'));
      if (at == 15) continue;
      auto behind = bytes;
      behind[field + 15] = 'x';
      reseal(behind);
      CHECK_FALSE(decode_identity(behind));
    }
  }
}
