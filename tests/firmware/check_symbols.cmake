# The linked firmware holds no allocator, no exception machinery, no formatted output and no assertion of the C library;
# its sections are no larger than stated.
#
#   cmake -DNM=... -DELF=... [-DSIZE=... -DMAX_TEXT=<byte> -DMAX_MEMORY=<byte, without stack>] -P check_symbols.cmake

cmake_minimum_required(VERSION 3.25)

execute_process(COMMAND "${NM}" --demangle "${ELF}" OUTPUT_VARIABLE symbols COMMAND_ERROR_IS_FATAL ANY)
if(NOT symbols MATCHES " T main\n")
  message(FATAL_ERROR "${ELF} has no main: nothing was linked")
endif()

set(forbidden "_?(malloc|calloc|realloc|free)(_r)?|_sbrk(_r)?|operator (new|delete).*|__cxa_(throw|allocate_exception).*"
  "_Unwind_RaiseException|__cxa_guard_.*|std::__throw_.*|typeinfo for .*|_?v?[fs]?n?i?printf(_r)?|__assert(_func)?")
list(JOIN forbidden "|" forbidden)
string(REGEX MATCHALL "[0-9a-f ]+ [A-Za-z] (${forbidden})\n" found "${symbols}")
if(found)
  list(JOIN found "  " found)
  message(FATAL_ERROR "symbols that firmware must not have:\n  ${found}")
endif()
string(REGEX MATCHALL "\n" count "${symbols}")
list(LENGTH count count)
message(STATUS "none of the ${count} symbols allocates or throws")

if(SIZE)
  execute_process(COMMAND "${SIZE}" -A "${ELF}" OUTPUT_VARIABLE sections COMMAND_ERROR_IS_FATAL ANY)
  set(memory 0)
  foreach(section .text .data .bss .arena)
    if(NOT sections MATCHES "\n\\${section} +([0-9]+)")
      message(FATAL_ERROR "${ELF} has no section ${section}:\n${sections}")
    endif()
    if(section STREQUAL .text)
      set(text ${CMAKE_MATCH_1})
    else()
      math(EXPR memory "${memory} + ${CMAKE_MATCH_1}")
    endif()
  endforeach()
  foreach(part text memory)
    string(TOUPPER "MAX_${part}" limit)
    if(${part} GREATER ${limit})
      message(FATAL_ERROR "${part}: ${${part}} bytes, more than ${${limit}}")
    endif()
    message(STATUS "${part}: ${${part}} of ${${limit}} bytes")
  endforeach()
endif()
