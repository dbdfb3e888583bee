# Tests in addition to those of the rooms: checks of style, tests of the Python code, whole scenes.
set(KEDGE_PYTHON /usr/bin/python3 CACHE FILEPATH "Python with numpy and matplotlib; Debian's by default")

foreach(check format floors core lengths)
  add_test(NAME check-${check} COMMAND ${KEDGE_PYTHON} ${PROJECT_SOURCE_DIR}/scripts/checks/check-${check})
  set_tests_properties(check-${check} PROPERTIES LABELS check SKIP_RETURN_CODE 77)
endforeach()

add_test(NAME python COMMAND ${KEDGE_PYTHON} -m unittest discover --start-directory ${PROJECT_SOURCE_DIR}/python/tests)
set_tests_properties(python PROPERTIES LABELS python)

file(GLOB scenes CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/tests/scenes/*.json)
foreach(scene ${scenes})
  get_filename_component(name ${scene} NAME_WE)
  add_test(NAME scene-${name}
           COMMAND ${KEDGE_PYTHON} ${PROJECT_SOURCE_DIR}/tests/scenes/run-scene ${scene} --program $<TARGET_FILE:kedge>)
  set_tests_properties(scene-${name} PROPERTIES LABELS scene TIMEOUT 900)
  file(STRINGS ${scene} two_ranks REGEX "\"ranks\": 2")
  if(two_ranks)
    set_tests_properties(scene-${name} PROPERTIES PROCESSORS 2)
  endif()
endforeach()
add_test(NAME scene-restart COMMAND ${KEDGE_PYTHON} ${PROJECT_SOURCE_DIR}/tests/scenes/restart $<TARGET_FILE:kedge>)
set_tests_properties(scene-restart PROPERTIES LABELS scene TIMEOUT 900 PROCESSORS 2)
add_test(NAME command-line
         COMMAND ${KEDGE_PYTHON} ${PROJECT_SOURCE_DIR}/tests/program/command-line $<TARGET_FILE:kedge>)
set_tests_properties(command-line PROPERTIES LABELS scene TIMEOUT 300)
add_test(NAME commit COMMAND ${KEDGE_PYTHON} ${PROJECT_SOURCE_DIR}/tests/program/commit ${CMAKE_COMMAND})
set_tests_properties(commit PROPERTIES LABELS check)
add_test(NAME benchmark-manufactured COMMAND ${KEDGE_PYTHON} ${PROJECT_SOURCE_DIR}/benchmarks/manufactured/verify)
set_tests_properties(benchmark-manufactured PROPERTIES LABELS python)
