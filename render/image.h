// Pictures as rows of RGB bytes: PNG in and out, comparison, contact sheets. Works in every build.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

namespace lacuna {

/// Width and height of any picture lie in 1..kMaxImageSide pixels.
inline constexpr int kMaxImageSide = 8192;

struct Image {
  int width = 0;
  int height = 0;
  std::vector<std::uint8_t> rgb;  ///< 3 * width * height bytes, rows from the top

  /// A picture of one colour. Throws InputError where a side is not in 1..kMaxImageSide.
  static Image filled(int width, int height, std::uint8_t r, std::uint8_t g, std::uint8_t b);

  std::uint8_t* pixel(int x, int y) { return rgb.data() + 3 * (static_cast<std::size_t>(y) * width + x); }
  const std::uint8_t* pixel(int x, int y) const { return rgb.data() + 3 * (static_cast<std::size_t>(y) * width + x); }
};

/// The bytes of a PNG file, 8 bit RGB. Throws std::invalid_argument for an Image that breaks its own rules.
std::vector<std::uint8_t> encode_png(const Image& image);

/// Writes `file` whole or not at all: a neighbour file is written first, then renamed. Throws WriteError.
void write_png(const std::filesystem::path& file, const Image& image);

/// Any PNG, reduced to 8 bit RGB (transparency over white). Throws InputError for what is not one, or is too large.
Image read_png(const std::filesystem::path& file);

struct ImageDifference {
  int max_channel = 0;                          ///< largest difference of one channel, 0..255
  int x = 0, y = 0;                             ///< where that is
  double mean_channel = 0.0;                    ///< mean absolute difference over all channels
  double share_of_pixels_over_tolerance = 0.0;  ///< 0..1, pixels with a channel further apart than the tolerance
};

/// Throws std::invalid_argument where sizes differ.
ImageDifference compare_images(const Image& a, const Image& b, int tolerance);

/// Pictures row by row on white, `columns` to a row, with thin gaps; each cell as large as the largest picture.
/// Throws std::invalid_argument for no pictures or columns < 1, InputError where the sheet exceeds kMaxImageSide.
Image contact_sheet(std::span<const Image> images, int columns);

}  // namespace lacuna
