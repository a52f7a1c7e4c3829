# SPDX-License-Identifier: Apache-2.0
# Coverage for libFuzzer, of what reads files alone: everywhere it would make the tests, which share this build, take
# twice as long. (What -fsanitize=fuzzer-no-link adds, without its check of precompiled headers.)
if(NOT BRUME_FUZZ)
  return()
endif()
file(GLOB_RECURSE readers CONFIGURE_DEPENDS src/core/parse/*.cpp src/core/io/*.cpp src/core/param*.cpp
     src/transport/photon_file.cpp src/shapes/*.cpp src/volumes/volumegrid.cpp src/materials/measured.cpp)
set_source_files_properties(${readers} PROPERTIES COMPILE_OPTIONS
                            -fsanitize-coverage=inline-8bit-counters,indirect-calls,trace-cmp,pc-table)
