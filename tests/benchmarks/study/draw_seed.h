// Seed of a study: the hash of the last commit that changed code, so that nothing can have been chosen on it.
#pragma once

#include <cstdint>
#include <string>

namespace tactbench::bench {

struct DrawSeed {
  std::uint64_t seed = 0;
  std::string commit;  // whose hash it is; empty where a seed was given
};
// `given`: hexadecimal, empty: of the commit. Throws std::invalid_argument for what is no seed, std::runtime_error
// where there is no git history.
DrawSeed draw_seed(const std::string& given);

}  // namespace tactbench::bench
