# The OpenCV modules named as components, as targets opencv_<module>. OpenCV's own package is used where it is installed;
# distributions that split OpenCV into module packages (Debian) ship no package file with them, so each module is looked
# for by its header and library.
#
#   find_package(OpenCVModules COMPONENTS core imgproc)   ->  OpenCVModules_FOUND, OpenCVModules_<module>_FOUND

find_package(OpenCV QUIET NO_MODULE OPTIONAL_COMPONENTS ${OpenCVModules_FIND_COMPONENTS})
find_path(OpenCVModules_INCLUDE_DIR opencv2/core.hpp PATH_SUFFIXES opencv4)
foreach(module IN LISTS OpenCVModules_FIND_COMPONENTS)
  if(NOT TARGET opencv_${module})
    find_library(OpenCVModules_${module}_LIBRARY opencv_${module})
    if(OpenCVModules_${module}_LIBRARY AND EXISTS "${OpenCVModules_INCLUDE_DIR}/opencv2/${module}.hpp")
      add_library(opencv_${module} UNKNOWN IMPORTED GLOBAL)
      set_target_properties(opencv_${module} PROPERTIES IMPORTED_LOCATION "${OpenCVModules_${module}_LIBRARY}")
      target_include_directories(opencv_${module} SYSTEM INTERFACE "${OpenCVModules_INCLUDE_DIR}")
    endif()
  endif()
  set(OpenCVModules_${module}_FOUND FALSE)
  if(TARGET opencv_${module})
    set(OpenCVModules_${module}_FOUND TRUE)
    set(OpenCVModules_any_FOUND TRUE)
  endif()
endforeach()

include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(OpenCVModules REQUIRED_VARS OpenCVModules_any_FOUND HANDLE_COMPONENTS)
