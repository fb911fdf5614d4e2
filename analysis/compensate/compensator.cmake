# The compensator for robots: models, their inverses and the streams; static, and shared for its C API. Of libraries it
# takes headers alone.
file(GLOB COMPENSATOR_SOURCES CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/analysis/compensate/*.cpp
  ${PROJECT_SOURCE_DIR}/analysis/models/*.cpp)
set(sources ${COMPENSATOR_SOURCES})
if(TACTBENCH_MUTANTS)
  tactbench_put_mutants(sources)
endif()
add_library(tactbench_compensator_objects OBJECT ${sources})
target_link_libraries(tactbench_compensator_objects PUBLIC tactbench_options
  PRIVATE nlohmann_json::nlohmann_json)
set_target_properties(tactbench_compensator_objects PROPERTIES POSITION_INDEPENDENT_CODE ON
  CXX_VISIBILITY_PRESET hidden VISIBILITY_INLINES_HIDDEN ON)
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
