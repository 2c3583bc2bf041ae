// What a page may hold in scripts: the library's own, byte for byte, and data that no browser runs.
#pragma once

#include <gtest/gtest.h>

#include <string>

#include "reports/html.h"
#include "reports/page_assets.h"

namespace lacuna {

/// The page without them and without the notice of the plotting library: what must hold no script at all. Expects that
/// no data can end its element.
inline std::string without_own_scripts(std::string page) {
  const auto cut = [&](const std::string& whole) {
    const std::size_t at = page.find(whole);
    if (at != std::string::npos) page.erase(at, whole.size());
  };
  for (const std::string_view code : {kPlotLibrary, kPageScripts})
    if (!code.empty()) cut("<script>" + std::string(code) + "</script>");
  cut(escape(kPlotLibraryLicence));
  const std::string open = "<script type=\"application/json\"", close = "</script>";
  for (std::size_t at = 0; (at = page.find(open, at)) != std::string::npos;) {
    const std::size_t begin = page.find('>', at) + 1, end = page.find('<', begin);
    EXPECT_EQ(page.compare(end, close.size(), close), 0) << page.substr(end, 40);
    page.erase(at, end + close.size() - at);
  }
  return page;
}

}  // namespace lacuna
