# SPDX-License-Identifier: LGPL-2.1-or-later
# Copyright (C) 2026 by the Dovetail authors

# The loader walks through the libraries in the order in which the program names them, and then through what these name.
# Without load_early() some 50 000 symbols are looked for in 40 to 130 libraries each (doc/user_guide/check.md). Those
# named here are where it finds most of what deal.II and its companions ask for. The BLAS stands first, so that what it
# needs itself comes soon after.
if(CMAKE_SYSTEM_NAME STREQUAL Linux)
  find_library_of_deal_ii(deal_ii)
  execute_process(COMMAND ldd ${deal_ii} OUTPUT_VARIABLE libraries ERROR_QUIET)
  string(REGEX MATCHALL "/[^ \n]*[.]so[^ \n]*" libraries "${libraries}")
  set(blas ${libraries})
  list(FILTER blas INCLUDE REGEX "/libblas[.]so[.0-9]*$")
  set(early ${deal_ii})
  foreach(wanted trilinos_teuchosparameterlist "petsc(_real)?" trilinos_ml trilinos_ifpack trilinos_epetra sundials_idas
          trilinos_epetraext)
    set(found ${libraries})
    list(FILTER found INCLUDE REGEX "/lib${wanted}[.]so[.0-9]*$")
    list(APPEND early ${found})
  endforeach()
endif()

# load_early(TARGET [dovetail_core]): the program names them before all others
function(load_early target)
  if(early)
    target_link_libraries(${target} -Wl,--push-state,--no-as-needed ${blas} ${ARGN} ${early} -Wl,--pop-state)
  else()
    target_link_libraries(${target} ${ARGN})
  endif()
endfunction()
