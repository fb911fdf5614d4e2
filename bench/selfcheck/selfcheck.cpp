#include "bench/selfcheck/selfcheck.h"

#include <fmt/format.h>

#include <exception>

namespace tactbench::bench {

SelfcheckLine selfchecked(const std::string& area, const std::string& what, const std::string& expected,
                          const std::function<SelfcheckAnswer()>& check) {
  SelfcheckLine line{area, what, expected, {}, false};
  try {
    const SelfcheckAnswer answer = check();
    line.found = answer.found;
    line.pass = answer.pass;
  } catch (const std::exception& error) {
    line.found = fmt::format("could not be checked: {}", error.what());
  }
  return line;
}

}  // namespace tactbench::bench
