# SPDX-License-Identifier: LGPL-2.1-or-later
# Copyright (C) 2026 by the Dovetail authors

# link_stand_ins(TARGET): programs of this build tree load empty libraries in place of those that the deal.II of Debian
# brings in and Dovetail never calls. To connect these takes more than half of the time in which a program starts
# (doc/user_guide/check.md). What is installed loads the true ones.
option(DOVETAIL_STAND_INS "Programs of the build tree do not load OpenCASCADE, Gmsh, Assimp and VTK" ON)

function(link_stand_ins target)
  if(NOT DOVETAIL_STAND_INS OR NOT CMAKE_SYSTEM_NAME STREQUAL Linux OR CMAKE_BINARY_DIR MATCHES "[ ,]")
    return()
  endif()
  if(CMAKE_BUILD_TYPE STREQUAL Debug)
    get_target_property(deal_ii ${DEAL_II_TARGET_DEBUG} LOCATION)
  else()
    get_target_property(deal_ii ${DEAL_II_TARGET_RELEASE} LOCATION)
  endif()
  set(folder ${CMAKE_BINARY_DIR}/stand_ins)
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${deal_ii} ${CMAKE_SOURCE_DIR}/cmake/make_stand_ins)
  execute_process(COMMAND ${CMAKE_SOURCE_DIR}/cmake/make_stand_ins ${deal_ii} ${folder} ${CMAKE_CXX_COMPILER}
                  OUTPUT_VARIABLE libraries ERROR_VARIABLE problem RESULT_VARIABLE status)
  if(status)
    message(STATUS "Programs load all libraries of deal.II: ${problem}")
    return()
  endif()
  string(STRIP "${libraries}" libraries)
  if(libraries)
    string(REPLACE "\n" "," libraries "${libraries}")
    set_property(TARGET ${target} APPEND PROPERTY LINK_LIBRARIES # of this target only
                 -Wl,--push-state,--no-as-needed,${libraries},--pop-state)
    set_property(TARGET ${target} APPEND PROPERTY BUILD_RPATH ${folder})
    # what deal.II would call there is not defined, as linkers of programs notice
    target_link_options(${target} INTERFACE $<BUILD_INTERFACE:-Wl,--allow-shlib-undefined>)
  endif()
endfunction()
