# SPDX-License-Identifier: Apache-2.0
# Headers that most sources include, parsed once: that was more than half of a build's time. Sources still include
# what they use; -DBRUME_PCH=OFF shows where one does not.
if(NOT BRUME_PCH)
  return()
endif()
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  # In precompiled headers GCC forgets that code is the system's, and reports std::string: false alarms like -Wrestrict's.
  target_compile_options(brume_options INTERFACE -Wno-array-bounds -Wno-stringop-overflow -Wno-stringop-overread)
  if(CMAKE_CXX_COMPILER_LAUNCHER MATCHES "ccache")
    target_compile_options(brume_options INTERFACE -fpch-preprocess)  # ccache asks for it
  endif()
endif()
target_precompile_headers(brume_core PRIVATE <core/math.h>
                          <algorithm> <array> <atomic> <bit> <cmath> <cstdint> <cstring> <filesystem> <functional>
                          <limits> <map> <memory> <numeric> <optional> <span> <string> <string_view> <utility> <vector>
                          <fmt/format.h>)
foreach(library IN LISTS BRUME_OBJECT_LIBRARIES)
  if(NOT library STREQUAL brume_core)
    target_precompile_headers(${library} REUSE_FROM brume_core)
  endif()
endforeach()
