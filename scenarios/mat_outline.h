// The structure of a MATLAB .mat file, checked to its last element before matio reads it.
//
// matio believes what a file says of itself: a few bytes that claim a struct of a billion fields keep it busy until
// memory ends. Whatever passes here has as many elements, names and bytes as it claims.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

namespace lacuna {

enum class MatForm {
  five,  ///< version 5 and its compressed form, 7
  hdf5   ///< version 7.3
};

/// Throws InputError unless the file is of version 5, 7 or 7.3. Of 5 and 7 every variable must lie within it,
/// compressed ones inflate, and numbers, text, structs and cells hold what their dimensions say; classes that are none
/// of these (objects, tables, functions, sparse matrices) are refused by name. Of 7.3 (HDF5) only the beginning is
/// looked at.
MatForm check_mat_outline(const std::filesystem::path& file, const std::string& name);

}  // namespace lacuna
