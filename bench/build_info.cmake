# Writes OUT with version, git commit and dirty flag, and only touches it when something changed.
execute_process(COMMAND git -C ${SOURCE} rev-parse --short=12 HEAD OUTPUT_VARIABLE commit
  OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET RESULT_VARIABLE failed)
if(failed)
  set(commit "unknown")
  set(dirty "false")
else()
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
#define TACTBENCH_DIRTY ${dirty}
#define TACTBENCH_BUILD \"${BUILD_TYPE}, ${COMPILER}\"
")
file(CONFIGURE OUTPUT ${OUT} CONTENT "${text}" @ONLY)
