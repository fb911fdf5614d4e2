# Debian packages of what install.cmake installs: `cpack -G DEB` in the build folder. lintian is content with them.
set(TACTBENCH_MAINTAINER "tactbench maintainers <maintainers@tactbench.invalid>" CACHE STRING
  "Maintainer in the packages' control files; whoever distributes them puts a name here")

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_VENDOR tactbench)
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "")  # it would stand before each package's own
set(CPACK_COMPONENTS_ALL program library development python)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_DEBIAN_PACKAGE_MAINTAINER "${TACTBENCH_MAINTAINER}")
set(CPACK_DEBIAN_PACKAGE_RELEASE 0upstream1)  # not Debian's own
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_LIBRARY_PACKAGE_CONTROL_EXTRA
  "${PROJECT_SOURCE_DIR}/bench/install/debian/shlibs;${PROJECT_SOURCE_DIR}/bench/install/debian/triggers")
set(CPACK_DEBIAN_COMPRESSION_TYPE xz)
# Documents that Debian's policy asks for, into each package: bench/install/debian/documents.cmake.
set(CPACK_PRE_BUILD_SCRIPTS ${PROJECT_SOURCE_DIR}/bench/install/debian/documents.cmake)
set(CPACK_TACTBENCH_SOURCE ${PROJECT_SOURCE_DIR})

set(of_a_robot "Streams raw frames of a tactile sensor array into pressures, with the
hysteresis of each taxel taken out by the external loop adaptation method, a
standard uncertainty and status bits for each taxel. It depends on the C++
standard library only and allocates nothing after construction.")

set(CPACK_DEBIAN_PROGRAM_PACKAGE_NAME tactbench)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PROGRAM_DESCRIPTION "test bench controller for tactile sensor arrays
tactbench drives a test bench that characterizes tactile sensor arrays
(pressure chamber behind a regulator, stage with force sensor, scanner),
keeps every sample in SQLite, identifies hysteresis models for each taxel,
scores how well they compensate, and writes calibration reports. The same
program runs against the rig and against a simulated rig at the other end of
the same wires, which a nightly regression uses.")
set(CPACK_DEBIAN_PROGRAM_PACKAGE_DEPENDS adduser)  # its postinst makes the group
set(CPACK_DEBIAN_PROGRAM_PACKAGE_RECOMMENDS "libpq5, fonts-liberation2")  # verbs of the fleet; reports
set(CPACK_DEBIAN_PROGRAM_PACKAGE_CONTROL_EXTRA "${PROJECT_SOURCE_DIR}/bench/install/debian/postinst")
set(CPACK_DEBIAN_PROGRAM_PACKAGE_SUGGESTS "libtactbench-compensator-dev, python3-tactbench-compensator")

set(CPACK_DEBIAN_LIBRARY_PACKAGE_NAME libtactbench-compensator1)
set(CPACK_DEBIAN_LIBRARY_PACKAGE_SECTION libs)
set(CPACK_DEBIAN_LIBRARY_DESCRIPTION "hysteresis compensation for tactile sensor arrays, shared library
${of_a_robot}

This package holds the shared library with the C API.")

set(exactly "libtactbench-compensator1 (= ${PROJECT_VERSION}-${CPACK_DEBIAN_PACKAGE_RELEASE})")
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_NAME libtactbench-compensator-dev)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_DEPENDS "${exactly}")
set(CPACK_DEBIAN_DEVELOPMENT_DESCRIPTION "hysteresis compensation for tactile sensor arrays, development files
${of_a_robot}

This package holds headers for C and C++, the static library, and files for
CMake and pkg-config.")

set(CPACK_DEBIAN_PYTHON_PACKAGE_NAME python3-tactbench-compensator)
set(CPACK_DEBIAN_PYTHON_PACKAGE_SECTION python)
set(CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS "${exactly}, python3")
set(CPACK_DEBIAN_PYTHON_PACKAGE_SUGGESTS "python3-numpy, python3-pandas, python3-xarray, python3-h5py")
set(CPACK_DEBIAN_PYTHON_DESCRIPTION "hysteresis compensation for tactile sensor arrays, Python module
${of_a_robot}

This package holds the Python package tactbench, which also reads run stores,
and the module tactbench_compensator; both need no more than ctypes, frames
of a store numpy, and xarray or pandas for their objects.")
include(CPack)
