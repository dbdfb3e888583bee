# cmake -DROOT=<folder of the repository> -DFILE=<source file to write> -P commit.cmake
# Writes the function kedge::commit(), which names the commit that the program is built from. An unchanged file is left
# alone, so that nothing is compiled again.
set(paths source include cmake CMakeLists.txt)

function(git result)
  execute_process(
    COMMAND git ${ARGN}
    WORKING_DIRECTORY ${ROOT}
    OUTPUT_VARIABLE text
    OUTPUT_STRIP_TRAILING_WHITESPACE
    ERROR_QUIET
    RESULT_VARIABLE code)
  if(NOT code EQUAL 0)
    set(text "")
  endif()
  set(${result} "${text}" PARENT_SCOPE)
endfunction()

git(commit log -1 --format=%h -- ${paths})
if(commit STREQUAL "")
  set(commit unknown) # git is missing, or this is no checkout of Kedge
else()
  git(changes diff HEAD --binary --no-ext-diff --no-color -- ${paths})
  git(new_files ls-files --others --exclude-standard -- ${paths})
  if(NOT new_files STREQUAL "")
    string(REPLACE "\n" ";" new_files "${new_files}")
    foreach(new_file ${new_files})
      file(SHA256 ${ROOT}/${new_file} hash)
      string(APPEND changes "\n${new_file} ${hash}")
    endforeach()
  endif()
  if(NOT changes STREQUAL "")
    string(SHA256 hash "${changes}")
    string(SUBSTRING ${hash} 0 7 hash)
    string(APPEND commit -modified-${hash})
  endif()
endif()

set(content "// Written by cmake/commit.cmake.
#include <kedge/simulation/version.h>

std::string kedge::commit() { return \"${commit}\"; }
")
set(present "")
if(EXISTS ${FILE})
  file(READ ${FILE} present)
endif()
if(NOT content STREQUAL present)
  file(WRITE ${FILE} "${content}")
endif()
