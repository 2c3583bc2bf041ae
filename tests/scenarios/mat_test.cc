#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <map>

#include "scenarios/scenario.h"
#include "tests/scenarios/hdf5_mat_writer.h"
#include "tests/scenarios/mat_writer.h"
#include "tests/scenarios/support.h"

namespace lacuna {
namespace {

using test::Hdf5MatWriter;
using test::input_error;
using test::MatWriter;
using test::TemporaryFolder;
using testing::HasSubstr;

using Vectors = std::vector<std::pair<std::string, std::vector<double>>>;
const Vectors kVectors{{"t", {0, 0.1, 0.2}}, {"q_1", {1, std::nan(""), 3}}};

std::string bytes_of(const Vectors& vectors) {
  MatWriter writer(false);
  for (const auto& [name, values] : vectors) writer.vector<double>(name, 6, 9, values);
  return writer.bytes();
}

std::string refusal(const TemporaryFolder& folder, const std::string& bytes) {
  const auto file = folder.write("bad.mat", bytes);
  return input_error([&] { load_recording(file, "bad.mat"); });
}

TEST(Mat, ReadsVectorsOrOneStructOfThemPlainAndCompressed) {
  for (const char* name : {"vectors.mat", "vectors_compressed.mat", "struct.mat", "struct_compressed.mat"}) {
    const auto data = load_recording(std::filesystem::path(LACUNA_SOURCE_DIR) / "tests/scenarios/data" / name, name);
    EXPECT_EQ(data->names, (std::vector<std::string>{"t", "q_1"})) << name;
    EXPECT_EQ(data->columns[0], (std::vector<double>{0, 0.1, 0.2})) << name;
    EXPECT_EQ(data->columns[1][0], 1.0) << name;
    EXPECT_TRUE(std::isnan(data->columns[1][1])) << name;
    EXPECT_EQ(data->missing, 1u) << name;
  }
}

TEST(Mat, ReadsEveryNumericClassAndBothByteOrders) {
  for (const bool big_endian : {false, true}) {
    MatWriter writer(big_endian);
    writer.vector<double>("d", 6, 9, {1.5, 2.5});
    writer.vector<float>("f", 7, 7, {1.5f, -2.5f});
    writer.vector<std::int8_t>("i8", 8, 1, {-1, 2});
    writer.vector<std::uint8_t>("u8", 9, 2, {1, 255});
    writer.vector<std::int16_t>("i16", 10, 3, {-300, 300});
    writer.vector<std::uint16_t>("u16", 11, 4, {1, 65535});
    writer.vector<std::int32_t>("i32", 12, 5, {-70000, 70000});
    writer.vector<std::uint32_t>("u32", 13, 6, {1, 4000000000u});
    writer.vector<std::uint8_t>("packed", 6, 2, {3, 4});  // MATLAB stores whole doubles in fewer bytes
    const TemporaryFolder folder;
    const auto data = load_recording(folder.write("run.mat", writer.bytes()), "run.mat");
    ASSERT_EQ(data->columns.size(), 9u);
    const std::vector<std::vector<double>> expected{{1.5, 2.5}, {1.5, -2.5},     {-1, 2},  {1, 255}, {-300, 300},
                                                    {1, 65535}, {-70000, 70000}, {1, 4e9}, {3, 4}};
    EXPECT_EQ(data->columns, expected);
  }
}

TEST(Mat, SingleNumbersBesideVectorsAreNoColumns) {
  const TemporaryFolder folder;
  Vectors vectors = kVectors;
  vectors.emplace_back("rate", std::vector<double>{100.0});
  EXPECT_EQ(load_recording(folder.write("run.mat", bytes_of(vectors)), "run.mat")->names.size(), 2u);
}

TEST(Mat, ServesAScenarioLikeCsv) {
  const test::ScenarioFolder folder(test::replaced(
      test::replaced(test::kScenario, "run.csv, role: train", "run.mat, role: train"), "[run.csv]", "[run.mat]"));
  const auto csv = load_recording(folder.path() / "run.csv", "run.csv");
  Vectors vectors;
  for (std::size_t c = 0; c < csv->names.size(); ++c) vectors.emplace_back(csv->names[c], csv->columns[c]);
  folder.write("run.mat", bytes_of(vectors));
  const Scenario s = load_scenario(folder.file);
  EXPECT_EQ(s.recordings[0].data->columns[0], s.recordings[1].data->columns[0]);
}

TEST(Mat, RefusesWhatIsNoRecording) {
  const TemporaryFolder folder;
  EXPECT_THAT(refusal(folder, "MATLAB?"),
              HasSubstr("bad.mat: found 7 bytes, expected a MATLAB file of version 5, 7 or 7.3"));
  EXPECT_THAT(refusal(folder, std::string(4096, 'x')), HasSubstr("found no MATLAB 5 header"));
  MatWriter none(false);
  EXPECT_THAT(refusal(folder, none.bytes()), HasSubstr("bad.mat: found no numeric vectors"));
  std::string newer = none.bytes();
  newer[124] = 0;
  newer[125] = 2;
  EXPECT_THAT(refusal(folder, newer), HasSubstr("bad.mat: found no numeric vectors"));
}

TEST(MatHdf5, ReadsVectorsOrOneStructOfThemPlainAndCompressed) {
  for (const char* form : {"plain", "packed", "struct"}) {
    const TemporaryFolder folder;
    const auto file = folder.path() / "run.mat";
    const std::vector<double> q{1, std::nan(""), 3};
    {
      Hdf5MatWriter writer(file);
      if (form == std::string("struct")) {
        writer.structure("log", {{"t", {0, 0.1, 0.2}}, {"q_1", q}});
      } else {
        const bool packed = form == std::string("packed");
        writer.vector<double>("t", MAT_C_DOUBLE, MAT_T_DOUBLE, {0, 0.1, 0.2}, packed);
        writer.vector<double>("q_1", MAT_C_DOUBLE, MAT_T_DOUBLE, q, packed);
        writer.text("note", "a warm day");
        writer.vector<double>("rate", MAT_C_DOUBLE, MAT_T_DOUBLE, {10});
      }
    }
    const auto data = load_recording(file, "run.mat");
    ASSERT_EQ(data->names.size(), 2u) << form;
    EXPECT_EQ(data->columns[data->find("t")], (std::vector<double>{0, 0.1, 0.2})) << form;
    const auto& read = data->columns[data->find("q_1")];
    EXPECT_EQ(read[2], 3.0) << form;
    EXPECT_TRUE(std::isnan(read[1])) << form;
    EXPECT_EQ(data->missing, 1u) << form;
    EXPECT_EQ(data->file, "run.mat");
  }
}

TEST(MatHdf5, ReadsEveryNumericClass) {
  const TemporaryFolder folder;
  const auto file = folder.path() / "run.mat";
  {
    Hdf5MatWriter writer(file);
    writer.vector<double>("d", MAT_C_DOUBLE, MAT_T_DOUBLE, {1.5, -2.5});
    writer.vector<float>("f", MAT_C_SINGLE, MAT_T_SINGLE, {1.5f, -2.5f});
    writer.vector<std::int8_t>("i8", MAT_C_INT8, MAT_T_INT8, {-1, 2});
    writer.vector<std::uint8_t>("u8", MAT_C_UINT8, MAT_T_UINT8, {1, 255});
    writer.vector<std::int16_t>("i16", MAT_C_INT16, MAT_T_INT16, {-300, 300});
    writer.vector<std::uint16_t>("u16", MAT_C_UINT16, MAT_T_UINT16, {1, 65535});
    writer.vector<std::int32_t>("i32", MAT_C_INT32, MAT_T_INT32, {-70000, 70000});
    writer.vector<std::uint32_t>("u32", MAT_C_UINT32, MAT_T_UINT32, {1, 4000000000u});
    writer.vector<std::int64_t>("i64", MAT_C_INT64, MAT_T_INT64, {-5, 1'700'000'000'000});
    writer.vector<std::uint64_t>("u64", MAT_C_UINT64, MAT_T_UINT64, {5, 1'700'000'000'000});
  }
  const std::map<std::string, std::vector<double>> expected{
      {"d", {1.5, -2.5}},  {"f", {1.5, -2.5}},       {"i8", {-1, 2}},   {"u8", {1, 255}},      {"i16", {-300, 300}},
      {"u16", {1, 65535}}, {"i32", {-70000, 70000}}, {"u32", {1, 4e9}}, {"i64", {-5, 1.7e12}}, {"u64", {5, 1.7e12}}};
  const auto data = load_recording(file, "run.mat");
  EXPECT_EQ(data->names.size(), expected.size());
  for (const auto& [name, values] : expected)
    EXPECT_EQ(data->columns.at(static_cast<std::size_t>(data->find(name))), values) << name;
}

TEST(MatHdf5, RefusesWhatIsNoRecordingInTheSameWordsAsOtherVersions) {
  const TemporaryFolder folder;
  const auto file = folder.path() / "bad.mat";
  const auto refused = [&](auto&& fill) {
    {
      Hdf5MatWriter writer(file);
      fill(writer);
    }
    return input_error([&] { load_recording(file, "bad.mat"); });
  };
  EXPECT_THAT(refused([](Hdf5MatWriter& w) { w.text("note", "nothing"); }),
              HasSubstr("bad.mat: found no numeric vectors"));
  EXPECT_THAT(refused([](Hdf5MatWriter& w) {
                w.vector<double>("t", MAT_C_DOUBLE, MAT_T_DOUBLE, {0, 1, 2});
                w.vector<double>("q", MAT_C_DOUBLE, MAT_T_DOUBLE, {0, 1});
              }),
              HasSubstr("bad.mat: q: found 2 values, expected 3"));
  EXPECT_THAT(refused([](Hdf5MatWriter& w) {
                w.array<double>("q", MAT_C_DOUBLE, MAT_T_DOUBLE, {1, 2, 3, 4, 5, 6}, 2);
              }),
              HasSubstr("bad.mat: q: found an array of 3 x 2"));
  EXPECT_THAT(refused([](Hdf5MatWriter& w) {
                w.vector<double>("q", MAT_C_DOUBLE, MAT_T_DOUBLE, {0, std::numeric_limits<double>::infinity()});
              }),
              HasSubstr("bad.mat: q: found an infinite value at 2"));
}

/// Cut off anywhere it is refused, whatever the library makes of it.
TEST(MatHdf5, CutOffIsRefused) {
  const TemporaryFolder folder;
  const auto file = folder.path() / "run.mat";
  {
    Hdf5MatWriter writer(file);
    writer.vector<double>("t", MAT_C_DOUBLE, MAT_T_DOUBLE, std::vector<double>(500, 1.0));
  }
  const auto whole = std::filesystem::file_size(file);
  for (const std::uintmax_t bytes : {whole / 8, whole / 4, whole / 2, whole * 9 / 10}) {
    std::filesystem::copy_file(file, folder.path() / "bad.mat", std::filesystem::copy_options::overwrite_existing);
    std::filesystem::resize_file(folder.path() / "bad.mat", bytes);
    EXPECT_FALSE(input_error([&] { load_recording(folder.path() / "bad.mat", "bad.mat"); }).empty()) << bytes;
  }
}

TEST(Mat, RefusesVectorsThatDoNotFitTogether) {
  const TemporaryFolder folder;
  const auto refusal_of = [&](const Vectors& vectors) { return refusal(folder, bytes_of(vectors)); };
  EXPECT_THAT(refusal_of({{"t", {0, 1, 2}}, {"q", {1, 2}}}), HasSubstr("bad.mat: q: found 2 values, expected 3"));
  EXPECT_THAT(refusal_of({{"t", {0, std::numeric_limits<double>::infinity()}}}),
              HasSubstr("t: found an infinite value at 2"));
  MatWriter matrix(false);
  matrix.array<double>("m", 6, 9, 2, 2, {1, 2, 3, 4});
  EXPECT_THAT(refusal(folder, matrix.bytes()), HasSubstr("m: found an array of 2 x 2, expected a vector"));
  MatWriter twice(false);
  twice.vector<double>("t", 6, 9, {0, 1});
  twice.vector<double>("t", 6, 9, {0, 1});
  EXPECT_THAT(refusal(folder, twice.bytes()), HasSubstr("t: found the column twice"));
}

TEST(Mat, RefusesSizesThatTheFileCannotHold) {
  const TemporaryFolder folder;
  MatWriter writer(false);
  writer.array<double>("t", 6, 9, 2'000'000'000, 1, {0, 1});
  EXPECT_THAT(refusal(folder, writer.bytes()), HasSubstr("bad.mat: found 16 bytes for 2000000000 values"));
  std::string cut = bytes_of({{"t", {0, 1, 2, 3}}});
  cut.resize(cut.size() - 9);
  EXPECT_THAT(refusal(folder, cut), HasSubstr("expected an intact MATLAB file"));
}

TEST(Mat, RefusesACompressedStructThatLiesAboutItsFields) {
  // 187 bytes that keep matio alone busy until memory ends.
  const auto file = std::filesystem::path(LACUNA_SOURCE_DIR) / "tests/scenarios/data/lying_struct_compressed.mat";
  EXPECT_THAT(input_error([&] { load_recording(file, "lying.mat"); }),
              testing::AllOf(HasSubstr("lying.mat: found "), HasSubstr("expected an intact MATLAB file")));
}

TEST(Mat, RefusesOtherClassesByName) {
  MatWriter sparse(false);
  sparse.vector<double>("s", 5, 9, {1, 2});
  const TemporaryFolder folder;
  EXPECT_THAT(refusal(folder, sparse.bytes()),
              HasSubstr("found the variable \"s\" of array class 5, expected numeric vectors"));
}

}  // namespace
}  // namespace lacuna
