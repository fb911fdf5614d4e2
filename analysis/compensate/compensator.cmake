# The compensator for robots: the C++ standard library and nothing else. Static, and shared for its C API.
set(COMPENSATOR_SOURCES options composed_curve dispatch frame_setup frame_compensator frame_events frame_pass compensator_c
  dynamic_setup dynamic_frame_setup dynamic_frame_compensator dynamic_frame_events dynamic_frame_turns dynamic_pass
  compensator_dynamic_c)
list(TRANSFORM COMPENSATOR_SOURCES REPLACE "(.+)" "${CMAKE_CURRENT_LIST_DIR}/\\1.cpp")
list(APPEND COMPENSATOR_SOURCES ${PROJECT_SOURCE_DIR}/analysis/models/pattern_curve.cpp)
add_library(tactbench_compensator_objects OBJECT ${COMPENSATOR_SOURCES})
target_link_libraries(tactbench_compensator_objects PUBLIC tactbench_options)
# No batches: each source instantiates its part of the templates.
set_target_properties(tactbench_compensator_objects PROPERTIES UNITY_BUILD OFF POSITION_INDEPENDENT_CODE ON
  CXX_VISIBILITY_PRESET hidden VISIBILITY_INLINES_HIDDEN ON)
# A square root that need not set errno is one instruction; no vector crosses a call, its ABI does not matter.
set_source_files_properties(analysis/compensate/frame_pass.cpp analysis/compensate/frame_events.cpp PROPERTIES
  COMPILE_OPTIONS "-fno-math-errno;-Wno-psabi")
# Without traps a choice between two numbers needs no branch: the passes become vectors.
set_source_files_properties(analysis/compensate/dynamic_pass.cpp PROPERTIES
  COMPILE_OPTIONS "-O3;-fno-math-errno;-fno-trapping-math;-Wno-psabi")
add_library(tactbench_compensator STATIC $<TARGET_OBJECTS:tactbench_compensator_objects>)
add_library(tactbench_compensator_shared SHARED $<TARGET_OBJECTS:tactbench_compensator_objects>)
add_library(tactbench::compensator ALIAS tactbench_compensator)
set_target_properties(tactbench_compensator_shared PROPERTIES OUTPUT_NAME tactbench_compensator VERSION 1.0.0 SOVERSION 1)
foreach(target tactbench_compensator tactbench_compensator_shared)
  target_link_libraries(${target} PUBLIC $<BUILD_INTERFACE:tactbench_options>)
  target_compile_features(${target} INTERFACE cxx_std_20)
  set_target_properties(${target} PROPERTIES LINKER_LANGUAGE CXX)
endforeach()
target_compile_options(tactbench_compensator_objects PRIVATE ${COMPUTING_OPTIONS} ${FUZZING_OPTIONS})
