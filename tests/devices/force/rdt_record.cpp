#include "devices/force/rdt_record.h"

#include <catch2/catch.hpp>
#include <limits>
#include <vector>

#include "tests/devices/check_codec.h"

using namespace tactbench::devices;
using Bytes = std::vector<std::uint8_t>;

namespace {

template <class Message>
Bytes bytes_of(const Message& message) {
  const auto bytes = encode(message);
  return {bytes.begin(), bytes.end()};
}

}  // namespace

TEST_CASE("RDT: requests are the manual's bytes") {
  for (const auto& [request, bytes] : std::vector<std::pair<RdtRequest, Bytes>>{
           {{RdtCommand::kStartRealtime, 0}, {0x12, 0x34, 0, 2, 0, 0, 0, 0}},
           {{RdtCommand::kStop, 0}, {0x12, 0x34, 0, 0, 0, 0, 0, 0}},
           {{RdtCommand::kSetBias, 0}, {0x12, 0x34, 0, 0x42, 0, 0, 0, 0}},
           {{RdtCommand::kResetLatch, 0}, {0x12, 0x34, 0, 0x41, 0, 0, 0, 0}},
           {{RdtCommand::kStartBuffered, 0x01020304}, {0x12, 0x34, 0, 3, 1, 2, 3, 4}},
           {{RdtCommand::kStartMultiUnit, 5}, {0x12, 0x34, 0, 4, 0, 0, 0, 5}}})
    check_codec(bytes, request, bytes_of<RdtRequest>, [](const Bytes& one) { return decode_rdt_request(one); });
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
  constexpr auto kLow = std::numeric_limits<std::int32_t>::min();
  constexpr auto kHigh = std::numeric_limits<std::int32_t>::max();
  const RdtRecord record{7, 0x01020304, 0x80020000, {1'000'000, -1'000'000, kHigh, kLow, -1, 1}};
  check_codec(bytes, record, bytes_of<RdtRecord>, [](const Bytes& one) { return decode_rdt_record(one); });
  CHECK_FALSE(decode_rdt_record(std::span(bytes).first(35)));
  CHECK_FALSE(decode_rdt_record(Bytes(72)));
}

TEST_CASE("RDT: every bit of the status is an error, but the tripped monitor's and the summary that comes with it") {
  CHECK_FALSE(rdt_status_is_error(0));
  CHECK_FALSE(rdt_status_is_error(0x80010000));
  for (std::size_t bit = 0; bit < 32; ++bit) {
    INFO("bit " << bit);
    const std::uint32_t status = 1U << bit;
    CHECK(rdt_status_is_error(status) == (bit != 16));  // the summary alone is an error that no bit names
    CHECK(rdt_status_is_error(status | 0x80010000U) == (bit != 16 && bit != 31));
  }
}

TEST_CASE("RDT: each command has its number, and numbers beside them are none") {
  for (unsigned number = 0; number < 0x100; ++number) {
    const auto request = decode_rdt_request(Bytes{0x12, 0x34, 0, static_cast<std::uint8_t>(number), 9, 8, 7, 6});
    CHECK(request.has_value() == (number == 0 || (number >= 2 && number <= 4) || number == 0x41 || number == 0x42));
    if (request) CHECK((static_cast<unsigned>(request->command) == number && request->count == 0x09080706));
    CHECK_FALSE(decode_rdt_request(Bytes{0x12, 0x34, 1, static_cast<std::uint8_t>(number), 0, 0, 0, 0}));
  }
}
