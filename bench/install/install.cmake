# What `cmake --install` puts where, in four components: program, library (the compensator for C), development, python.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

install(TARGETS tactbench RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT program)
if(TARGET tactbench_genetic)
  # One folder deeper than where cpack takes libraries for such that need ldconfig.
  install(TARGETS tactbench_genetic LIBRARY DESTINATION lib/tactbench/modules COMPONENT program)
endif()
# The folders below share/tactbench are those of the source tree: bench/config/config.cpp looks into either alike.
foreach(folder sequences bench/config devices/profiles)
  install(DIRECTORY ${folder}/ DESTINATION ${CMAKE_INSTALL_DATADIR}/tactbench/${folder} COMPONENT program
    FILES_MATCHING PATTERN "*.toml")
endforeach()
install(FILES bench/config/70-tactbench.rules DESTINATION lib/udev/rules.d COMPONENT program)
install(FILES bench/install/tactbench-nightly.service bench/install/tactbench-nightly.timer
  DESTINATION lib/systemd/system COMPONENT program)
install(FILES bench/install/tactbench.tmpfiles.conf DESTINATION lib/tmpfiles.d RENAME tactbench.conf COMPONENT program)
install(FILES bench/install/tactbench.sysusers.conf DESTINATION lib/sysusers.d RENAME tactbench.conf COMPONENT program)
install(PROGRAMS bench/nightly/night-part.sh DESTINATION ${CMAKE_INSTALL_DATADIR}/tactbench COMPONENT program)
install(FILES bench/install/github-actions.example.yml devices/tactile/frame_server.py devices/tactile/frame_protocol.md
  DESTINATION ${CMAKE_INSTALL_DOCDIR}/examples COMPONENT program)
install(FILES LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT license)  # the .deb says it in its own way

# The manual page: --help and --version of the program just built, and bench/install/tactbench.h2m.
find_program(HELP2MAN help2man REQUIRED)
add_custom_command(OUTPUT tactbench.1.gz
  COMMAND ${CMAKE_COMMAND} -E env TACTBENCH_SHARE=${PROJECT_SOURCE_DIR} ${HELP2MAN} --no-info --include
    ${PROJECT_SOURCE_DIR}/bench/install/tactbench.h2m --output=tactbench.1 $<TARGET_FILE:tactbench>
  COMMAND gzip -9nf tactbench.1
  DEPENDS tactbench bench/install/tactbench.h2m VERBATIM)
add_custom_target(tactbench_manual ALL DEPENDS ${PROJECT_BINARY_DIR}/tactbench.1.gz)
install(FILES ${PROJECT_BINARY_DIR}/tactbench.1.gz DESTINATION ${CMAKE_INSTALL_MANDIR}/man1 COMPONENT program)
install(FILES bench/install/completion.bash DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions
  RENAME tactbench COMPONENT program)

# The compensator: find_package(tactbench) gives tactbench::compensator (static, C++) and tactbench::compensator_shared
# (C API); pkg-config knows the latter as tactbench-compensator. Headers keep their paths: "analysis/compensate/...".
set_target_properties(tactbench_compensator PROPERTIES EXPORT_NAME compensator)
set_target_properties(tactbench_compensator_shared PROPERTIES EXPORT_NAME compensator_shared)
install(TARGETS tactbench_compensator tactbench_compensator_shared EXPORT tactbench-targets
  ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT development
  LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT library NAMELINK_COMPONENT development
  INCLUDES DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/tactbench)
install(FILES analysis/compensate/compensator.h analysis/compensate/compensator_c.h analysis/compensate/document.h
  DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/tactbench/analysis/compensate
  COMPONENT development)
install(FILES analysis/models/dynamics.h analysis/models/pattern_curve.h DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/tactbench/analysis/models COMPONENT development)
set(package_folder ${CMAKE_INSTALL_LIBDIR}/cmake/tactbench)
install(EXPORT tactbench-targets NAMESPACE tactbench:: DESTINATION ${package_folder} COMPONENT development)
file(WRITE ${PROJECT_BINARY_DIR}/generated/tactbench-config.cmake
  "include(\${CMAKE_CURRENT_LIST_DIR}/tactbench-targets.cmake)\n")
write_basic_package_version_file(${PROJECT_BINARY_DIR}/generated/tactbench-config-version.cmake
  COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/generated/tactbench-config.cmake
  ${PROJECT_BINARY_DIR}/generated/tactbench-config-version.cmake DESTINATION ${package_folder} COMPONENT development)
configure_file(bench/install/tactbench-compensator.pc.in generated/tactbench-compensator.pc @ONLY)
install(FILES ${PROJECT_BINARY_DIR}/generated/tactbench-compensator.pc DESTINATION ${CMAKE_INSTALL_DATADIR}/pkgconfig
  COMPONENT development)
install(FILES analysis/compensate/python/tactbench_compensator.py DESTINATION lib/python3/dist-packages
  COMPONENT python)
install(DIRECTORY analysis/python/tactbench DESTINATION lib/python3/dist-packages COMPONENT python
  FILES_MATCHING PATTERN "*.py")
