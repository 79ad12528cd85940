# Finds what plumbline::bag reads with: bzip2, SQLite, LZ4 and Zstandard. The last two have no module of CMake: the targets
# are plumbline_lz4 and plumbline_zstd.

find_package(BZip2 QUIET GLOBAL)
find_package(SQLite3 QUIET GLOBAL)

set(BagLibraries_FOUND FALSE)
if(BZIP2_FOUND AND SQLite3_FOUND)
  set(BagLibraries_FOUND TRUE)
endif()
foreach(entry lz4:lz4frame.h zstd:zstd.h)
  string(REPLACE ":" ";" entry "${entry}")
  list(GET entry 0 name)
  list(GET entry 1 header)
  find_library(BagLibraries_${name}_LIBRARY ${name})
  find_path(BagLibraries_${name}_INCLUDE_DIR ${header})
  mark_as_advanced(BagLibraries_${name}_LIBRARY BagLibraries_${name}_INCLUDE_DIR)
  if(BagLibraries_${name}_LIBRARY AND BagLibraries_${name}_INCLUDE_DIR)
    if(NOT TARGET plumbline_${name})
      add_library(plumbline_${name} UNKNOWN IMPORTED GLOBAL)
      set_target_properties(plumbline_${name} PROPERTIES IMPORTED_LOCATION "${BagLibraries_${name}_LIBRARY}"
        INTERFACE_INCLUDE_DIRECTORIES "${BagLibraries_${name}_INCLUDE_DIR}")
    endif()
  else()
    set(BagLibraries_FOUND FALSE)
  endif()
endforeach()
