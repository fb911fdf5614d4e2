// The shortest valid bench files, and the error that a bench file with some values changed gives.
#pragma once

#include <string>
#include <vector>

#include "bench/config/config.h"

namespace tactbench::tests {

using Changes = std::vector<sequences::Override>;

// `origin`: "simulated" or "hardware". What is added last belongs to [reference].
inline std::string bench_text(const std::string& origin) {
  return "schema = 1\n[bench]\nid = \"b\"\norigin = \"" + origin +
         "\"\n[module]\nprofile = \"beckhoff-ek9000\"\n[regulator]\nserial = \"R\"\n"
         "[reference]\nmodel = \"m\"\nserial = \"s\"\n";
}

inline bench::BenchConfig simulated_bench(const Changes& changes = {}) {
  return bench::parse_bench(bench_text("simulated"), "b.toml", changes);
}
inline bench::BenchConfig hardware_bench(const Changes& changes = {}) {
  return bench::parse_bench(bench_text("hardware"), "b.toml", changes);
}

// The error with which a file is refused.
struct Refusal {
  std::string id = "accepted", where, remedy;
};

template <class Work>
Refusal file_refusal(const Work& work) {
  try {
    work();
  } catch (const sequences::FileError& error) {
    return {error.id(), error.where(), error.remedy()};
  }
  return {};
}

inline Refusal refusal_of(const std::string& text, const Changes& changes) {
  return file_refusal([&] { (void)bench::parse_bench(text, "b.toml", changes); });
}
inline bool bench_accepts(const std::string& text, const Changes& changes) {
  return refusal_of(text, changes).id == "accepted";
}

}  // namespace tactbench::tests
