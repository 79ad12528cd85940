# What our own tests and programs are built with; nothing of it reaches a user of the targets.

add_library(plumbline_build_options INTERFACE)
target_compile_options(plumbline_build_options INTERFACE -Wall -Wextra -Wpedantic -Wshadow
  $<$<BOOL:${PLUMBLINE_WERROR}>:-Werror> $<$<BOOL:${PLUMBLINE_NATIVE}>:-march=native>
  # Two false alarms of GCC 12: Eigen's packet loop over a Vec<float, 3>, which never runs; "a" + std::to_string(b).
  $<$<CXX_COMPILER_ID:GNU>:-Wno-array-bounds$<SEMICOLON>-Wno-restrict>
  # The compiler need not collect its garbage before it has a gigabyte: up to a tenth less time.
  $<$<CXX_COMPILER_ID:GNU>:--param=ggc-min-heapsize=1000000>
  # And two of its AVX-512 intrinsics.
  $<$<AND:$<CXX_COMPILER_ID:GNU>,$<BOOL:${PLUMBLINE_NATIVE}>>:-Wno-maybe-uninitialized$<SEMICOLON>-Wno-uninitialized>)
if(PLUMBLINE_REPRODUCIBLE)  # docs/guide/firmware.md
  target_compile_options(plumbline_build_options INTERFACE -ffp-contract=off)
  target_compile_definitions(plumbline_build_options INTERFACE EIGEN_DONT_VECTORIZE PLUMBLINE_REPRODUCIBLE)
endif()
if(PLUMBLINE_SANITIZE)
  # Left out, for a third of the compile time: what AddressSanitizer or the processor finds as well. GCC's warning of
  # uninitialized variables is no use with sanitizers.
  target_compile_options(plumbline_build_options INTERFACE -fsanitize=${PLUMBLINE_SANITIZE}
    -fno-sanitize=null,vptr,alignment,object-size -fno-sanitize-recover=all -fno-omit-frame-pointer
    $<$<CXX_COMPILER_ID:GNU>:-Wno-maybe-uninitialized>)
  target_link_options(plumbline_build_options INTERFACE -fsanitize=${PLUMBLINE_SANITIZE})
endif()
