# The user's project in consumer/, built in the four ways a user takes the library: an installed package in a world
# without OpenCV and yaml-cpp, the same with all components, add_subdirectory, pkg-config.

set(consumer_source "${CMAKE_CURRENT_SOURCE_DIR}/consumer")
set(consumer_binary "${CMAKE_CURRENT_BINARY_DIR}/consumer")
set(prefix "${consumer_binary}/prefix")

function(add_consumer_test name)
  add_test(NAME ${name} COMMAND ${CMAKE_CTEST_COMMAND} --build-and-test "${consumer_source}" "${consumer_binary}/${name}"
    --build-generator "${CMAKE_GENERATOR}" --build-options "-DCMAKE_CXX_COMPILER=${CMAKE_CXX_COMPILER}"
    "-DCMAKE_CXX_COMPILER_LAUNCHER=${CMAKE_CXX_COMPILER_LAUNCHER}" ${ARGN} --test-command consumer)
endfunction()

add_test(NAME package_install COMMAND ${CMAKE_COMMAND} --install "${PROJECT_BINARY_DIR}" --prefix "${prefix}"
  --component development)
add_consumer_test(package_core "-DCMAKE_PREFIX_PATH=${prefix}" -DCMAKE_DISABLE_FIND_PACKAGE_OpenCVModules=ON
  -DCMAKE_DISABLE_FIND_PACKAGE_yaml-cpp=ON)
set(components core thread testing opencv io)
foreach(component lbd bag c)
  if(TARGET plumbline_${component})
    list(APPEND components ${component})
  endif()
endforeach()
add_consumer_test(package_all "-DCMAKE_PREFIX_PATH=${prefix}" "-DPLUMBLINE_COMPONENTS=${components}")
add_consumer_test(package_subdirectory "-DPLUMBLINE_SOURCE=${PROJECT_SOURCE_DIR}")
set(tests package_core package_all)

find_program(PKG_CONFIG pkg-config)
if(PKG_CONFIG)
  add_test(NAME package_pkg_config COMMAND sh -c "flags=$('${PKG_CONFIG}' --cflags plumbline) \
    && '${CMAKE_CXX_COMPILER}' -std=c++20 $flags '${consumer_source}/main.cpp' -o consumer_pkg_config \
    && ./consumer_pkg_config")
  set_tests_properties(package_pkg_config PROPERTIES
    ENVIRONMENT "PKG_CONFIG_PATH=${prefix}/${CMAKE_INSTALL_DATADIR}/pkgconfig")
  list(APPEND tests package_pkg_config)
endif()

set_tests_properties(package_install PROPERTIES FIXTURES_SETUP plumbline_package)
set_tests_properties(${tests} PROPERTIES FIXTURES_REQUIRED plumbline_package)
set_tests_properties(package_install package_subdirectory ${tests} PROPERTIES LABELS package)
