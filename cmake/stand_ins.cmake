# SPDX-License-Identifier: LGPL-2.1-or-later
# Copyright (C) 2026 by the Dovetail authors

# link_stand_ins(TARGET): programs of this build tree load empty libraries in place of those that the deal.II of Debian
# brings in and Dovetail never calls. To connect these takes more than half of the time in which a program starts
# (doc/user_guide/check.md). What is installed loads the true ones.
option(DOVETAIL_STAND_INS "Programs of the build tree do not load OpenCASCADE, Gmsh, Assimp and VTK" ON)

# stand_ins: their paths with commas between, as the linker takes them
set(stand_ins "")
set(stand_ins_folder ${CMAKE_BINARY_DIR}/stand_ins)
if(DOVETAIL_STAND_INS AND CMAKE_SYSTEM_NAME STREQUAL Linux AND NOT CMAKE_BINARY_DIR MATCHES "[ ,]")
  set(name ${DEAL_II_TARGET_RELEASE}) # deal.II may have been built as one of both only
  if(DEAL_II_TARGET_DEBUG AND (CMAKE_BUILD_TYPE STREQUAL Debug OR NOT name))
    set(name ${DEAL_II_TARGET_DEBUG})
  endif()
  get_target_property(deal_ii ${name} LOCATION)
  set(stand_ins_maker ${CMAKE_SOURCE_DIR}/cmake/make_stand_ins)
  file(SIZE "${deal_ii}" size) # packages bring files with old dates
  file(TIMESTAMP "${deal_ii}" date)
  file(TIMESTAMP ${stand_ins_maker} date_of_maker)
  string(SHA1 key "${deal_ii} ${size} ${date} ${date_of_maker}")
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${deal_ii} ${stand_ins_maker})
  if(NOT EXISTS ${stand_ins_folder}/${key})
    execute_process(COMMAND ${stand_ins_maker} ${deal_ii} ${stand_ins_folder} ${CMAKE_CXX_COMPILER}
                    OUTPUT_VARIABLE stand_ins ERROR_VARIABLE problem RESULT_VARIABLE status)
    if(status)
      message(STATUS "Programs load all libraries of deal.II: ${problem}")
      set(stand_ins "")
    else()
      file(WRITE ${stand_ins_folder}/${key} "${stand_ins}")
    endif()
  else()
    file(READ ${stand_ins_folder}/${key} stand_ins)
  endif()
  string(STRIP "${stand_ins}" stand_ins)
  string(REPLACE "\n" "," stand_ins "${stand_ins}")
else()
  file(REMOVE_RECURSE ${stand_ins_folder}) # tests/command_line looks there
endif()

function(link_stand_ins target)
  if(stand_ins)
    set_property(TARGET ${target} APPEND PROPERTY LINK_LIBRARIES # of this target only
                 -Wl,--push-state,--no-as-needed,${stand_ins},--pop-state)
    set_property(TARGET ${target} APPEND PROPERTY BUILD_RPATH ${stand_ins_folder})
    # what deal.II would call there is not defined, as linkers of programs notice
    target_link_options(${target} PUBLIC $<BUILD_INTERFACE:-Wl,--allow-shlib-undefined>)
  endif()
endfunction()
