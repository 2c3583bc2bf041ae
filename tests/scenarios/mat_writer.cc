#include "tests/scenarios/mat_writer.h"

#include <matio.h>

#include <stdexcept>

namespace lacuna::test {
namespace {

using Vectors = std::vector<std::pair<std::string, std::vector<double>>>;

matvar_t* to_variable(const std::string& name, const std::vector<double>& values) {
  std::size_t dims[2] = {values.size(), 1};
  return Mat_VarCreate(name.c_str(), MAT_C_DOUBLE, MAT_T_DOUBLE, 2, dims, const_cast<double*>(values.data()), 0);
}

void write(const std::filesystem::path& file, const std::vector<matvar_t*>& variables, bool compressed) {
  mat_t* mat = Mat_CreateVer(file.c_str(), nullptr, MAT_FT_MAT5);
  if (mat == nullptr) throw std::runtime_error("cannot create " + file.string());
  for (matvar_t* variable : variables) {
    Mat_VarWrite(mat, variable, compressed ? MAT_COMPRESSION_ZLIB : MAT_COMPRESSION_NONE);
    Mat_VarFree(variable);
  }
  Mat_Close(mat);
}

}  // namespace

void write_mat(const std::filesystem::path& file, const Vectors& vectors, bool compressed) {
  std::vector<matvar_t*> variables;
  for (const auto& [name, values] : vectors) variables.push_back(to_variable(name, values));
  write(file, variables, compressed);
}

void write_mat_struct(const std::filesystem::path& file, const std::string& name, const Vectors& vectors,
                      bool compressed) {
  std::vector<const char*> fields;
  for (const auto& entry : vectors) fields.push_back(entry.first.c_str());
  std::size_t dims[2] = {1, 1};
  matvar_t* variable = Mat_VarCreateStruct(name.c_str(), 2, dims, fields.data(), static_cast<unsigned>(fields.size()));
  for (const auto& [field, values] : vectors)
    Mat_VarSetStructFieldByName(variable, field.c_str(), 0, to_variable(field, values));
  write(file, {variable}, compressed);
}

}  // namespace lacuna::test
