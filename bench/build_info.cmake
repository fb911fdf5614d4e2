# Writes OUT, which bench/common/build_info.cpp alone includes: version, git commit, its date, whether the sources differ from
# it, the build and where the sources lie. Touches it only when something changed.
execute_process(COMMAND git -C ${SOURCE} rev-parse --short=12 HEAD OUTPUT_VARIABLE commit
  OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET RESULT_VARIABLE failed)
if(failed)
  set(commit "unknown")
  set(dirty "false")
  string(TIMESTAMP date "%Y-%m-%d" UTC)  # of SOURCE_DATE_EPOCH where it is set
else()
  execute_process(COMMAND git -C ${SOURCE} log -1 --format=%cs OUTPUT_VARIABLE date
    OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
  execute_process(COMMAND git -C ${SOURCE} status --porcelain --untracked-files=no OUTPUT_VARIABLE changes ERROR_QUIET)
  if(changes STREQUAL "")
    set(dirty "false")
  else()
    set(dirty "true")
  endif()
endif()
set(text "#pragma once
#define TACTBENCH_VERSION \"${VERSION}\"
#define TACTBENCH_COMMIT \"${commit}\"
#define TACTBENCH_DATE \"${date}\"
#define TACTBENCH_MODIFIED ${dirty}
#define TACTBENCH_BUILD \"${BUILD_TYPE}, ${COMPILER}\"
#define TACTBENCH_SOURCE_FOLDER \"${SOURCE}\"
")
file(CONFIGURE OUTPUT ${OUT} CONTENT "${text}" @ONLY)
