# SPDX-License-Identifier: LGPL-2.1-or-later
# Copyright (C) 2026 by the Dovetail authors

# link_stand_ins(TARGET): programs of this build tree load empty libraries in place of those that the deal.II of
# Debian and its companions bring in and Dovetail never calls. To connect these takes more than half of the time in
# which a program starts (doc/user_guide/check.md). What is installed loads the true ones.
option(DOVETAIL_STAND_INS
       "Programs of the build tree do not load OpenCASCADE, Gmsh, Assimp, VTK, libcurl, libcrypto and X11" ON)

# find_library_of_deal_ii(RESULT): its path
function(find_library_of_deal_ii result)
  set(name ${DEAL_II_TARGET_RELEASE}) # deal.II may have been built as one of both only
  if(DEAL_II_TARGET_DEBUG AND (CMAKE_BUILD_TYPE STREQUAL Debug OR NOT name))
    set(name ${DEAL_II_TARGET_DEBUG})
  endif()
  get_target_property(path ${name} LOCATION)
  set(${result} ${path} PARENT_SCOPE)
endfunction()

set(stand_ins_folder ${CMAKE_BINARY_DIR}/stand_ins)

# make_stand_ins(RESULT): their paths with commas between, as the linker takes them; they are made once for a deal.II
function(make_stand_ins result)
  set(${result} "" PARENT_SCOPE)
  if(NOT DOVETAIL_STAND_INS OR NOT CMAKE_SYSTEM_NAME STREQUAL Linux OR CMAKE_BINARY_DIR MATCHES "[ ,]")
    file(REMOVE_RECURSE ${stand_ins_folder}) # tests/command_line looks there
    return()
  endif()
  find_library_of_deal_ii(deal_ii)
  set(maker ${CMAKE_SOURCE_DIR}/cmake/make_stand_ins)
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${deal_ii} ${maker})
  file(SIZE "${deal_ii}" size) # packages bring files with old dates
  file(TIMESTAMP "${deal_ii}" date)
  file(TIMESTAMP ${maker} date_of_maker)
  string(SHA1 key "${deal_ii} ${size} ${date} ${date_of_maker}")
  if(NOT EXISTS ${stand_ins_folder}/${key})
    execute_process(COMMAND ${maker} ${deal_ii} ${stand_ins_folder} ${CMAKE_CXX_COMPILER}
                    OUTPUT_VARIABLE paths ERROR_VARIABLE problem RESULT_VARIABLE status)
    if(status)
      message(STATUS "Programs load all libraries of deal.II: ${problem}")
      return()
    endif()
    file(WRITE ${stand_ins_folder}/${key} "${paths}")
  endif()
  file(READ ${stand_ins_folder}/${key} paths)
  string(STRIP "${paths}" paths)
  string(REPLACE "\n" "," paths "${paths}")
  set(${result} "${paths}" PARENT_SCOPE)
endfunction()

make_stand_ins(stand_ins)

function(link_stand_ins target)
  if(stand_ins)
    set_property(TARGET ${target} APPEND PROPERTY LINK_LIBRARIES # of this target only
                 -Wl,--push-state,--no-as-needed,${stand_ins},--pop-state)
    set_property(TARGET ${target} APPEND PROPERTY BUILD_RPATH ${stand_ins_folder})
    # what deal.II would call there is not defined, as linkers of programs notice
    target_link_options(${target} PUBLIC $<BUILD_INTERFACE:-Wl,--allow-shlib-undefined>)
  endif()
endfunction()
