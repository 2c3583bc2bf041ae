// What is drawn over a finished picture: caption, rings about marked joints and their labels.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "render/snapshot.h"

namespace lacuna {

/// A line of text as coverage 0..255, rows from the top; larger than it is shown.
struct TextMask {
  int width = 0;
  int height = 0;
  std::vector<std::uint8_t> coverage;
};

/// Draws one line of printable ASCII.
using TextWriter = std::function<TextMask(const std::string&)>;

/// Sizes follow the picture's height, so a small picture is the large one seen from farther away.
void draw_overlay(const Robot& robot, std::span<const Eigen::Isometry3d> link_poses, const Camera& camera,
                  const SnapshotOptions& options, const TextWriter& write, Image& image);

}  // namespace lacuna
