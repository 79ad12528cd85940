# The linked firmware holds no allocator and no exception machinery.      cmake -DNM=... -DELF=... -P check_symbols.cmake

cmake_minimum_required(VERSION 3.25)

execute_process(COMMAND "${NM}" --demangle "${ELF}" OUTPUT_VARIABLE symbols COMMAND_ERROR_IS_FATAL ANY)
if(NOT symbols MATCHES " T main\n")
  message(FATAL_ERROR "${ELF} has no main: nothing was linked")
endif()

set(forbidden "_?(malloc|calloc|realloc|free)(_r)?|_sbrk(_r)?|operator (new|delete).*|__cxa_(throw|allocate_exception).*"
  "_Unwind_RaiseException|__cxa_guard_.*|std::__throw_.*|typeinfo for .*")
list(JOIN forbidden "|" forbidden)
string(REGEX MATCHALL "[0-9a-f ]+ [A-Za-z] (${forbidden})\n" found "${symbols}")
if(found)
  list(JOIN found "  " found)
  message(FATAL_ERROR "symbols that firmware must not have:\n  ${found}")
endif()
string(REGEX MATCHALL "\n" count "${symbols}")
list(LENGTH count count)
message(STATUS "none of the ${count} symbols allocates or throws")
