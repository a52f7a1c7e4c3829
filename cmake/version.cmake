# SPDX-License-Identifier: Apache-2.0
# The version that images and statistics carry: that of the project, and the commit when this is a
# git checkout. A new commit configures again (git appends to logs/HEAD then), so it is never stale.
set(version "${PROJECT_VERSION}")
find_package(Git QUIET)

function(ask_git answer)
  execute_process(COMMAND ${GIT_EXECUTABLE} ${ARGN} WORKING_DIRECTORY ${PROJECT_SOURCE_DIR}
                  OUTPUT_VARIABLE text OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
  set(${answer} "${text}" PARENT_SCOPE)
endfunction()

if(Git_FOUND)
  ask_git(commit rev-parse --short HEAD)
  ask_git(log rev-parse --git-path logs/HEAD)
  if(commit AND log)
    cmake_path(ABSOLUTE_PATH log BASE_DIRECTORY ${PROJECT_SOURCE_DIR})
    if(EXISTS "${log}")
      set(version "${version} (commit ${commit})")
      set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS "${log}")
    endif()
  endif()
endif()
set_source_files_properties(src/core/version.cpp PROPERTIES COMPILE_DEFINITIONS "BRUME_VERSION=\"${version}\"")
