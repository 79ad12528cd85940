# What an estimator does not have leaves no code: no symbol of BARE names a part that it lacks, and FULL, which has all,
# names each of them.                       cmake -DNM=nm -DBARE=bare.o -DFULL=full.o -P check_symbols.cmake

cmake_minimum_required(VERSION 3.25)

set(parts Imu Preintegration ImuFactors CameraTimeOffset TimeOffsetShift AlignmentWindow InverseDepthMeasurement
  DepthSensor LineKind EdgeFollowing LineTracker CollinearKind CollinearSegments CollinearTerms RollingShutter
  ReadoutEstimate ReadoutDerivatives)

foreach(object BARE FULL)
  execute_process(COMMAND "${NM}" --demangle --defined-only "${${object}}" OUTPUT_VARIABLE symbols
    COMMAND_ERROR_IS_FATAL ANY)
  if(NOT symbols MATCHES " T use\\(")
    message(FATAL_ERROR "${${object}} uses no estimator")
  endif()
  string(REPLACE "NoImu" "" symbols "${symbols}")  # the name of an absence is no part
  set(${object}_symbols "${symbols}")
  string(REGEX MATCHALL "\n" count "${symbols}")
  list(LENGTH count ${object}_count)
endforeach()

set(wrong "")
foreach(part IN LISTS parts)
  if(BARE_symbols MATCHES "[^A-Za-z]${part}[^\n]*")
    string(SUBSTRING "${CMAKE_MATCH_0}" 0 200 symbol)
    string(APPEND wrong "  ${part} in ${BARE}: ${symbol}\n")
  endif()
  if(NOT FULL_symbols MATCHES "[^A-Za-z]${part}")
    string(APPEND wrong "  no ${part} in ${FULL}: this test would not find it\n")
  endif()
endforeach()
if(wrong)
  message(FATAL_ERROR "what is absent left its name:\n${wrong}")
endif()
message(STATUS "${BARE_count} symbols name nothing that is absent; ${FULL_count} where all is there, not inlined")
