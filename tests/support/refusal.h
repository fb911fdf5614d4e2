// Returns the error that an operation of the bench throws.
#pragma once

#include <optional>

#include "bench/common/error.h"

namespace tactbench::tests {

// None if `work` ends without an error; other exceptions pass.
template <class Work>
std::optional<bench::Error> refusal_by(const Work& work) {
  try {
    work();
  } catch (const bench::Error& error) {
    return error;
  }
  return std::nullopt;
}

}  // namespace tactbench::tests
