# SPDX-License-Identifier: LGPL-2.1-or-later
# Copyright (C) 2026 by the Dovetail authors

# compile_together(TARGET N FILES): up to N files of a folder at a time are one for the compiler. Names in their
# anonymous namespaces must differ, but for `registered`, of which each file may have its own.
function(compile_together target n files)
  if(CMAKE_VERSION VERSION_LESS 3.20)
    message(FATAL_ERROR "DOVETAIL_UNITY needs CMake 3.20 or newer.")
  endif()
  foreach(file ${files})
    get_filename_component(folder ${file} DIRECTORY)
    get_filename_component(folder ${folder} NAME)
    list(APPEND files_of_${folder} ${file})
    list(LENGTH files_of_${folder} number)
    math(EXPR batch "(${number} - 1) / ${n}")
    set_source_files_properties(${file} PROPERTIES UNITY_GROUP ${folder}_${batch})
  endforeach()
  # gcc takes files that are included for headers
  target_compile_options(${target} PRIVATE $<$<CXX_COMPILER_ID:GNU>:-Wno-subobject-linkage>)
  set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_MODE GROUP UNITY_BUILD_UNIQUE_ID UNIQUE_IN_FILE
                        UNITY_BUILD_CODE_BEFORE_INCLUDE "#undef registered\n#define registered UNIQUE_IN_FILE")
endfunction()

# add_unit_tests(FOLDER FILES): one program for all unit tests of a folder of tests/. It runs the test by whose name it
# is called, FOLDER.NAME, so links with these names stand in for programs. Each file is compiled in a namespace NAME,
# after the headers of all of them, and has its main() there, as run_test().
function(add_unit_tests folder files)
  set(target unit_tests.${folder})
  foreach(file ${files})
    get_filename_component(name ${file} NAME_WE)
    file(STRINGS ${file} headers_of_file REGEX "^#include ")
    list(APPEND headers ${headers_of_file})
    string(APPEND tests "namespace ${name} {\n#include \"${CMAKE_CURRENT_SOURCE_DIR}/${file}\"\n}\n")
    string(APPEND calls "  if (name == \"${folder}.${name}\")\n    return call(${name}::run_test, argc, argv);\n")
    list(APPEND links COMMAND ${CMAKE_COMMAND} -E create_symlink ${target} ${folder}.${name})
  endforeach()
  list(REMOVE_DUPLICATES headers)
  list(JOIN headers "\n" headers)
  configure_file(${CMAKE_SOURCE_DIR}/cmake/unit_tests.cc.in ${target}.cc @ONLY)

  add_executable(${target} ${CMAKE_CURRENT_BINARY_DIR}/${target}.cc)
  target_include_directories(${target} PRIVATE ${CMAKE_CURRENT_SOURCE_DIR}/${folder})
  load_early(${target} dovetail_core)
  set_up(${target})
  take_precompiled_headers(${target})
  add_custom_command(TARGET ${target} POST_BUILD ${links} WORKING_DIRECTORY ${CMAKE_CURRENT_BINARY_DIR})
endfunction()
