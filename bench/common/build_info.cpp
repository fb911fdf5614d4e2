#include "bench/common/build_info.h"

#include "build_info_values.h"

namespace tactbench::bench {

const BuildInfo& build_info() {
  static const BuildInfo info = {TACTBENCH_VERSION,  TACTBENCH_COMMIT, TACTBENCH_DATE,
                                 TACTBENCH_MODIFIED, TACTBENCH_BUILD,  TACTBENCH_SOURCE_FOLDER};
  return info;
}

std::string commit_text() { return build_info().commit + (build_info().modified ? ", modified" : ""); }

}  // namespace tactbench::bench
