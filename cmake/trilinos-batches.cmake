# Included by Trilinos (CMAKE_PROJECT_Trilinos_INCLUDE) where scripts/build-trilinos builds it. Its files that
# instantiate one template each share most of their headers: compiled some at a time they take a third of the time.
function(batch target size)
  if(TARGET ${target})
    set(undefine "")
    foreach(macro ${ARGN}) # what each of its files defines anew
      string(APPEND undefine "#undef ${macro}\n")
    endforeach()
    set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE ${size}
                                               UNITY_BUILD_CODE_AFTER_INCLUDE "${undefine}")
  endif()
endfunction()

# After all targets are there.
cmake_language(DEFER CALL batch kokkoskernels 8)
cmake_language(DEFER CALL batch tpetra 6)
cmake_language(DEFER CALL batch ifpack2 6 LCLINST)
cmake_language(DEFER CALL batch xpetra 7 XPETRA_ETI_GROUP XPETRA_ETI_3ARGUMENT_HPP XPETRA_ETI_4ARGUMENT_HPP
               XPETRA_ETI_4ARG_MV_HPP)
cmake_language(DEFER CALL batch muelu 10 MUELU_ETI_GROUP MUELU_ETI_3ARGUMENT_HPP MUELU_ETI_4ARGUMENT_HPP)
