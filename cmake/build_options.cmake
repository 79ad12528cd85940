# What our own tests and programs are built with; nothing of it reaches a user of the targets.

add_library(plumbline_build_options INTERFACE)
target_compile_options(plumbline_build_options INTERFACE -Wall -Wextra -Wpedantic -Wshadow
  $<$<BOOL:${PLUMBLINE_WERROR}>:-Werror> $<$<BOOL:${PLUMBLINE_NATIVE}>:-march=native>
  # Two false alarms of GCC 12: Eigen's packet loop over a Vec<float, 3>, which never runs; "a" + std::to_string(b).
  $<$<CXX_COMPILER_ID:GNU>:-Wno-array-bounds$<SEMICOLON>-Wno-restrict>)
if(PLUMBLINE_SANITIZE)
  target_compile_options(plumbline_build_options INTERFACE -fsanitize=${PLUMBLINE_SANITIZE} -fno-sanitize-recover=all
    -fno-omit-frame-pointer)
  target_link_options(plumbline_build_options INTERFACE -fsanitize=${PLUMBLINE_SANITIZE})
endif()
