# A source that holds what a page runs in the browser: the plotting library where there is one, and our own scripts.
# Sets LACUNA_PAGE_SOURCE.
set(LACUNA_PAGE_SOURCE ${PROJECT_BINARY_DIR}/generated/page_assets.cc)
file(GLOB LACUNA_PAGE_SCRIPTS CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/reports/page/*.js)  # sorted: the order they run in
add_custom_command(
  OUTPUT ${LACUNA_PAGE_SOURCE}
  COMMAND ${CMAKE_COMMAND} "-DOUTPUT=${LACUNA_PAGE_SOURCE}" "-DSCRIPTS=${LACUNA_PAGE_SCRIPTS}"
          "-DLIBRARY=${DYGRAPHS_SCRIPT}" "-DSTYLE=${DYGRAPHS_STYLE}" "-DLICENCE=${DYGRAPHS_LICENCE}"
          -P ${PROJECT_SOURCE_DIR}/cmake/embed.cmake
  DEPENDS ${LACUNA_PAGE_SCRIPTS} ${DYGRAPHS_SCRIPT} ${DYGRAPHS_STYLE} ${DYGRAPHS_LICENCE}
          ${PROJECT_SOURCE_DIR}/cmake/embed.cmake
  VERBATIM)
set_source_files_properties(${LACUNA_PAGE_SOURCE} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
