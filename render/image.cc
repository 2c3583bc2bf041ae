#include "render/image.h"

#include <png.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <stdexcept>
#include <string>

#include "scenarios/error.h"
#include "scenarios/files.h"

namespace lacuna {
namespace {

constexpr int kSheetGap = 6;  // pixels between the pictures of a contact sheet

std::string size_text(long width, long height) { return std::to_string(width) + " x " + std::to_string(height); }

void check_size(const std::string& where, long width, long height) {
  const auto fits = [](long side) { return side >= 1 && side <= kMaxImageSide; };
  if (!fits(width) || !fits(height)) {
    throw InputError(where, size_text(width, height) + " pixels",
                     "1 to " + std::to_string(kMaxImageSide) + " pixels a side");
  }
}

void check_image(const Image& image) {
  const auto fits = [](int side) { return side >= 1 && side <= kMaxImageSide; };
  if (!fits(image.width) || !fits(image.height) ||
      image.rgb.size() != 3 * static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height)) {
    throw std::invalid_argument("image of " + size_text(image.width, image.height) + " pixels holds " +
                                std::to_string(image.rgb.size()) + " bytes");
  }
}

png_image png_header(const Image& image) {
  png_image png;
  std::memset(&png, 0, sizeof png);
  png.version = PNG_IMAGE_VERSION;
  png.width = static_cast<png_uint_32>(image.width);
  png.height = static_cast<png_uint_32>(image.height);
  png.format = PNG_FORMAT_RGB;
  return png;
}

}  // namespace

Image Image::filled(int width, int height, std::uint8_t r, std::uint8_t g, std::uint8_t b) {
  check_size("picture size", width, height);
  Image image{width, height, {}};
  image.rgb.resize(3 * static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  for (std::size_t i = 0; i < image.rgb.size(); i += 3) {
    image.rgb[i] = r;
    image.rgb[i + 1] = g;
    image.rgb[i + 2] = b;
  }
  return image;
}

std::vector<std::uint8_t> encode_png(const Image& image) {
  check_image(image);
  png_image png = png_header(image);
  png_alloc_size_t bytes = PNG_IMAGE_PNG_SIZE_MAX(png);
  std::vector<std::uint8_t> buffer(bytes);
  if (!png_image_write_to_memory(&png, buffer.data(), &bytes, 0, image.rgb.data(), 0, nullptr)) {
    throw WorkError(std::string("libpng could not encode a picture: ") + png.message);
  }
  buffer.resize(bytes);
  return buffer;
}

void write_png(const std::filesystem::path& file, const Image& image) {
  const std::vector<std::uint8_t> bytes = encode_png(image);
  write_file_atomically(file, std::string(bytes.begin(), bytes.end()));
}

Image read_png(const std::filesystem::path& file) {
  png_image png;
  std::memset(&png, 0, sizeof png);
  png.version = PNG_IMAGE_VERSION;
  if (!png_image_begin_read_from_file(&png, file.c_str())) {
    throw InputError(file.string(), std::string("what libpng calls '") + png.message + "'", "a PNG picture");
  }
  if (png.width > static_cast<unsigned>(kMaxImageSide) || png.height > static_cast<unsigned>(kMaxImageSide)) {
    const long width = png.width, height = png.height;
    png_image_free(&png);
    check_size(file.string(), width, height);
  }
  png.format = PNG_FORMAT_RGB;
  Image image{static_cast<int>(png.width), static_cast<int>(png.height), {}};
  image.rgb.resize(PNG_IMAGE_SIZE(png));
  const png_color white{255, 255, 255};
  if (!png_image_finish_read(&png, &white, image.rgb.data(), 0, nullptr)) {
    throw InputError(file.string(), std::string("what libpng calls '") + png.message + "'", "a whole PNG picture");
  }
  return image;
}

ImageDifference compare_images(const Image& a, const Image& b, int tolerance) {
  check_image(a);
  check_image(b);
  if (a.width != b.width || a.height != b.height) {
    throw std::invalid_argument("pictures of " + size_text(a.width, a.height) + " and " + size_text(b.width, b.height) +
                                " pixels cannot be compared");
  }
  ImageDifference difference;
  std::uint64_t sum = 0, pixels_over = 0;
  const std::size_t pixels = a.rgb.size() / 3;
  for (std::size_t i = 0; i < pixels; ++i) {
    int worst = 0;
    for (std::size_t c = 3 * i; c < 3 * i + 3; ++c) {
      const int gap = std::abs(int{a.rgb[c]} - int{b.rgb[c]});
      worst = std::max(worst, gap);
      sum += static_cast<std::uint64_t>(gap);
    }
    if (worst > tolerance) ++pixels_over;
    if (worst > difference.max_channel) {
      difference.max_channel = worst;
      difference.x = static_cast<int>(i % static_cast<std::size_t>(a.width));
      difference.y = static_cast<int>(i / static_cast<std::size_t>(a.width));
    }
  }
  difference.mean_channel = static_cast<double>(sum) / static_cast<double>(a.rgb.size());
  difference.share_of_pixels_over_tolerance = static_cast<double>(pixels_over) / static_cast<double>(pixels);
  return difference;
}

Image contact_sheet(std::span<const Image> images, int columns) {
  if (images.empty() || columns < 1) throw std::invalid_argument("a contact sheet needs pictures and columns");
  int cell_width = 0, cell_height = 0;
  for (const Image& image : images) {
    check_image(image);
    cell_width = std::max(cell_width, image.width);
    cell_height = std::max(cell_height, image.height);
  }
  const long across = std::min<long>(columns, static_cast<long>(images.size()));
  const long down = (static_cast<long>(images.size()) + across - 1) / across;
  const long width = across * cell_width + (across - 1) * kSheetGap;
  const long height = down * cell_height + (down - 1) * kSheetGap;
  check_size("contact sheet", width, height);
  Image sheet = Image::filled(static_cast<int>(width), static_cast<int>(height), 255, 255, 255);
  for (std::size_t i = 0; i < images.size(); ++i) {
    const int left = static_cast<int>(static_cast<long>(i) % across) * (cell_width + kSheetGap);
    const int top = static_cast<int>(static_cast<long>(i) / across) * (cell_height + kSheetGap);
    for (int y = 0; y < images[i].height; ++y) {
      std::copy_n(images[i].pixel(0, y), 3 * static_cast<std::size_t>(images[i].width), sheet.pixel(left, top + y));
    }
  }
  return sheet;
}

}  // namespace lacuna
