#include "tests/benchmarks/study/draw_seed.h"

#include <fmt/format.h>

#include <cstdio>
#include <memory>
#include <stdexcept>

#include "bench/common/build_info.h"

namespace tactbench::bench {

namespace {

std::string code_commit() {
  const std::string command =
      fmt::format("git -C '{}' log -1 --format=%H -- '*.cpp' '*.h' 2>/dev/null", build_info().source_folder);
  std::string hash(40, '\0');
  const std::unique_ptr<FILE, int (*)(FILE*)> pipe(popen(command.c_str(), "r"), pclose);
  if (!pipe || std::fread(hash.data(), 1, hash.size(), pipe.get()) != hash.size())
    throw std::runtime_error("no git history at " + build_info().source_folder + " to draw from: name --seed HEX");
  return hash;
}

}  // namespace

DrawSeed draw_seed(const std::string& given) {
  if (given.size() > 16 || given.find_first_not_of("0123456789abcdef") != std::string::npos)
    throw std::invalid_argument("'" + given + "' is no seed: up to 16 hexadecimal digits");
  const std::string commit = given.empty() ? code_commit() : "";
  return {std::stoull(commit.empty() ? given : commit.substr(0, 16), nullptr, 16), commit};
}

}  // namespace tactbench::bench
