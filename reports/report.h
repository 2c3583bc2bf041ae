// The reports that people read, and the records beside them.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "diagnosis/diagnosis.h"
#include "reports/context.h"

namespace lacuna {

/// A pose snapshot or any other picture, drawn by the caller (render/).
struct Picture {
  std::string title;
  std::vector<std::uint8_t> png;  ///< the bytes of a PNG file
};

/// The page alone.
std::string diagnosis_page(const Scenario& scenario, const Diagnosis& diagnosis, const Context& context,
                           std::span<const Picture> pictures);
/// One fit per engine, the first one leading. `traces` (their `after` is the fit, `before` may be empty) are plotted.
std::string fit_page(const Scenario& scenario, std::span<const FitResult> fits, const Context& context,
                     std::span<const Picture> pictures, std::span<const Trace> traces = {});

/// `diagnosis.json` and `report.html` in `folder`, created where it is missing, each whole or not at all, and the
/// commands that would separate the members of a class (`separation_file`). Returns their names. Throws WriteError
/// where they cannot be written.
std::vector<std::string> write_diagnosis_report(const std::filesystem::path& folder, const Scenario& scenario,
                                                const Diagnosis& diagnosis, const Context& context,
                                                std::span<const Picture> pictures);

/// `fit.json` and `report.html`, likewise.
void write_fit_report(const std::filesystem::path& folder, const Scenario& scenario, std::span<const FitResult> fits,
                      const Context& context, std::span<const Picture> pictures, std::span<const Trace> traces = {});
void write_fit_report(const std::filesystem::path& folder, const Scenario& scenario, const FitResult& fit,
                      const Context& context, std::span<const Picture> pictures, std::span<const Trace> traces = {});

}  // namespace lacuna
