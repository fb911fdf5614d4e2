# `cmake --build --preset default --target wheel`: the package for Python as build/wheel/tactbench-*.whl, for `pip install`.
# It holds the shared library, which Python calls by ctypes: one wheel serves every Python from 3.8 on.
if(CMAKE_SYSTEM_PROCESSOR MATCHES "^(x86_64|AMD64)$")
  add_library(tactbench_wheel_library SHARED $<TARGET_OBJECTS:tactbench_compensator_objects>
    ${PROJECT_SOURCE_DIR}/analysis/python/older_systems.cpp)
  target_link_options(tactbench_wheel_library PRIVATE
    LINKER:--wrap=exp,--wrap=hypot,--wrap=_ZSt28__throw_bad_array_new_lengthv LINKER:--strip-all)
else()
  add_library(tactbench_wheel_library SHARED $<TARGET_OBJECTS:tactbench_compensator_objects>)
endif()
target_link_libraries(tactbench_wheel_library PRIVATE tactbench_options)
set(WHEEL_FOLDER ${PROJECT_BINARY_DIR}/wheel)
set_target_properties(tactbench_wheel_library PROPERTIES OUTPUT_NAME tactbench_compensator VERSION 1.0.0 SOVERSION 1
  LIBRARY_OUTPUT_DIRECTORY ${WHEEL_FOLDER}/library LINKER_LANGUAGE CXX EXCLUDE_FROM_ALL TRUE
  CXX_VISIBILITY_PRESET hidden)
set(WHEEL ${WHEEL_FOLDER}/tactbench-${PROJECT_VERSION}-py3-none-linux_${CMAKE_SYSTEM_PROCESSOR}.whl)
file(GLOB package_sources CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/analysis/python/tactbench/*.py)
list(APPEND package_sources ${PROJECT_SOURCE_DIR}/analysis/compensate/python/tactbench_compensator.py)
add_custom_command(OUTPUT ${WHEEL}
  COMMAND /usr/bin/python3 ${PROJECT_SOURCE_DIR}/analysis/python/make_wheel.py ${WHEEL} ${PROJECT_VERSION}
    $<TARGET_FILE:tactbench_wheel_library> ${PROJECT_SOURCE_DIR}/LICENSE ${package_sources}
  DEPENDS tactbench_wheel_library ${package_sources} ${PROJECT_SOURCE_DIR}/analysis/python/make_wheel.py
    ${PROJECT_SOURCE_DIR}/LICENSE
  VERBATIM)
add_custom_target(wheel DEPENDS ${WHEEL})
