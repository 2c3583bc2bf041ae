# One target carries the flags of all our code, so that every backend is compiled alike and timings compare.
find_program(CCACHE ccache)
if(CCACHE AND NOT CMAKE_CXX_COMPILER_LAUNCHER)
  # Paths below the sources are hashed relative to them, so that a second clone finds the first one's objects.
  set(CMAKE_CXX_COMPILER_LAUNCHER
    ${CMAKE_COMMAND} -E env CCACHE_BASEDIR=${CMAKE_SOURCE_DIR} CCACHE_NOHASHDIR=1 ${CCACHE})
endif()

add_library(lacuna_flags INTERFACE)
target_compile_features(lacuna_flags INTERFACE cxx_std_20)
target_compile_options(lacuna_flags INTERFACE
  -Wall -Wextra -Wshadow -Wfloat-conversion -Wnon-virtual-dtor -Woverloaded-virtual
  # Same bits for every build of one source: no fused multiply-add unless it is written.
  -ffp-contract=off -fno-math-errno
  -fno-semantic-interposition)
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND CMAKE_CXX_COMPILER_VERSION VERSION_LESS 13)
  # "literal" + std::to_string(n) warns at -O2 though it is right: GCC bug 105329.
  target_compile_options(lacuna_flags INTERFACE -Wno-restrict)
endif()
if(LACUNA_WERROR)
  target_compile_options(lacuna_flags INTERFACE -Werror)
endif()
if(LACUNA_SANITIZE)
  target_compile_options(lacuna_flags INTERFACE
    -fsanitize=${LACUNA_SANITIZE} -fno-sanitize-recover=all -fno-omit-frame-pointer ${LACUNA_SANITIZE_WITHOUT})
  target_link_options(lacuna_flags INTERFACE -fsanitize=${LACUNA_SANITIZE})
endif()
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_POSITION_INDEPENDENT_CODE ON)
set(CMAKE_CXX_VISIBILITY_PRESET default)

# For code whose time nobody measures: compiled in about half the time.
add_library(lacuna_unhurried INTERFACE)
if(LACUNA_SANITIZE)
  target_compile_options(lacuna_unhurried INTERFACE -O0)
else()
  target_compile_options(lacuna_unhurried INTERFACE $<$<CONFIG:Release>:-O1>)
endif()
