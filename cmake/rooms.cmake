# One static library per room (a folder below source/), linked to the rooms and packages that it names.

# Trilinos 13 has no modern targets for its include folders; this library gathers them.
add_library(trilinos INTERFACE)
set(folders ${Trilinos_INCLUDE_DIRS} ${Trilinos_TPL_INCLUDE_DIRS})
# One that scripts/build-trilinos has made lies below this folder, which no installed package may name.
list(TRANSFORM folders REPLACE "^(${PROJECT_SOURCE_DIR}/.*)$" "$<BUILD_INTERFACE:\\1>")
target_include_directories(trilinos SYSTEM INTERFACE ${folders})
target_link_libraries(trilinos INTERFACE ${Trilinos_LIBRARIES} ${Trilinos_TPL_LIBRARIES})
if(Trilinos_CXX_COMPILER_FLAGS MATCHES "-fopenmp") # its Kokkos has threads
  set(KEDGE_PRECOMPILED OFF) # which would take Kokkos from the Trilinos of deal.II
  find_package(OpenMP REQUIRED COMPONENTS CXX)
  target_link_libraries(trilinos INTERFACE OpenMP::OpenMP_CXX)
endif()
# One built for NVIDIA's GPUs needs its nvcc_wrapper as compiler here, too, and the same architecture.
if(Trilinos_CXX_COMPILER_FLAGS MATCHES "-arch=(sm_[0-9]+)")
  target_compile_options(trilinos INTERFACE --expt-extended-lambda --expt-relaxed-constexpr -arch=${CMAKE_MATCH_1})
  # A kernel that calls a function of the host's is only warned of, and hangs. Rooms without kernels may include
  # libraries that give such warnings.
  set(kedge_kernel_options "SHELL:-Xcudafe --diag_error=20011" "SHELL:-Xcudafe --diag_error=20014")
  target_link_options(trilinos INTERFACE -arch=${CMAKE_MATCH_1} -Wl,--as-needed)
  # Among Boost's integers of 128 bits, which CGAL includes, is a constant that g++ takes from nvcc only so.
  set_source_files_properties(source/bodies/overlapping_boxes.cc source/bodies/surface_crossing.cc
                              source/geometry/triangulation.cc PROPERTIES COMPILE_OPTIONS -fpermissive)
  set(KEDGE_PRECOMPILED OFF)
endif()

# One built for AMD's GPUs needs hipcc as compiler here, too, and the same architecture.
if(Trilinos_CXX_COMPILER_FLAGS MATCHES "--offload-arch=(gfx[0-9a-f]+)")
  target_compile_options(trilinos INTERFACE --offload-arch=${CMAKE_MATCH_1} -fno-gpu-rdc)
  target_link_options(trilinos INTERFACE --offload-arch=${CMAKE_MATCH_1})
  set(KEDGE_PRECOMPILED OFF)
endif()

# The same for deal.II, whose own macros would force its flags on every target. From 9.6 on it has a target without
# them, which knows the include folders of its packages.
add_library(deal.II INTERFACE)
if(TARGET dealii::dealii_release)
  target_link_libraries(deal.II INTERFACE dealii::dealii_release trilinos)
else()
  target_include_directories(deal.II SYSTEM INTERFACE ${DEAL_II_INCLUDE_DIRS})
  # libdeal.ii names the Trilinos that it needs itself; Kedge's, the target above, may be another one.
  set(libraries ${DEAL_II_LIBRARIES_RELEASE})
  list(FILTER libraries EXCLUDE REGEX "/libtrilinos_")
  target_link_libraries(deal.II INTERFACE ${libraries} trilinos)
endif()

# SuiteSparse of Debian 12 has no CMake files.
add_library(UMFPACK INTERFACE)
target_include_directories(UMFPACK SYSTEM INTERFACE ${UMFPACK_INCLUDE_DIR})
target_link_libraries(UMFPACK INTERFACE ${UMFPACK_LIBRARY})

add_library(muparser_if_there INTERFACE)
if(MUPARSER_INCLUDE_DIR AND MUPARSER_LIBRARY)
  target_include_directories(muparser_if_there SYSTEM INTERFACE ${MUPARSER_INCLUDE_DIR})
  target_link_libraries(muparser_if_there INTERFACE ${MUPARSER_LIBRARY})
  target_compile_definitions(muparser_if_there INTERFACE KEDGE_WITH_MUPARSER)
endif()

add_library(kedge_options INTERFACE)
target_include_directories(kedge_options INTERFACE $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/include>
                                                   $<INSTALL_INTERFACE:include>)
