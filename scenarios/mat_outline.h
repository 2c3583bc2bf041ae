// The frame of a MATLAB .mat file, checked before matio reads what is inside.
#pragma once

#include <filesystem>
#include <string>

namespace lacuna {

/// Throws InputError unless the file is of version 5 or 7 and every top-level element is a matrix, plain or compressed,
/// that lies within the file. Version 7.3 (HDF5) is named as such.
void check_mat_outline(const std::filesystem::path& file, const std::string& name);

}  // namespace lacuna
