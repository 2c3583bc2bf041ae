# Engines that need a package: a folder backends/NAME with an engine.cmake, which sets
#   engine_packages   the Debian packages (scripts/packages.bash installs what this line names)
#   engine_headers    a regular expression of their headers, which only this folder may include (test `architecture`)
#   engine_includes   where CMake found the headers
#   engine_libraries  what to link; what was not found ends in -NOTFOUND, as find_path and find_library leave it
# Each has an option LACUNA_WITH_NAME. Without its package, a written source stands in that says why it is missing.
#
# Sets LACUNA_PACKAGE_ENGINES (all names), LACUNA_ENGINE_INCLUDES and LACUNA_ENGINE_LIBRARIES (of those that are built),
# LACUNA_ENGINE_SOURCES (theirs, each a unit of its own in a unity build: engines' headers do not bear each other) and
# LACUNA_MISSING_ENGINES (the written sources); turns off LACUNA_WITH_NAME where the package is missing.
option(LACUNA_WITH_ENGINES "Build the backends that need a package (each has an option of its own, LACUNA_WITH_NAME)" ON)

foreach(variable PACKAGE_ENGINES ENGINE_INCLUDES ENGINE_LIBRARIES ENGINE_SOURCES MISSING_ENGINES)
  set(LACUNA_${variable} "")
endforeach()
file(GLOB files CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/backends/*/engine.cmake)
foreach(file IN LISTS files)
  get_filename_component(folder ${file} DIRECTORY)
  get_filename_component(engine ${folder} NAME)
  string(TOUPPER ${engine} ENGINE)
  list(APPEND LACUNA_PACKAGE_ENGINES ${engine})
  option(LACUNA_WITH_${ENGINE} "Build the ${engine} backend" ${LACUNA_WITH_ENGINES})
  include(${file})
  list(JOIN engine_packages ", " engine_words)
  set(found ${engine_includes} ${engine_libraries})
  if(LACUNA_WITH_${ENGINE} AND (NOT engine_includes OR NOT engine_libraries OR found MATCHES "NOTFOUND"))
    message(STATUS "${engine} not found (${engine_words}): its backend will only say so")
    set(LACUNA_WITH_${ENGINE} OFF)
  endif()
  if(LACUNA_WITH_${ENGINE})
    list(APPEND LACUNA_ENGINE_INCLUDES ${engine_includes})
    list(APPEND LACUNA_ENGINE_LIBRARIES ${engine_libraries})
    file(GLOB sources CONFIGURE_DEPENDS ${folder}/*.cc)
    list(APPEND LACUNA_ENGINE_SOURCES ${sources})
  else()
    set(missing ${PROJECT_BINARY_DIR}/generated/missing_${engine}.cc)
    configure_file(${PROJECT_SOURCE_DIR}/cmake/missing_engine.cc.in ${missing} @ONLY)
    list(APPEND LACUNA_MISSING_ENGINES ${missing})
  endif()
endforeach()
