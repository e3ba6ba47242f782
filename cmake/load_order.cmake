# SPDX-License-Identifier: LGPL-2.1-or-later
# Copyright (C) 2026 by the Dovetail authors

# load_early(TARGET [dovetail_core]): a program names, before all others, those libraries in which the loader finds most
# of what deal.II and its companions ask for. The loader walks through the libraries in the order in which the program
# names them, and then through what these name; without this, some 50 000 symbols are looked for in 40 to 130 libraries
# each (doc/user_guide/check.md). The BLAS stands first, so that what it needs itself comes soon after.
function(load_early target)
  if(NOT CMAKE_SYSTEM_NAME STREQUAL Linux)
    target_link_libraries(${target} ${ARGN})
    return()
  endif()
  set(name ${DEAL_II_TARGET_RELEASE}) # deal.II may have been built as one of both only
  if(DEAL_II_TARGET_DEBUG AND (CMAKE_BUILD_TYPE STREQUAL Debug OR NOT name))
    set(name ${DEAL_II_TARGET_DEBUG})
  endif()
  get_target_property(deal_ii ${name} LOCATION)
  execute_process(COMMAND ldd ${deal_ii} OUTPUT_VARIABLE libraries ERROR_QUIET)
  string(REGEX MATCHALL "/[^ \n]*[.]so[^ \n]*" libraries "${libraries}")
  set(early ${ARGN} ${deal_ii})
  foreach(wanted blas trilinos_teuchosparameterlist "petsc(_real)?" trilinos_ml trilinos_ifpack trilinos_epetra sundials_idas
          trilinos_epetraext)
    set(found ${libraries})
    list(FILTER found INCLUDE REGEX "/lib${wanted}[.]so[.0-9]*$")
    if(wanted STREQUAL blas)
      list(PREPEND early ${found})
    else()
      list(APPEND early ${found})
    endif()
  endforeach()
  target_link_libraries(${target} -Wl,--push-state,--no-as-needed ${early} -Wl,--pop-state)
endfunction()
