// Writes MATLAB 7.3 files (HDF5) through matio, which is how the tests get files that MATLAB's users have.
#pragma once

#include <matio.h>

#include <filesystem>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

namespace lacuna::test {

class Hdf5MatWriter {
 public:
  explicit Hdf5MatWriter(const std::filesystem::path& file)
      : mat_(Mat_CreateVer(file.c_str(), nullptr, MAT_FT_MAT73), &Mat_Close) {
    if (!mat_) throw std::runtime_error("matio writes no version 7.3");
  }

  template <typename T>
  void vector(const std::string& name, matio_classes kind, matio_types type, std::vector<T> values,
              bool packed = false) {
    array(name, kind, type, std::move(values), 1, packed);
  }

  /// `columns` numbers in each row.
  template <typename T>
  void array(const std::string& name, matio_classes kind, matio_types type, std::vector<T> values, std::size_t columns,
             bool packed = false) {
    std::size_t dims[2] = {values.size() / columns, columns};
    write(Mat_VarCreate(name.c_str(), kind, type, 2, dims, values.data(), 0), packed);
  }

  /// One struct of column vectors.
  void structure(const std::string& name, const std::vector<std::pair<std::string, std::vector<double>>>& fields) {
    std::vector<const char*> names;
    for (const auto& [field, unused] : fields) names.push_back(field.c_str());
    std::size_t one[2] = {1, 1};
    matvar_t* out = Mat_VarCreateStruct(name.c_str(), 2, one, names.data(), static_cast<unsigned>(names.size()));
    for (const auto& [field, values] : fields) {
      std::size_t dims[2] = {values.size(), 1};
      std::vector<double> copy = values;
      Mat_VarSetStructFieldByName(out, field.c_str(), 0,
                                  Mat_VarCreate(field.c_str(), MAT_C_DOUBLE, MAT_T_DOUBLE, 2, dims, copy.data(), 0));
    }
    write(out, false);
  }

  void text(const std::string& name, const std::string& value) {
    std::size_t dims[2] = {1, value.size()};
    std::string copy = value;
    write(Mat_VarCreate(name.c_str(), MAT_C_CHAR, MAT_T_UINT8, 2, dims, copy.data(), 0), false);
  }

 private:
  void write(matvar_t* variable, bool packed) {
    const int state = Mat_VarWrite(mat_.get(), variable, packed ? MAT_COMPRESSION_ZLIB : MAT_COMPRESSION_NONE);
    Mat_VarFree(variable);
    if (state != 0) throw std::runtime_error("matio could not write");
  }

  std::unique_ptr<mat_t, int (*)(mat_t*)> mat_;
};

}  // namespace lacuna::test
