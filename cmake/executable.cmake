# lacuna_executable(NAME SOURCE...): a program over the library, with the flags of all our code.
function(lacuna_executable name)
  add_executable(${name} ${ARGN})
  target_link_libraries(${name} PRIVATE lacuna::lacuna lacuna_flags)
  if(LACUNA_SANITIZE)
    target_sources(${name} PRIVATE ${PROJECT_SOURCE_DIR}/cmake/sanitizers/defaults.cc)
  endif()
endfunction()

# Tests of a sanitized build carry it in their name, so that one ctest can run over several builds.
if(LACUNA_SANITIZE)
  set(LACUNA_TEST_PREFIX "sanitized/")
else()
  set(LACUNA_TEST_PREFIX "")
endif()