target_compile_options(kedge_options INTERFACE -Wall -Wextra -Wno-unused-parameter
  -Werror=switch # a switch over an enum must name every case
  -Wno-maybe-uninitialized # false alarms of GCC 12 inside Eigen and std::vector
  # nobody reads errno or traps floating-point exceptions: so loops with roots and choices become vectors
  -fno-math-errno -fno-trapping-math)
# MPI's C++ bindings are a third of the functions of a small object, and nothing calls them.
target_compile_definitions(kedge_options INTERFACE OMPI_SKIP_MPICXX MPICH_SKIP_MPICXX)
if(KEDGE_SANITIZE)
  # vptr would need the run-time types of libraries that are built without it. With checks against null pointers, which
  # end a program anyway, GCC no longer compares addresses at compile time.
  target_compile_options(kedge_options INTERFACE -fsanitize=address,undefined
    -fno-sanitize=vptr,null,nonnull-attribute,returns-nonnull-attribute -fno-sanitize-recover=all
    -fno-omit-frame-pointer)
  target_compile_definitions(kedge_options INTERFACE _GLIBCXX_ASSERTIONS)
  target_link_options(kedge_options INTERFACE -fsanitize=address,undefined)
endif()
if(KEDGE_NATIVE)
  target_compile_options(kedge_options INTERFACE -march=native)
endif()

# The headers of deal.II and Trilinos take longer to parse than Kedge's own code to compile: most rooms and tests share
# one of two precompiled headers. A target can share one only if it has the same compiler flags.
if(KEDGE_PRECOMPILED)
  foreach(kind trilinos deal.II)
    set(file ${PROJECT_BINARY_DIR}/precompiled_${kind}.cc)
    file(CONFIGURE OUTPUT ${file} CONTENT "// Stands for the precompiled headers of ${kind}.\n")
    add_library(precompiled_${kind} OBJECT ${file})
    target_link_libraries(precompiled_${kind} PRIVATE kedge_options ${kind} fmt::fmt Eigen3::Eigen MPI::MPI_CXX)
    set(headers <algorithm> <array> <cmath> <functional> <limits> <map> <memory> <optional> <string> <vector>
                <fmt/format.h> <Eigen/Dense> ${PROJECT_SOURCE_DIR}/include/kedge/base/tpetra.h)
    if(kind STREQUAL deal.II)
      list(APPEND headers <deal.II/distributed/tria.h> <deal.II/dofs/dof_handler.h> <deal.II/fe/mapping_cartesian.h>
                          <deal.II/particles/particle_handler.h>)
    endif()
    target_precompile_headers(precompiled_${kind} PRIVATE ${headers})
  endforeach()
endif()

# Lets a target share the precompiled header of a kind: trilinos or deal.II.
function(kedge_share_headers target kind)
  if(KEDGE_PRECOMPILED)
    target_precompile_headers(${target} REUSE_FROM precompiled_${kind})
  endif()
endfunction()

# kedge_room(name HEADERS ... KERNELS ROOMS ... HEADERS_OF ... LINKS ... PRIVATE_LINKS ...)
#   ROOMS          rooms that it may include and links
#   HEADERS_OF     rooms that it may include without linking; only scripts/checks/check-floors reads this list
#   LINKS          packages that it and every room above it links
#   PRIVATE_LINKS  packages that it alone links
#   HEADERS        precompiled headers that it shares, if any: trilinos or deal.II
#   KERNELS        it has kernels that run on a GPU
function(kedge_room name)
  set_property(GLOBAL APPEND PROPERTY KEDGE_ROOMS ${name})
  cmake_parse_arguments(ROOM "KERNELS" "HEADERS" "ROOMS;HEADERS_OF;LINKS;PRIVATE_LINKS" ${ARGN})
  file(GLOB sources CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/source/${name}/*.cc)
  list(TRANSFORM ROOM_ROOMS PREPEND kedge_)
  if(sources)
    add_library(kedge_${name} STATIC ${sources})
    target_link_libraries(kedge_${name} PUBLIC kedge_options ${ROOM_ROOMS} ${ROOM_LINKS} PRIVATE ${ROOM_PRIVATE_LINKS})
    if(ROOM_HEADERS)
      kedge_share_headers(kedge_${name} ${ROOM_HEADERS})
    endif()
    if(ROOM_KERNELS)
      target_compile_options(kedge_${name} PRIVATE ${kedge_kernel_options})
    endif()
  else()
    add_library(kedge_${name} INTERFACE)
    target_link_libraries(kedge_${name} INTERFACE kedge_options ${ROOM_ROOMS} ${ROOM_LINKS})
  endif()
endfunction()
