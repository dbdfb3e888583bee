# One static library per room (a folder below source/), linked to the rooms and packages that it names.

# Trilinos 13 has no modern targets for its include folders; this library gathers them.
add_library(Trilinos INTERFACE)
target_include_directories(Trilinos SYSTEM INTERFACE ${Trilinos_INCLUDE_DIRS} ${Trilinos_TPL_INCLUDE_DIRS})
target_link_libraries(Trilinos INTERFACE ${Trilinos_LIBRARIES} ${Trilinos_TPL_LIBRARIES})

# The same for deal.II, whose own macros would force its flags on every target.
add_library(deal.II INTERFACE)
target_include_directories(deal.II SYSTEM INTERFACE ${DEAL_II_INCLUDE_DIRS})
target_link_libraries(deal.II INTERFACE ${DEAL_II_LIBRARIES_RELEASE} Trilinos)

# SuiteSparse of Debian 12 has no CMake files.
add_library(UMFPACK INTERFACE)
target_include_directories(UMFPACK SYSTEM INTERFACE ${UMFPACK_INCLUDE_DIR})
target_link_libraries(UMFPACK INTERFACE ${UMFPACK_LIBRARY})

add_library(kedge_options INTERFACE)
target_include_directories(kedge_options INTERFACE ${PROJECT_SOURCE_DIR}/include)
target_compile_options(kedge_options INTERFACE -Wall -Wextra -Wno-unused-parameter
  -Werror=switch # a switch over an enum must name every case
  -Wno-maybe-uninitialized) # false alarms of GCC 12 inside Eigen and std::vector
if(KEDGE_NATIVE)
  target_compile_options(kedge_options INTERFACE -march=native)
endif()

# kedge_room(name ROOMS ... HEADERS_OF ... LINKS ... PRIVATE_LINKS ...)
#   ROOMS          rooms that it may include and links
#   HEADERS_OF     rooms that it may include without linking; only scripts/checks/check-floors reads this list
#   LINKS          packages that it and every room above it links
#   PRIVATE_LINKS  packages that it alone links
function(kedge_room name)
  cmake_parse_arguments(ROOM "" "" "ROOMS;HEADERS_OF;LINKS;PRIVATE_LINKS" ${ARGN})
  file(GLOB sources CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/source/${name}/*.cc)
  list(TRANSFORM ROOM_ROOMS PREPEND kedge_)
  if(sources)
    add_library(kedge_${name} STATIC ${sources})
    target_link_libraries(kedge_${name} PUBLIC kedge_options ${ROOM_ROOMS} ${ROOM_LINKS} PRIVATE ${ROOM_PRIVATE_LINKS})
  else()
    add_library(kedge_${name} INTERFACE)
    target_link_libraries(kedge_${name} INTERFACE kedge_options ${ROOM_ROOMS} ${ROOM_LINKS})
  endif()
endfunction()
