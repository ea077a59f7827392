# cheval_fuzz(NAME [MUTATIONS n] [UNIT n] SOURCES… LIBRARIES…) makes a fuzz target of a source that defines LLVMFuzzerTestOneInput and
# cheval::test::fuzzSeeds() (tests/support/fuzz.h):
#  - always the program NAME, which runs the seeds, their truncations and a fixed number of fixed mutations of them, and is a
#    test; `NAME FILE…` runs files instead, which is how a crash is looked at; `NAME --write-seeds FOLDER` writes the seeds;
#    MUTATIONS says how many of each seed (400), for a harness whose inputs take long; UNIT, that it reads whole units of so many
#    bytes, and ignores a rest, so that truncations within one would repeat each other;
#  - with CHEVAL_FUZZ=ON (preset `fuzz`: Clang and sanitizers) also NAME_libfuzzer, which searches, and searches briefly as a test.
option(CHEVAL_FUZZ "Build libFuzzer programs too (Clang with address sanitizer only)" OFF)  # Debian: clang-14 libclang-rt-14-dev
if(CHEVAL_FUZZ)
  if(NOT CMAKE_CXX_COMPILER_ID STREQUAL "Clang" OR NOT CHEVAL_SANITIZE MATCHES "address")
    message(FATAL_ERROR "CHEVAL_FUZZ needs Clang and CHEVAL_SANITIZE=address,undefined: use the preset `fuzz`")
  endif()
  target_compile_options(cheval_options INTERFACE -fsanitize=fuzzer-no-link)
endif()

function(cheval_fuzz name)
  cmake_parse_arguments(arg "" "MUTATIONS;UNIT" "SOURCES;LIBRARIES" ${ARGN})
  add_executable(${name} ${arg_SOURCES} "${PROJECT_SOURCE_DIR}/tests/support/fuzz_runner.cpp")
  foreach(limit MUTATIONS UNIT)
    if(arg_${limit})
      target_compile_definitions(${name} PRIVATE CHEVAL_FUZZ_${limit}=${arg_${limit}})
    endif()
  endforeach()
  target_link_libraries(${name} PRIVATE ${arg_LIBRARIES} cheval_options)
  add_test(NAME ${name} COMMAND ${name})
  set_tests_properties(${name} PROPERTIES TIMEOUT 300 LABELS fuzz)
  if(CHEVAL_FUZZ)
    add_executable(${name}_libfuzzer ${arg_SOURCES})
    target_link_libraries(${name}_libfuzzer PRIVATE ${arg_LIBRARIES} cheval_options)
    target_link_options(${name}_libfuzzer PRIVATE -fsanitize=fuzzer)
    set(corpus "${CMAKE_CURRENT_BINARY_DIR}/${name}_corpus")
    add_test(NAME ${name}_seeds COMMAND ${name} --write-seeds "${corpus}")
    set_tests_properties(${name}_seeds PROPERTIES FIXTURES_SETUP ${name}_corpus)
    add_test(NAME ${name}_libfuzzer COMMAND ${name}_libfuzzer -max_total_time=30 -timeout=10 -rss_limit_mb=2048 -print_final_stats=1 "${corpus}")
    set_tests_properties(${name}_libfuzzer PROPERTIES FIXTURES_REQUIRED ${name}_corpus TIMEOUT 120 LABELS fuzz)
  endif()
endfunction()
