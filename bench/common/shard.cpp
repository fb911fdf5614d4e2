#include "bench/common/shard.h"

#include <fmt/format.h>

#include <charconv>

#include "bench/common/error.h"

namespace tactbench::bench {

bool Shard::holds(std::size_t place) const {
  return place % static_cast<std::size_t>(of) + 1 == static_cast<std::size_t>(number);
}

std::string Shard::text() const { return fmt::format("{}/{}", number, of); }

Shard shard_from(const std::string& typed) {
  Shard shard{0, 0};
  const char *const begin = typed.data(), *const end = begin + typed.size();
  const auto number = std::from_chars(begin, end, shard.number);
  if (number.ec == std::errc() && number.ptr != end && *number.ptr == '/') {
    const auto of = std::from_chars(number.ptr + 1, end, shard.of);
    if (of.ec == std::errc() && of.ptr == end && shard.number >= 1 && shard.number <= shard.of &&
        shard.of <= kMaxShards)
      return shard;
  }
  throw Error("TB-USAGE", fmt::format("'{}' does not name a part K/N", typed), "--shard",
              fmt::format("K/N, part K of N, K from 1 to N and N at most {}: --shard 3/8", kMaxShards));
}

}  // namespace tactbench::bench
