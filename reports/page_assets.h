// What a page runs in the browser, as bytes of the library (cmake/embed.cmake): an installed program needs no files.
#pragma once

#include <string_view>

namespace lacuna {

/// Our own scripts, reports/page/*.js in the order of their names.
extern const std::string_view kPageScripts;

/// dygraphs, its style sheet and its licence; empty in a build without it, whose plots stay drawings.
extern const std::string_view kPlotLibrary, kPlotLibraryStyle, kPlotLibraryLicence;

}  // namespace lacuna
