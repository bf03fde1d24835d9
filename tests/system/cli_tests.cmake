# Command lines of the relnav tool: outputs, exit status, messages. include()d by tests/system/CMakeLists.txt.
relnav_add_test_executable(NAME system_cli LABEL system TIMEOUT 240 SOURCES ${CMAKE_CURRENT_LIST_DIR}/cli_test.cpp
                           ${CMAKE_CURRENT_LIST_DIR}/cli_capture_test.cpp LIBRARIES relnav_hil)
target_compile_definitions(test_system_cli PRIVATE RELNAV_TOOL="$<TARGET_FILE:relnav>"
                                                   RELNAV_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
add_dependencies(test_system_cli relnav)
add_dependencies(sanitized_tests test_system_cli)
set_tests_properties(system_cli PROPERTIES LABELS "system;sanitized")  # short: the sanitizers run it too
