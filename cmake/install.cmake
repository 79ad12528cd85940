# What `cmake --install` puts in place: the headers, the package for find_package(plumbline), plumbline.pc. Each
# component has an export file of its own, so that a user of core needs nothing but Eigen.

include(CMakePackageConfigHelpers)
set(CMAKE_INSTALL_DEFAULT_COMPONENT_NAME development)
set(plumbline_package_dir "${CMAKE_INSTALL_DATADIR}/cmake/plumbline")

foreach(component core thread testing opencv lbd io bag c)
  if(TARGET plumbline_${component})
    install(TARGETS plumbline_${component} EXPORT plumbline-${component} FILE_SET HEADERS)
    install(EXPORT plumbline-${component} NAMESPACE plumbline:: DESTINATION "${plumbline_package_dir}")
  endif()
endforeach()

configure_package_config_file(cmake/plumbline-config.cmake.in plumbline-config.cmake
  INSTALL_DESTINATION "${plumbline_package_dir}")
write_basic_package_version_file(plumbline-config-version.cmake COMPATIBILITY SameMinorVersion ARCH_INDEPENDENT)
install(FILES "${CMAKE_CURRENT_BINARY_DIR}/plumbline-config.cmake"
  "${CMAKE_CURRENT_BINARY_DIR}/plumbline-config-version.cmake" "${PROJECT_SOURCE_DIR}/cmake/FindOpenCVModules.cmake"
  "${PROJECT_SOURCE_DIR}/cmake/FindBagLibraries.cmake"
  DESTINATION "${plumbline_package_dir}")

configure_file(cmake/plumbline.pc.in plumbline.pc @ONLY)
install(FILES "${CMAKE_CURRENT_BINARY_DIR}/plumbline.pc" DESTINATION "${CMAKE_INSTALL_DATADIR}/pkgconfig")
