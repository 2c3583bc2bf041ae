# cmake -P: writes OUTPUT, a C++ source with the bytes of SCRIPTS (one after the other), LIBRARY, STYLE and LICENCE (each
# may be empty) as the constants of reports/page_assets.h.
cmake_policy(SET CMP0007 NEW)

# The bytes of `files` as a C++ array and a view of it.
function(embed name)
  set(bytes "")
  foreach(file IN LISTS ARGN)
    file(READ "${file}" hex HEX)
    # What ends a script element, or changes how one ends, would do so in the page: `</script` in either case, `<!--`.
    string(TOLOWER "${hex}" hex)
    string(REGEX REPLACE "(..)" "\\1 " spaced "${hex}")
    if(spaced MATCHES "3c 2f [57]3 [46]3 [57]2 [46]9 [57]0 [57]4|3c 21 2d 2d")
      message(FATAL_ERROR "${file} holds </script or <!--, which cannot stand in a page's script")
    endif()
    string(APPEND bytes "${hex}")
  endforeach()
  string(REGEX REPLACE "(..)" "0x\\1," bytes "${bytes}")
  string(REGEX REPLACE "(0x..,0x..,0x..,0x..,0x..,0x..,0x..,0x..,0x..,0x..,0x..,0x..,0x..,0x..,0x..,0x..,)" "\\1\n" bytes "${bytes}")
  string(APPEND source "constexpr unsigned char ${name}_bytes[] = {${bytes}0};\n")
  string(APPEND views "const std::string_view ${name}(reinterpret_cast<const char*>(${name}_bytes), sizeof ${name}_bytes - 1);\n")
  set(source "${source}" PARENT_SCOPE)
  set(views "${views}" PARENT_SCOPE)
endfunction()

set(source "")
set(views "")
embed(kPageScripts ${SCRIPTS})
embed(kPlotLibrary ${LIBRARY})
embed(kPlotLibraryStyle ${STYLE})
embed(kPlotLibraryLicence ${LICENCE})
file(WRITE "${OUTPUT}" "// Written by cmake/embed.cmake.
#include \"reports/page_assets.h\"

namespace lacuna {
namespace {

${source}
}  // namespace

${views}
}  // namespace lacuna
")
