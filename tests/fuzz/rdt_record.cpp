// RDT requests and records: what decodes encodes to the same bytes.
#include "devices/force/rdt_record.h"

#include <algorithm>
#include <cstdlib>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace tactbench::devices;
  const std::span bytes(data, size);
  const auto same = [&](const auto& encoded) { return std::ranges::equal(encoded, bytes); };
  if (const auto request = decode_rdt_request(bytes); request && !same(encode(*request))) std::abort();
  const auto record = decode_rdt_record(bytes);
  if (record.has_value() != (size == kRdtRecordBytes)) std::abort();
  if (record && !same(encode(*record))) std::abort();
  if (record && rdt_status_text(record->status).empty()) std::abort();
  return 0;
}
