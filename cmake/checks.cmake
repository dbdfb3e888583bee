# Tests in addition to those of the rooms: checks of style, tests of the Python code, whole scenes.
set(KEDGE_PYTHON /usr/bin/python3 CACHE FILEPATH "Python with numpy, scipy and matplotlib; Debian's by default")

foreach(check format floors core lengths)
  add_test(NAME check-${check} COMMAND ${KEDGE_PYTHON} ${PROJECT_SOURCE_DIR}/scripts/checks/check-${check})
  set_tests_properties(check-${check} PROPERTIES LABELS check SKIP_RETURN_CODE 77)
endforeach()
# clang reads all sources: four minutes of one core, so it begins early.
add_test(NAME check-clang COMMAND ${KEDGE_PYTHON} ${PROJECT_SOURCE_DIR}/scripts/checks/check-clang --jobs 1
                                  --build ${PROJECT_BINARY_DIR})
set_tests_properties(check-clang PROPERTIES LABELS check SKIP_RETURN_CODE 77 TIMEOUT 1800 COST 1000)

add_test(NAME python COMMAND ${KEDGE_PYTHON} -m unittest discover --start-directory ${PROJECT_SOURCE_DIR}/python/tests)
set_tests_properties(python PROPERTIES LABELS python)

# With sanitizers a scene takes ten times as long: the one on 1 to 7 ranks, a minute otherwise, takes 12.
set(scene_timeout 900)
if(KEDGE_SANITIZE)
  set(scene_timeout 3600)
endif()
file(GLOB scenes CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/tests/scenes/*.json)
foreach(scene ${scenes})
  get_filename_component(name ${scene} NAME_WE)
  add_test(NAME scene-${name}
           COMMAND ${KEDGE_PYTHON} ${PROJECT_SOURCE_DIR}/tests/scenes/run-scene ${scene} --program $<TARGET_FILE:kedge>)
  set_tests_properties(scene-${name} PROPERTIES LABELS scene TIMEOUT ${scene_timeout})
  file(STRINGS ${scene} two_ranks REGEX "\"ranks\": [2-9]")
  if(two_ranks)
    set_tests_properties(scene-${name} PROPERTIES PROCESSORS 2)
  endif()
endforeach()
add_test(NAME scene-restart COMMAND ${KEDGE_PYTHON} ${PROJECT_SOURCE_DIR}/tests/scenes/restart $<TARGET_FILE:kedge>)
set_tests_properties(scene-restart PROPERTIES LABELS scene TIMEOUT ${scene_timeout} PROCESSORS 2)

# The smallest form of each study: it runs, and its answers are near what they should be.
file(GLOB studies CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/benchmarks/*/*.study.json)
foreach(study ${studies})
  get_filename_component(folder ${study} DIRECTORY)
  get_filename_component(folder ${folder} NAME)
  get_filename_component(name ${study} NAME_WE)
  add_test(NAME study-${folder}-${name}
           COMMAND ${KEDGE_PYTHON} ${PROJECT_SOURCE_DIR}/python/kedge-study ${study} --quick --jobs 1 --again
                   --program $<TARGET_FILE:kedge> --output ${PROJECT_BINARY_DIR}/studies-test/${folder}/${name})
  set_tests_properties(study-${folder}-${name} PROPERTIES LABELS study TIMEOUT 300)
endforeach()
add_test(NAME command-line
         COMMAND ${KEDGE_PYTHON} ${PROJECT_SOURCE_DIR}/tests/program/command-line $<TARGET_FILE:kedge>)
set_tests_properties(command-line PROPERTIES LABELS scene TIMEOUT 300)
add_test(NAME faults COMMAND ${KEDGE_PYTHON} ${PROJECT_SOURCE_DIR}/tests/program/faults $<TARGET_FILE:kedge>)
set_tests_properties(faults PROPERTIES LABELS scene TIMEOUT 300 PROCESSORS 2)
add_test(NAME full-disk COMMAND ${KEDGE_PYTHON} ${PROJECT_SOURCE_DIR}/tests/program/full-disk $<TARGET_FILE:kedge>)
set_tests_properties(full-disk PROPERTIES LABELS scene TIMEOUT 600 PROCESSORS 2)
add_test(NAME replay COMMAND ${KEDGE_PYTHON} ${PROJECT_SOURCE_DIR}/tests/program/replay $<TARGET_FILE:kedge>
                             $<TARGET_FILE:kedge-replay>)
set_tests_properties(replay PROPERTIES LABELS scene TIMEOUT 300 PROCESSORS 2)
add_test(NAME restarts COMMAND ${KEDGE_PYTHON} ${PROJECT_SOURCE_DIR}/tests/program/restarts $<TARGET_FILE:kedge>)
set_tests_properties(restarts PROPERTIES LABELS scene TIMEOUT 600 PROCESSORS 2)
add_executable(fuzz-server tests/program/fuzz-server.cc)
target_link_libraries(fuzz-server PRIVATE kedge_simulation)
add_test(NAME fuzz COMMAND ${KEDGE_PYTHON} ${PROJECT_SOURCE_DIR}/tests/program/fuzz $<TARGET_FILE:fuzz-server>
                           --mutations 300 --runs 0.02 --limit $<IF:$<BOOL:${KEDGE_SANITIZE}>,40,5>
                           --keep ${PROJECT_BINARY_DIR}/fuzz-faults)
set_tests_properties(fuzz PROPERTIES LABELS scene TIMEOUT 600)
add_test(NAME soak COMMAND ${KEDGE_PYTHON} ${PROJECT_SOURCE_DIR}/tests/program/soak $<TARGET_FILE:kedge> --steps 600)
set_tests_properties(soak PROPERTIES LABELS scene TIMEOUT 600 PROCESSORS 2)
add_test(NAME soak-window COMMAND ${KEDGE_PYTHON} ${PROJECT_SOURCE_DIR}/tests/program/soak $<TARGET_FILE:kedge>
                                  --scene sled-in-window --steps 400)
set_tests_properties(soak-window PROPERTIES LABELS scene TIMEOUT 600 PROCESSORS 2)
add_test(NAME package COMMAND ${PROJECT_SOURCE_DIR}/tests/program/package ${PROJECT_BINARY_DIR})
set_tests_properties(package PROPERTIES LABELS package TIMEOUT 300)
add_test(NAME commit COMMAND ${KEDGE_PYTHON} ${PROJECT_SOURCE_DIR}/tests/program/commit ${CMAKE_COMMAND})
set_tests_properties(commit PROPERTIES LABELS check)
add_test(NAME benchmark-manufactured COMMAND ${KEDGE_PYTHON} ${PROJECT_SOURCE_DIR}/benchmarks/manufactured/verify)
set_tests_properties(benchmark-manufactured PROPERTIES LABELS python)
