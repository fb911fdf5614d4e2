#include "bench/common/build_info.h"

#include "build_info_values.h"

namespace tactbench::bench {

const BuildInfo& build_info() {
  static const BuildInfo info = {TACTBENCH_VERSION,  TACTBENCH_COMMIT, TACTBENCH_DATE,
                                 TACTBENCH_MODIFIED, TACTBENCH_BUILD,  TACTBENCH_SOURCE_FOLDER};
  return info;
}

const char* processor_class() {
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx512vl")) return "avx512";
  if (__builtin_cpu_supports("avx2")) return "avx2";
#endif
  return "base";
}

std::string commit_text() { return build_info().commit + (build_info().modified ? ", modified" : ""); }

}  // namespace tactbench::bench
