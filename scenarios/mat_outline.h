// The structure of a MATLAB .mat file, checked to its last element before matio reads it.
//
// matio believes what a file says of itself: a few bytes that claim a struct of a billion fields keep it busy until
// memory ends. Whatever passes here has as many elements, names and bytes as it claims.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

namespace lacuna {

/// Throws InputError unless the file is of version 5 or 7, every variable lies within it, compressed ones inflate, and
/// numbers, text, structs and cells hold what their dimensions say. Version 7.3 (HDF5) is named as such; classes that
/// are none of these (objects, tables, functions, sparse matrices) are refused by name.
void check_mat_outline(const std::filesystem::path& file, const std::string& name);

}  // namespace lacuna
