set(engine_packages libdart-dev)
set(engine_headers "^dart/")
# Not by its own CMake package, which looks for every library that any of its parts can use.
find_path(DART_INCLUDE dart/simulation/World.hpp)
find_library(DART_LIBRARY dart)
set(engine_includes ${DART_INCLUDE})
set(engine_libraries ${DART_LIBRARY})
