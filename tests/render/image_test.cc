#include "render/image.h"

#include <gtest/gtest.h>

#include <fstream>
#include <stdexcept>
#include <string>

#include "scenarios/error.h"
#include "scenarios/files.h"

namespace lacuna {
namespace {

namespace fs = std::filesystem;

Image pattern(int width, int height) {
  Image image = Image::filled(width, height, 0, 0, 0);
  for (std::size_t i = 0; i < image.rgb.size(); ++i) image.rgb[i] = static_cast<std::uint8_t>((i * 37 + i / 11) & 255);
  return image;
}

class ImageFile : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::path(::testing::TempDir()) /
              (std::string("lacuna_image_") + ::testing::UnitTest::GetInstance()->current_test_info()->name());
    fs::remove_all(folder_);
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  fs::path folder_;
};

TEST_F(ImageFile, PngRoundTripKeepsEveryByte) {
  for (const auto& [width, height] : {std::pair{1, 1}, {7, 3}, {640, 481}}) {
    const Image image = pattern(width, height);
    write_png(folder_ / "a.png", image);
    const Image back = read_png(folder_ / "a.png");
    EXPECT_EQ(back.width, width);
    EXPECT_EQ(back.height, height);
    EXPECT_EQ(back.rgb, image.rgb);
  }
}

TEST_F(ImageFile, WritingLeavesOnePictureAndNothingElse) {
  write_png(folder_ / "a.png", pattern(20, 10));
  write_png(folder_ / "a.png", pattern(30, 10));
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_), fs::directory_iterator()), 1);
  EXPECT_EQ(read_png(folder_ / "a.png").width, 30);
}

TEST_F(ImageFile, FailedWriteSaysWhereAndLeavesNothing) {
  fs::create_directories(folder_ / "taken.png" / "inside");
  EXPECT_THROW(write_png(folder_ / "taken.png", pattern(4, 4)), WriteError);
  std::ofstream(folder_ / "file");
  EXPECT_THROW(write_png(folder_ / "file" / "a.png", pattern(4, 4)), WriteError);
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_), fs::directory_iterator()), 2);
}

TEST_F(ImageFile, WhatIsNotAWholePngIsRefused) {
  const std::vector<std::uint8_t> whole = encode_png(pattern(64, 64));
  const auto write = [&](const std::string& name, std::size_t bytes) {
    std::ofstream(folder_ / name, std::ios::binary)
        .write(reinterpret_cast<const char*>(whole.data()), static_cast<std::streamsize>(bytes));
  };
  write("empty.png", 0);
  write("head.png", 20);
  write("half.png", whole.size() / 2);
  std::ofstream(folder_ / "text.png") << "not a picture";
  for (const char* name : {"empty.png", "head.png", "half.png", "text.png", "absent.png"}) {
    EXPECT_THROW(read_png(folder_ / name), InputError) << name;
  }
}

TEST_F(ImageFile, PngWiderThanTheLimitIsRefusedBeforeItIsRead) {
  std::vector<std::uint8_t> bytes = encode_png(pattern(8, 8));
  bytes[16] = 0x00, bytes[17] = 0x01, bytes[18] = 0x00, bytes[19] = 0x00;  // IHDR: width 65,536
  std::ofstream(folder_ / "wide.png", std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  EXPECT_THROW(read_png(folder_ / "wide.png"), InputError);
}

TEST(Image, SizesOutOfRangeAreRefused) {
  for (const auto& [width, height] :
       {std::pair{0, 10}, {10, 0}, {-1, 10}, {kMaxImageSide + 1, 10}, {10, kMaxImageSide + 1}}) {
    EXPECT_THROW(Image::filled(width, height, 0, 0, 0), InputError) << width << " x " << height;
  }
}

TEST(Image, BrokenImagesAreNotEncoded) {
  Image image = pattern(5, 5);
  image.rgb.pop_back();
  EXPECT_THROW(encode_png(image), std::invalid_argument);
  EXPECT_THROW(encode_png(Image{}), std::invalid_argument);
}

TEST(CompareImages, FindsTheWorstPixelAndTheShareOverTolerance) {
  const Image a = Image::filled(10, 5, 100, 100, 100);
  Image b = a;
  b.pixel(3, 2)[1] = 140;
  b.pixel(9, 4)[0] = 95;
  const ImageDifference difference = compare_images(a, b, 5);
  EXPECT_EQ(difference.max_channel, 40);
  EXPECT_EQ(difference.x, 3);
  EXPECT_EQ(difference.y, 2);
  EXPECT_DOUBLE_EQ(difference.share_of_pixels_over_tolerance, 1.0 / 50.0);
  EXPECT_DOUBLE_EQ(difference.mean_channel, 45.0 / 150.0);
  EXPECT_DOUBLE_EQ(compare_images(a, b, 4).share_of_pixels_over_tolerance, 2.0 / 50.0);
  EXPECT_THROW(compare_images(a, pattern(5, 10), 0), std::invalid_argument);
}

TEST(ContactSheet, PutsPicturesRowByRow) {
  std::vector<Image> images;
  for (int i = 0; i < 3; ++i) images.push_back(Image::filled(40, 30, static_cast<std::uint8_t>(50 * i + 10), 0, 0));
  const Image sheet = contact_sheet(images, 2);
  const int right = sheet.width - 20, low = sheet.height - 15;
  EXPECT_GT(sheet.width, 80);
  EXPECT_GT(sheet.height, 60);
  EXPECT_EQ(sheet.pixel(20, 15)[0], 10);
  EXPECT_EQ(sheet.pixel(right, 15)[0], 60);
  EXPECT_EQ(sheet.pixel(20, low)[0], 110);
  EXPECT_EQ(sheet.pixel(right, low)[1], 255) << "the free cell is white";
}

TEST(ContactSheet, RefusesNoPicturesNoColumnsAndTooMuch) {
  const std::vector<Image> wide(3, Image::filled(4000, 1, 0, 0, 0));
  EXPECT_THROW(contact_sheet({}, 2), std::invalid_argument);
  EXPECT_THROW(contact_sheet(wide, 0), std::invalid_argument);
  EXPECT_THROW(contact_sheet(wide, 3), InputError);
}

}  // namespace
}  // namespace lacuna
