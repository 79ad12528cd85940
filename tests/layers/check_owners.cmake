# Each of these facts is written in the headers named beside it, and nowhere else in the firmware headers.
#                                                        cmake -DINCLUDE=include/plumbline -P check_owners.cmake

cmake_minimum_required(VERSION 3.25)

# pattern = headers
set(facts
  "HealthState::=state/health.hpp|estimator/publisher.hpp"                 # health: written by the publisher
  "[^a-zA-Z]Estimate<=estimator/estimate.hpp|estimator/publisher.hpp|estimator/estimator.hpp"  # the estimate: as well
  "[^a-zA-Z_]next_state\\(=state/tracking_state.hpp"                       # transitions: one table
  "WorldFrameUncertainty<=state/world_frame_uncertainty.hpp|state/navigation.hpp|estimator/estimator.hpp"
  "\\.set_T_body_cam\\(|\\.set_time_offset\\(=propagation/camera_imu_calibration.hpp"  # what is in force of the calibration
  "Preintegration<S> [a-z_]+_[^a-z(]=propagation/imu_integrator.hpp"              # the samples of a frame: integrated once,
  "[^a-z_]integrated\\(=imu/preintegration.hpp|propagation/imu_factors.hpp"  # and those of a factor about its biases
  "\\.correct_readout\\(=estimator/shutter_motion.hpp"
  # functions that differ from C library to C library; maps are not part of a reproducible build
  "std::(acos|asin|atan|atan2|cbrt|cos|exp|hypot|log|log1p|pow|sin|tan)[(,]=core/elementary.hpp|map/[a-z_]+.hpp"
)

set(violations "")
foreach(fact IN LISTS facts)
  string(REGEX MATCH "^(.*)=(.*)$" matched "${fact}")
  set(pattern "${CMAKE_MATCH_1}")
  set(owners "${CMAKE_MATCH_2}")
  set(found FALSE)
  file(GLOB_RECURSE headers RELATIVE "${INCLUDE}" "${INCLUDE}/*.hpp")
  list(FILTER headers EXCLUDE REGEX "^(io|opencv|testing)/")
  foreach(header IN LISTS headers)
    file(STRINGS "${INCLUDE}/${header}" lines REGEX "${pattern}")
    list(FILTER lines EXCLUDE REGEX "^ *//")
    if(lines AND header MATCHES "^(${owners})$")
      set(found TRUE)
    elseif(lines)
      string(APPEND violations "\n  ${header}: ${lines} (${pattern} belongs to ${owners})")
    endif()
  endforeach()
  if(NOT found)
    string(APPEND violations "\n  ${pattern}: in none of ${owners}")
  endif()
endforeach()
if(violations)
  message(FATAL_ERROR "facts with another owner:${violations}")
endif()
