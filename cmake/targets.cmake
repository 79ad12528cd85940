# The interface targets. Headers are collected by folder: the folder decides which target, and so which
# dependencies, a header belongs to. Every header compiles alone (tests/headers_alone.cmake).
#
#   plumbline::core      the estimator; Eigen only
#   plumbline::thread    an executor with a thread of its own; the system's threads
#   plumbline::testing   numeric Jacobians, simulated worlds; Eigen only
#   plumbline::opencv    cv::Mat views, detectors, images from files; OpenCV core, imgproc, imgcodecs, libjpeg
#   plumbline::lbd       LBD matching of lines; OpenCV's contributed module line_descriptor and plumbline::opencv
#   plumbline::io        recordings, calibration, trajectories; yaml-cpp and plumbline::opencv
#   plumbline::c         a compiled library with an interface for C, of c/; Eigen only
#   plumbline::bag       bags of ROS 1 and ROS 2 as recordings; bzip2, LZ4, Zstandard, SQLite and plumbline::io

# Every folder of the firmware headers, in the order in which they may include one another: only upwards.
set(plumbline_core_folders core lie solver camera geometry imu residual image tracking sensor state feature factor
    propagation initialization frontend map backend estimator systems)

function(plumbline_add_target name)
  cmake_parse_arguments(ARG "" "" "FOLDERS;FILES;EXCEPT;LINK" ${ARGN})
  set(headers "")
  foreach(folder IN LISTS ARG_FOLDERS)
    file(GLOB found CONFIGURE_DEPENDS "${PROJECT_SOURCE_DIR}/include/plumbline/${folder}/*.hpp")
    list(APPEND headers ${found})
  endforeach()
  if(ARG_EXCEPT)
    list(REMOVE_ITEM headers ${ARG_EXCEPT})
  endif()
  list(APPEND headers ${ARG_FILES})
  add_library(plumbline_${name} INTERFACE)
  add_library(plumbline::${name} ALIAS plumbline_${name})
  set_target_properties(plumbline_${name} PROPERTIES EXPORT_NAME ${name})
  target_sources(plumbline_${name} INTERFACE FILE_SET HEADERS BASE_DIRS "${PROJECT_SOURCE_DIR}/include"
    FILES ${headers})
  target_compile_features(plumbline_${name} INTERFACE cxx_std_20)
  target_link_libraries(plumbline_${name} INTERFACE ${ARG_LINK})
endfunction()

find_package(Eigen3 3.4 REQUIRED NO_MODULE)
file(GLOB umbrella CONFIGURE_DEPENDS "${PROJECT_SOURCE_DIR}/include/plumbline/*.hpp")
plumbline_add_target(core FOLDERS ${plumbline_core_folders} FILES ${umbrella} LINK Eigen3::Eigen)
plumbline_add_target(testing FOLDERS testing LINK plumbline_core)

set(THREADS_PREFER_PTHREAD_FLAG ON)
find_package(Threads QUIET)
if(Threads_FOUND)
  plumbline_add_target(thread FOLDERS thread LINK plumbline_core Threads::Threads)
endif()

list(APPEND CMAKE_MODULE_PATH "${PROJECT_SOURCE_DIR}/cmake")
find_package(OpenCVModules QUIET COMPONENTS core imgproc imgcodecs)
find_package(JPEG QUIET GLOBAL)
if(OpenCVModules_FOUND AND JPEG_FOUND)
  set(lbd_header "${PROJECT_SOURCE_DIR}/include/plumbline/opencv/lbd_matching.hpp")
  plumbline_add_target(opencv FOLDERS opencv EXCEPT "${lbd_header}"
    LINK plumbline_core opencv_core opencv_imgproc opencv_imgcodecs JPEG::JPEG)
  find_package(OpenCVModules QUIET COMPONENTS line_descriptor)
  if(TARGET opencv_line_descriptor)
    plumbline_add_target(lbd FILES "${lbd_header}" LINK plumbline_opencv opencv_line_descriptor)
  else()
    message(STATUS "OpenCV's line_descriptor not found (Debian: libopencv-contrib-dev): no plumbline::lbd")
  endif()
endif()

find_package(yaml-cpp QUIET)
if(yaml-cpp_FOUND AND TARGET plumbline_opencv)
  plumbline_add_target(io FOLDERS io LINK plumbline_opencv yaml-cpp)
endif()

find_package(BagLibraries QUIET)
if(BagLibraries_FOUND AND TARGET plumbline_io)
  plumbline_add_target(bag FOLDERS io/bag LINK plumbline_io BZip2::BZip2 SQLite::SQLite3 plumbline_lz4 plumbline_zstd)
elseif(TARGET plumbline_io)
  message(STATUS "bzip2, LZ4, Zstandard or SQLite not found (Debian: libbz2-dev liblz4-dev libzstd-dev libsqlite3-dev): "
    "no plumbline::bag")
endif()
