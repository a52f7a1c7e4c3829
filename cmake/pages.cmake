# SPDX-License-Identifier: Apache-2.0
# src/tools/pages/*.html become strings of the program, so that it needs no files beside itself. C++ limits the length
# of one literal; adjacent ones are joined.
set(pages_cpp "${CMAKE_BINARY_DIR}/generated/pages.cpp")

function(page_literal answer file)
  file(READ "${file}" text)
  set(literal "")
  string(LENGTH "${text}" length)
  set(at 0)
  while(at LESS length)
    string(SUBSTRING "${text}" ${at} 8000 part)
    string(APPEND literal "R\"~page~(${part})~page~\"\n")
    math(EXPR at "${at} + 8000")
  endwhile()
  set(${answer} "${literal}" PARENT_SCOPE)
endfunction()

set(bench_page "${PROJECT_SOURCE_DIR}/src/tools/pages/bench.html")
set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS "${bench_page}")
page_literal(literal "${bench_page}")
file(CONFIGURE OUTPUT "${pages_cpp}" CONTENT
     "#include \"tools/pages.h\"\nnamespace brume {\nconst std::string_view kBenchPage =\n@literal@;\n}\n" @ONLY)
target_sources(brume_tools PRIVATE "${pages_cpp}")
