# SPDX-License-Identifier: Apache-2.0
# Every dependency is a Debian 12 package (scripts/setup installs them).
find_package(PkgConfig REQUIRED)
find_package(Eigen3 3.4 REQUIRED NO_MODULE)
find_package(spdlog REQUIRED)
find_package(TBB REQUIRED)
find_package(CLI11 REQUIRED)
find_package(nlohmann_json REQUIRED)
find_package(OpenSSL REQUIRED COMPONENTS Crypto)
find_package(Threads REQUIRED)
# Only the modules in use: Debian's OpenCVConfig.cmake comes with the whole of OpenCV and its many dependencies.
find_path(OPENCV_INCLUDE_DIR opencv2/core.hpp PATH_SUFFIXES opencv4 REQUIRED)
add_library(dermap_opencv INTERFACE)
target_include_directories(dermap_opencv SYSTEM INTERFACE ${OPENCV_INCLUDE_DIR})
foreach(module core imgproc imgcodecs calib3d video)
  find_library(OPENCV_${module} opencv_${module} REQUIRED)
  target_link_libraries(dermap_opencv INTERFACE ${OPENCV_${module}})
endforeach()
# Through pkg-config: the CMake package insists on command line tools that we do not need.
pkg_check_modules(OPENIMAGEIO REQUIRED IMPORTED_TARGET OpenImageIO)
# The thread-safe build: frames are decoded in parallel.
pkg_check_modules(LIBRAW REQUIRED IMPORTED_TARGET libraw_r)
pkg_check_modules(TOMLPLUSPLUS REQUIRED IMPORTED_TARGET tomlplusplus)
pkg_check_modules(LIBUSB REQUIRED IMPORTED_TARGET libusb-1.0)
pkg_check_modules(LIBGPHOTO2 REQUIRED IMPORTED_TARGET libgphoto2)
pkg_check_modules(HTTPLIB REQUIRED IMPORTED_TARGET cpp-httplib)
# For the emulated devices, which only tests and the demo need.
pkg_check_modules(UMOCKDEV IMPORTED_TARGET umockdev-1.0)
if(DERMAP_BUILD_TESTS)
  find_package(GTest REQUIRED)
endif()
if(DERMAP_BUILD_BENCHMARKS)
  find_package(benchmark REQUIRED)
endif()
