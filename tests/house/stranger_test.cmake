# A stranger's clone has no recordings beside it: it configures, says what it leaves out, and lists no test that needs them.
#   cmake -DSOURCE=… -DSCRATCH=… -DGENERATOR=… -P stranger_test.cmake
file(REMOVE_RECURSE "${SCRATCH}")
file(MAKE_DIRECTORY "${SCRATCH}")

# Configures into its own folder under SCRATCH; OUTPUT gets what CMake said, COUNT what it left out, TARGETS what it would build.
function(configure name data)
  execute_process(
    # Whether a container can be booted is another question, and no stranger's.
    COMMAND "${CMAKE_COMMAND}" -S "${SOURCE}" -B "${SCRATCH}/${name}" -G "${GENERATOR}" "-DCHEVAL_DATA=${data}" -DCHEVAL_CONTAINER=ON
    OUTPUT_VARIABLE output ERROR_VARIABLE output RESULT_VARIABLE result)
  if(NOT result EQUAL 0)
    message(FATAL_ERROR "Configuring with CHEVAL_DATA=${data} failed:\n${output}")
  endif()
  file(READ "${SCRATCH}/${name}/tests-left-out.txt" count)
  string(STRIP "${count}" count)
  execute_process(COMMAND "${CMAKE_COMMAND}" --build "${SCRATCH}/${name}" --target help OUTPUT_VARIABLE targets
    RESULT_VARIABLE result)
  if(NOT result EQUAL 0)
    message(FATAL_ERROR "The targets of ${name} cannot be listed.")
  endif()
  set(OUTPUT "${output}" PARENT_SCOPE)
  set(COUNT "${count}" PARENT_SCOPE)
  set(TARGETS "${targets}" PARENT_SCOPE)
endfunction()

# What a test of recordings is called, as the same tree registers it where there are some: an empty folder will do.
file(MAKE_DIRECTORY "${SCRATCH}/data/shoppers")
configure(with "${SCRATCH}/data")
if(NOT COUNT STREQUAL "0")
  message(FATAL_ERROR "${COUNT} test programs are left out although the recordings are there.")
endif()
set(targets_with "${TARGETS}")

configure(without "${SCRATCH}/no-such-folder")
if(NOT OUTPUT MATCHES "Left out, for want of CHEVAL_DATA: ([0-9]+) test programs: ([^\n]+)")
  message(FATAL_ERROR "CMake does not say what it leaves out:\n${OUTPUT}")
endif()
set(said "${CMAKE_MATCH_1}")
string(STRIP "${CMAKE_MATCH_2}" names)
list(LENGTH names length)
if(said EQUAL 0 OR NOT said EQUAL COUNT OR NOT said EQUAL length)
  message(FATAL_ERROR "CMake says ${said}, tests-left-out.txt ${COUNT}, and ${length} are named: ${names}")
endif()
foreach(name IN LISTS names)
  if(NOT targets_with MATCHES "(^|[ \n])${name}(:|[ \n])")
    message(FATAL_ERROR "${name} is left out, and is not built with the recordings either.")
  endif()
  if(TARGETS MATCHES "(^|[ \n])${name}(:|[ \n])")
    message(FATAL_ERROR "${name} would be built without the recordings that it needs.")
  endif()
endforeach()

# ctest lists what would run: a program that is not built yet is listed as <name>_NOT_BUILT.
execute_process(COMMAND "${CMAKE_CTEST_COMMAND}" --test-dir "${SCRATCH}/without" -N OUTPUT_VARIABLE listing RESULT_VARIABLE result)
if(NOT result EQUAL 0 OR NOT listing MATCHES "Total Tests: [1-9]")
  message(FATAL_ERROR "ctest lists nothing:\n${listing}")
endif()
foreach(name IN LISTS names)
  if(listing MATCHES "${name}")
    message(FATAL_ERROR "ctest would run ${name}:\n${listing}")
  endif()
endforeach()
file(REMOVE_RECURSE "${SCRATCH}")
