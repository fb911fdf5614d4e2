# Joins the rows that the tests of the matrix wrote to one table in Markdown.
file(WRITE ${out} "# Bad luck, fault by point in the sequence\n
Written by `ctest --preset default -L faults` to `build/tests/fault-matrix.md`; this copy is that file, and each test
says where its row differs: `cp build/tests/fault-matrix.md tests/faults/README.md`. Simulated rig, seeds 1 and 1.\n
A cell says how the run ended, the exit code, the error without its TB-, the safe state as the run reports it, and whether
the run was resumed to its full data set once the fault was gone. `interrupted`: the row could be closed only by the next
start. Every cell is also held against the plant's truth: never \"verified\" while pressure or force stands; below 1 psi
and 0.5 N within 30 s of process time wherever a way leads to the actuator; frames acknowledged, stored and counted once;
the content hash recomputes. `once`: one answer is spoilt; else the fault stays.\n")
set(cases 0)
foreach(table chamber press process)
  file(GLOB files ${rows}/${table}.*)
  if(NOT files)
    continue()
  endif()
  if(table STREQUAL "chamber")
    set(head "opening | baseline | conditioning | rising, 20 psi | turning, 60 psi | falling, 40 psi | last branch | way out at 60 psi")
    file(APPEND ${out} "\n## Chamber, 0 - 60 - 20 - 60 - 0 psi twice\n")
  elseif(table STREQUAL "press")
    set(head "homing | approach | pressing, 15 N | releasing, 30 N | retract | way out at 30 N")
    file(APPEND ${out} "\n## Press, ring, 5 - 30 - 5 N twice\n")
  else()
    set(head "rising, 30 psi | dwelling, 60 psi")
    file(APPEND ${out} "\n## Process of its own, real time, 0 - 60 - 0 psi\n")
  endif()
  string(REGEX REPLACE "[^|]+" "---" rule "${head}")
  file(APPEND ${out} "\n| fault | ${head} |\n|---|${rule}|\n")
  list(SORT files)
  foreach(file ${files})
    file(READ ${file} row)
    file(APPEND ${out} "${row}")
    string(REGEX MATCHALL "\\| [a-zA-Z]" cells "${row}")
    list(LENGTH cells count)
    math(EXPR cases "${cases} + ${count} - 1")
  endforeach()
endforeach()
file(APPEND ${out} "\n${cases} cases.\n")
message(STATUS "${cases} cases in ${out}")
