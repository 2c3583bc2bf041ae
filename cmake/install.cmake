# `cmake --install`: the program, the library with its headers, the bundled scenarios, and find_package(lacuna).
set(LACUNA_CMAKE_DIR ${CMAKE_INSTALL_LIBDIR}/cmake/lacuna)

# The installed program finds its library wherever the prefix is moved to.
if(TARGET lacuna_cli)
  file(RELATIVE_PATH LACUNA_BIN_TO_LIB ${CMAKE_INSTALL_FULL_BINDIR} ${CMAKE_INSTALL_FULL_LIBDIR})
  set_target_properties(lacuna_cli PROPERTIES INSTALL_RPATH "$ORIGIN/${LACUNA_BIN_TO_LIB}")
  install(TARGETS lacuna_cli RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
endif()

# The headers are C++20 and need Eigen; everything else stays inside the library.
target_compile_features(lacuna INTERFACE cxx_std_20)
install(TARGETS lacuna EXPORT lacunaTargets LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR})
if(TARGET lacuna_mpi)
  # Loaded by name from beside the library, whose folder it needs for its own link to it.
  set_target_properties(lacuna_mpi PROPERTIES INSTALL_RPATH "$ORIGIN")
  install(TARGETS lacuna_mpi LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR})
endif()
list(JOIN LACUNA_PACKAGE_ENGINES "|" engines)
foreach(room scenarios backends physics draft ga study diagnosis diff compare trial reports render)
  file(GLOB_RECURSE headers CONFIGURE_DEPENDS RELATIVE ${PROJECT_SOURCE_DIR} ${PROJECT_SOURCE_DIR}/${room}/*.h)
  # Headers over a library other than Eigen, and those of the generator, are ours alone.
  list(FILTER headers EXCLUDE REGEX "^backends/(${engines})/|^physics/lanes\\.h$|^reports/(json_text|packed)\\.h$|^render/osmesa\\.h$|^scenarios/generate/")
  foreach(header IN LISTS headers)
    get_filename_component(folder ${header} DIRECTORY)
    install(FILES ${PROJECT_SOURCE_DIR}/${header} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/lacuna/${folder})
  endforeach()
endforeach()

install(DIRECTORY ${PROJECT_SOURCE_DIR}/scenarios DESTINATION ${CMAKE_INSTALL_DATADIR}/lacuna
  FILES_MATCHING PATTERN *.yaml PATTERN *.urdf PATTERN *.csv PATTERN *.mat PATTERN *.md
  PATTERN generate EXCLUDE)
install(FILES ${PROJECT_SOURCE_DIR}/LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR})

install(EXPORT lacunaTargets NAMESPACE lacuna:: DESTINATION ${LACUNA_CMAKE_DIR})
configure_package_config_file(${PROJECT_SOURCE_DIR}/cmake/lacunaConfig.cmake.in
  ${PROJECT_BINARY_DIR}/cmake/lacunaConfig.cmake INSTALL_DESTINATION ${LACUNA_CMAKE_DIR}
  PATH_VARS CMAKE_INSTALL_DATADIR)
write_basic_package_version_file(${PROJECT_BINARY_DIR}/cmake/lacunaConfigVersion.cmake
  COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/cmake/lacunaConfig.cmake ${PROJECT_BINARY_DIR}/cmake/lacunaConfigVersion.cmake
  DESTINATION ${LACUNA_CMAKE_DIR})
