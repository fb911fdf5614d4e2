// Tables of samples: whatever the bytes, a history of finite numbers or a refusal that says where and how to mend it.
#include "analysis/table.h"

#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <sstream>
#include <string>

#include "analysis/error.h"

using namespace tactbench;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  std::istringstream stream(std::string(reinterpret_cast<const char*>(data), size));
  try {
    analysis::TableLayout layout = analysis::table_layout(size % 3 == 0   ? ""
                                                          : size % 3 == 1 ? "input=1,output=2-3"
                                                                          : "input=in*,output=o*,time=1");
    layout.skip_bad_rows = size % 2 == 1;
    layout.no_header = size % 5 == 0;
    layout.skip_lines = size % 7 == 0 ? 1 : 0;
    const std::vector<analysis::TableSeries> series = analysis::read_table(stream, "fuzzed.csv", layout).series;
    if (series.empty()) std::abort();
    for (const analysis::TableSeries& own : series) {
      if (own.input.empty() || own.input.size() != own.output.size()) std::abort();
      if (own.taxel < 0 || own.sequence.find('\0') != std::string::npos) std::abort();
      for (std::size_t i = 0; i < own.input.size(); ++i)
        if (!std::isfinite(own.input[i]) || !std::isfinite(own.output[i])) std::abort();
    }
  } catch (const analysis::AnalysisError& error) {
    if (!error.id().starts_with("TB-TABLE-") || error.remedy().empty()) std::abort();
    if (!std::string(error.what()).starts_with("fuzzed.csv:")) std::abort();
  }
  return 0;
}
