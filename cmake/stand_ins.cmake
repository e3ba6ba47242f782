# SPDX-License-Identifier: LGPL-2.1-or-later
# Copyright (C) 2026 by the Dovetail authors

# link_stand_ins(TARGET): programs of this build tree load empty libraries in place of those that the deal.II of Debian
# brings in and Dovetail never calls. To connect these takes more than half of the time in which a program starts
# (doc/user_guide/check.md). What is installed loads the true ones.
option(DOVETAIL_STAND_INS "Programs of the build tree do not load OpenCASCADE, Gmsh, Assimp and VTK" ON)

# stand_ins: their paths with commas between, as the linker takes them
set(stand_ins "")
if(DOVETAIL_STAND_INS AND CMAKE_SYSTEM_NAME STREQUAL Linux AND NOT CMAKE_BINARY_DIR MATCHES "[ ,]")
  if(CMAKE_BUILD_TYPE STREQUAL Debug)
    get_target_property(deal_ii ${DEAL_II_TARGET_DEBUG} LOCATION)
  else()
    get_target_property(deal_ii ${DEAL_II_TARGET_RELEASE} LOCATION)
  endif()
  set(stand_ins_maker ${CMAKE_SOURCE_DIR}/cmake/make_stand_ins)
  set(stand_ins_folder ${CMAKE_BINARY_DIR}/stand_ins)
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${deal_ii} ${stand_ins_maker})
  if(${deal_ii} IS_NEWER_THAN ${stand_ins_folder}/made OR ${stand_ins_maker} IS_NEWER_THAN ${stand_ins_folder}/made)
    execute_process(COMMAND ${stand_ins_maker} ${deal_ii} ${stand_ins_folder} ${CMAKE_CXX_COMPILER}
                    OUTPUT_VARIABLE stand_ins ERROR_VARIABLE problem RESULT_VARIABLE status)
    if(status)
      message(STATUS "Programs load all libraries of deal.II: ${problem}")
      set(stand_ins "")
    else()
      file(WRITE ${stand_ins_folder}/made "${stand_ins}")
    endif()
  else()
    file(READ ${stand_ins_folder}/made stand_ins)
  endif()
  string(STRIP "${stand_ins}" stand_ins)
  string(REPLACE "\n" "," stand_ins "${stand_ins}")
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
