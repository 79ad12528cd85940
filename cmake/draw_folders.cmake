# Draws what the folders of the firmware headers include as a Mermaid graph in PAGE (docs/architecture.md): the block that
# begins with ```mermaid. An arrow that follows from others (a -> b -> c makes a -> c) is left out.
#
#   cmake -DFOLDERS=core;lie;... -DINCLUDE=include/plumbline -DPAGE=docs/architecture.md [-DCHECK=ON] -P draw_folders.cmake
#
# With CHECK the page stays as it is, and the script fails when it should not.

cmake_minimum_required(VERSION 3.25)

# The first folder of each floor, and the floor's name.
set(floor_core "mathematics")
set(floor_image "pixels")
set(floor_sensor "sensors")
set(floor_state "state")
set(floor_feature "features")
set(floor_factor "factors")
set(floor_propagation "policies")
set(floor_estimator "estimator")

set(boxes "")
set(arrows "")
set(end "")
foreach(folder IN LISTS FOLDERS)
  if(DEFINED floor_${folder})
    string(APPEND boxes "${end}  subgraph floor_${folder} [${floor_${folder}}]\n")
    set(end "  end\n")
  endif()
  string(APPEND boxes "    ${folder}\n")

  set(included "")
  file(GLOB headers "${INCLUDE}/${folder}/*.hpp")
  foreach(header IN LISTS headers)
    file(STRINGS "${header}" lines REGEX "^ *#include \"plumbline/[a-z_]+/")
    foreach(line IN LISTS lines)
      string(REGEX REPLACE ".*plumbline/([a-z_]+)/.*" "\\1" other "${line}")
      list(APPEND included ${other})
    endforeach()
  endforeach()
  list(REMOVE_DUPLICATES included)
  list(REMOVE_ITEM included ${folder})

  set(through_others "")  # what comes with the folders that are included: they come before in FOLDERS
  foreach(other IN LISTS included)
    list(APPEND through_others ${reached_by_${other}})
  endforeach()
  set(reached_by_${folder} ${included} ${through_others})
  foreach(other IN LISTS FOLDERS)
    if(other IN_LIST included AND NOT other IN_LIST through_others)
      string(APPEND arrows "  ${folder} --> ${other}\n")
    endif()
  endforeach()
endforeach()
set(graph "```mermaid\nflowchart TB\n${boxes}${end}${arrows}")

file(READ "${PAGE}" page)
string(FIND "${page}" "```mermaid\n" begin)
if(begin EQUAL -1)
  message(FATAL_ERROR "${PAGE} has no block that begins with ```mermaid")
endif()
string(SUBSTRING "${page}" 0 ${begin} before)
string(SUBSTRING "${page}" ${begin} -1 rest)
string(FIND "${rest}" "\n```\n" length)
math(EXPR length "${length} + 1")
string(SUBSTRING "${rest}" 0 ${length} drawn)
string(SUBSTRING "${rest}" ${length} -1 after)
if(drawn STREQUAL graph)
  message(STATUS "${PAGE} shows the folders as they are")
elseif(CHECK)
  message(FATAL_ERROR "${PAGE} does not show which folders include which today. Draw it again:\n"
    "  cmake --build --preset release --target draw_folders")
else()
  file(WRITE "${PAGE}" "${before}${graph}${after}")
endif()
