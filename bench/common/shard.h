// One of N equal parts of a nightly run, for several machines: `nightly --shard K/N`. Each part runs separately; all N
// together do the whole work, and no item twice.
#pragma once

#include <cstddef>
#include <string>

namespace tactbench::bench {

struct Shard {
  int number = 1, of = 1;  // 1 <= number <= of; 1 of 1: all of the work
  [[nodiscard]] bool is_whole() const { return of == 1; }
  // Whether the part has the item at `place`, from 0, of a list that is the same for all parts. Items are assigned in
  // turn, because neighbours take about equally long and should be in different parts.
  [[nodiscard]] bool holds(std::size_t place) const;
  [[nodiscard]] std::string text() const;  // "3/8"
};

inline constexpr int kMaxShards = 1000;  // Slurm's default is 1 001 tasks per job array

// From "3/8". Throws Error TB-USAGE.
Shard shard_from(const std::string& typed);

}  // namespace tactbench::bench
