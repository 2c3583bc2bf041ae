#include "render/overlay.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "render/figure.h"
#include "scenarios/robot.h"

namespace lacuna {
namespace {

using Color = std::array<std::uint8_t, 3>;

constexpr Color kInk{28, 34, 46};
constexpr Color kFaintInk{92, 102, 118};
constexpr Color kPaper{255, 255, 255};
// Shares of the picture's height.
constexpr double kBorder = 0.030;
constexpr double kCaption = 0.058;
constexpr double kSubcaption = 0.036;
constexpr double kLabel = 0.038;
constexpr double kRing = 0.062;       // radius
constexpr double kRingLine = 0.0085;  // its thickness

struct Rectangle {
  double left, top, right, bottom;
  bool meets(const Rectangle& other) const {
    return left < other.right && other.left < right && top < other.bottom && other.top < bottom;
  }
};

void blend(Image& image, int x, int y, const Color& color, double alpha) {
  if (x < 0 || y < 0 || x >= image.width || y >= image.height || !(alpha > 0)) return;
  std::uint8_t* to = image.pixel(x, y);
  for (std::size_t c = 0; c < 3; ++c) {
    to[c] = static_cast<std::uint8_t>(std::lround(to[c] + std::min(alpha, 1.0) * (color[c] - to[c])));
  }
}

// Calls paint(x, y) for the picture's pixels whose centres can lie in the box.
template <typename Paint>
void over(const Image& image, const Rectangle& box, Paint paint) {
  const auto clip = [](double value, int side) { return static_cast<int>(std::clamp(value, 0.0, double(side))); };
  const int right = clip(std::ceil(box.right), image.width), bottom = clip(std::ceil(box.bottom), image.height);
  for (int y = clip(std::floor(box.top), image.height); y < bottom; ++y) {
    for (int x = clip(std::floor(box.left), image.width); x < right; ++x) paint(x, y);
  }
}

// A box with round corners, its edge smooth over one pixel.
void fill_box(Image& image, const Rectangle& box, double round, const Color& color, double alpha) {
  const double cx = 0.5 * (box.left + box.right), cy = 0.5 * (box.top + box.bottom);
  const double hx = 0.5 * (box.right - box.left) - round, hy = 0.5 * (box.bottom - box.top) - round;
  over(image, {box.left - 1, box.top - 1, box.right + 1, box.bottom + 1}, [&](int x, int y) {
    const double dx = std::max(std::abs(x + 0.5 - cx) - hx, 0.0), dy = std::max(std::abs(y + 0.5 - cy) - hy, 0.0);
    blend(image, x, y, color, alpha * std::clamp(round + 0.5 - std::hypot(dx, dy), 0.0, 1.0));
  });
}

void draw_line(Image& image, double x0, double y0, double x1, double y1, double width, const Color& color) {
  const double dx = x1 - x0, dy = y1 - y0, length2 = std::max(dx * dx + dy * dy, 1e-12);
  const Rectangle box{std::min(x0, x1) - width, std::min(y0, y1) - width, std::max(x0, x1) + width,
                      std::max(y0, y1) + width};
  over(image, box, [&](int x, int y) {
    const double px = x + 0.5 - x0, py = y + 0.5 - y0;
    const double t = std::clamp((px * dx + py * dy) / length2, 0.0, 1.0);
    blend(image, x, y, color, std::clamp(0.5 * width + 0.5 - std::hypot(px - t * dx, py - t * dy), 0.0, 1.0));
  });
}

// A coloured ring between two white ones, faintly filled.
void draw_ring(Image& image, double cx, double cy, double radius, double line, const Color& color) {
  const double far = radius + 2.0 * line;
  over(image, {cx - far, cy - far, cx + far, cy + far}, [&](int x, int y) {
    const double distance = std::hypot(x + 0.5 - cx, y + 0.5 - cy);
    const auto band = [distance, radius](double half) {
      return std::clamp(half + 0.5 - std::abs(distance - radius), 0.0, 1.0);
    };
    blend(image, x, y, color, 0.20 * std::clamp(radius + 0.5 - distance, 0.0, 1.0));
    blend(image, x, y, kPaper, 0.85 * band(line));
    blend(image, x, y, color, band(0.5 * line));
  });
}

std::string drawable(const std::string& text) {
  std::string result;
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if ((byte & 0xC0) == 0x80) continue;  // the rest of a UTF-8 letter that is already shown as ?
    result += byte >= 32 && byte < 127 ? c : '?';
  }
  return result;
}

double text_width(const TextMask& mask, double height) { return mask.width * height / mask.height; }

// The mask averaged down to `height` pixels.
void draw_text(Image& image, const TextMask& mask, double left, double top, double height, const Color& color) {
  const double step = mask.height / height;
  const auto average = [&](double x, double y) {
    const int x0 = std::clamp(static_cast<int>(x), 0, mask.width - 1),
              y0 = std::clamp(static_cast<int>(y), 0, mask.height - 1);
    const int x1 = std::clamp(static_cast<int>(x + step), x0 + 1, mask.width);
    const int y1 = std::clamp(static_cast<int>(y + step), y0 + 1, mask.height);
    int sum = 0;
    for (int v = y0; v < y1; ++v) {
      for (int u = x0; u < x1; ++u) sum += mask.coverage[static_cast<std::size_t>(v * mask.width + u)];
    }
    return sum / (255.0 * (x1 - x0) * (y1 - y0));
  };
  left = std::round(left);
  top = std::round(top);
  over(image, {left, top, left + text_width(mask, height), top + height},
       [&](int x, int y) { blend(image, x, y, color, average((x - left) * step, (y - top) * step)); });
}

// As much of the text as fits into `width` pixels at this height.
TextMask fitting(const TextWriter& write, std::string text, double height, double width) {
  TextMask mask = write(text);
  while (text_width(mask, height) > width && text.size() > 4) {
    const double share = std::min(0.95, width / text_width(mask, height));
    text = text.substr(
        0, std::max<std::size_t>(1, static_cast<std::size_t>(share * static_cast<double>(text.size())) - 3));
    mask = write(text + "...");
  }
  return mask;
}

// Panel and text of the caption; returns what it covers.
Rectangle draw_caption(const SnapshotOptions& options, const TextWriter& write, Image& image) {
  const double unit = image.height, border = kBorder * unit, room = image.width - 4 * border;
  Rectangle panel{border, border, border, border};
  struct Line {
    TextMask mask;
    double height;
    Color color;
  };
  std::vector<Line> lines;
  const auto add = [&](const std::string& text, double height, const Color& color) {
    if (text.empty()) return;
    lines.push_back({fitting(write, drawable(text), height, room), height, color});
    panel.right = std::max(panel.right, border + text_width(lines.back().mask, height));
    panel.bottom += height;
  };
  add(options.caption, kCaption * unit, kInk);
  add(options.subcaption, kSubcaption * unit, kFaintInk);
  if (lines.empty()) return panel;
  const double pad = 0.25 * border;
  panel.right += 2 * pad;
  panel.bottom += 2 * pad;
  fill_box(image, panel, 0.4 * border, kPaper, 0.72);
  double top = panel.top + pad;
  for (const Line& line : lines) {
    draw_text(image, line.mask, panel.left + pad, top, line.height, line.color);
    top += line.height;
  }
  return panel;
}

// The first place round the ring, clockwise from the upper right, that is in the picture and free.
Rectangle label_place(const Image& image, double x, double y, double width, double height,
                      const std::vector<Rectangle>& taken) {
  const double unit = image.height, border = 0.5 * kBorder * unit;
  std::optional<Rectangle> first;
  for (const double away : {1.9, 3.0, 4.2}) {
    for (const double turn : {-0.9, 0.9, -2.2, 2.2, -1.57, 1.57}) {
      const double cx = x + away * kRing * unit * std::cos(turn) +
                        (std::abs(turn) < 1.5   ? 0.5
                         : std::abs(turn) > 1.6 ? -0.5
                                                : 0) *
                            width;
      const double cy = y + away * kRing * unit * std::sin(turn);
      const Rectangle box{cx - 0.5 * width, cy - 0.5 * height, cx + 0.5 * width, cy + 0.5 * height};
      if (box.left < border || box.top < border || box.right > image.width - border || box.bottom > unit - border) {
        continue;
      }
      if (!first) first = box;
      if (std::none_of(taken.begin(), taken.end(), [&](const Rectangle& other) { return box.meets(other); }))
        return box;
    }
  }
  return first.value_or(Rectangle{x, y, x + width, y + height});
}

void draw_label(const TextWriter& write, const std::string& text, const Color& color, double x, double y,
                std::vector<Rectangle>& taken, Image& image) {
  const double height = kLabel * image.height, pad = 0.3 * height;
  const TextMask mask = fitting(write, drawable(text), height, 0.5 * image.width);
  const Rectangle box = label_place(image, x, y, text_width(mask, height) + 2 * pad, height + 0.6 * pad, taken);
  const double tx = std::clamp(x, box.left, box.right), ty = std::clamp(y, box.top, box.bottom);
  const double gap = std::max(std::hypot(tx - x, ty - y), 1e-9), ring = kRing * image.height;
  if (gap > ring) {
    draw_line(image, x + ring * (tx - x) / gap, y + ring * (ty - y) / gap, tx, ty, 0.4 * kRingLine * image.height,
              color);
  }
  fill_box(image, box, 0.3 * height, color, 1.0);
  draw_text(image, mask, box.left + pad, box.top + 0.3 * pad, height, kPaper);
  taken.push_back(box);
}

}  // namespace

void draw_overlay(const Robot& robot, std::span<const Eigen::Isometry3d> link_poses, const Camera& camera,
                  const SnapshotOptions& options, const TextWriter& write, Image& image) {
  std::vector<Rectangle> taken{draw_caption(options, write, image)};
  struct Ring {
    const Marker* marker;
    double x, y;
  };
  std::vector<Ring> rings;
  for (const Marker& marker : options.markers) {
    const Eigen::Vector3d at =
        project(camera, image.width, image.height, joint_position(robot, link_poses, marker.joint));
    if (!(at.z() > 0)) continue;  // behind the camera
    const double radius = kRing * image.height;
    draw_ring(image, at.x(), at.y(), radius, kRingLine * image.height, marker.color);
    taken.push_back({at.x() - radius, at.y() - radius, at.x() + radius, at.y() + radius});
    rings.push_back({&marker, at.x(), at.y()});
  }
  for (const Ring& ring : rings) {
    const std::string& name = robot.joints()[ring.marker->joint].name;
    draw_label(write, ring.marker->label.empty() ? name : ring.marker->label, ring.marker->color, ring.x, ring.y, taken,
               image);
  }
}

}  // namespace lacuna
