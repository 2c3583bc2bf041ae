// Snapshots through MuJoCo's renderer on Mesa's software OpenGL. MuJoCo's physics takes no part: its scene is one
// floor and one lamp, and the robot's solids are added to it as decoration.
#include <mujoco/mujoco.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <memory>
#include <mutex>
#include <optional>
#include <stdexcept>

#include "render/figure.h"
#include "render/osmesa.h"
#include "render/osmesa_meshes.h"
#include "render/overlay.h"
#include "render/snapshot.h"
#include "scenarios/error.h"
#include "scenarios/robot.h"

namespace lacuna {
namespace {

using Eigen::Vector3d;

// Every picture is drawn at twice its size, with four samples a pixel on top, and averaged down: smooth edges. It is
// drawn in tiles, so that memory does not grow with the picture.
constexpr int kSupersample = 2;
constexpr int kTile = 1024;  // pixels of the finished picture
constexpr int kBuffer = kSupersample * kTile;
constexpr int kSamples = 4;
constexpr int kTextScale = mjFONTSCALE_300;  // glyphs are drawn large and averaged down, too
constexpr double kSquaresAcross = 6.0;       // floor squares to a scene's radius, about; their side is 1, 2 or 5 * 10^k

constexpr float kHazeStart = 1.3f;           // beyond the target, in radii of the scene: the floor begins to fade
constexpr float kHazeEnd = 9.0f;             // likewise: it is gone
constexpr float kHaze[3] = {244, 246, 249};  // the background, and what the floor fades into

// The floor and the lamps, for a scene of radius 1 at the origin.
constexpr const char* kStage = R"(<mujoco>
  <visual>
    <global offwidth="2048" offheight="2048"/>
    <quality shadowsize="4096" offsamples="4" numslices="64" numstacks="32"/>
    <headlight ambient=".45 .45 .46" diffuse=".28 .28 .28" specular=".05 .05 .05"/>
    <map shadowclip="2.5"/>
  </visual>
  <statistic extent="1" center="0 0 0"/>
  <asset>
    <texture name="sky" type="skybox" builtin="flat" rgb1=".957 .965 .976" width="16" height="96"/>
    <texture name="floor" type="2d" builtin="checker" rgb1=".89 .905 .925" rgb2=".825 .845 .875" width="256" height="256"/>
    <material name="floor" texture="floor" texuniform="true" texrepeat="1 1" specular="0" shininess="0"/>
  </asset>
  <worldbody>
    <light directional="true" pos="-.6 -.9 4" dir=".15 .22 -.96" diffuse=".52 .52 .51" ambient="0 0 0"
           specular=".25 .25 .25" castshadow="true"/>
    <geom type="plane" size="30 30 .5" material="floor"/>
  </worldbody>
</mujoco>)";

struct FreeModel {
  void operator()(mjModel* model) const { mj_deleteModel(model); }
};
struct FreeData {
  void operator()(mjData* data) const { mj_deleteData(data); }
};

/// The scene's geoms and lights, freed at the end of a picture.
class Scene {
 public:
  Scene(const mjModel* model, int geoms) {
    mjv_defaultScene(&scene_);
    mjv_makeScene(model, &scene_, geoms);
  }
  ~Scene() { mjv_freeScene(&scene_); }
  Scene(const Scene&) = delete;
  Scene& operator=(const Scene&) = delete;
  mjvScene* get() { return &scene_; }
  mjvScene* operator->() { return &scene_; }

 private:
  mjvScene scene_;
};

/// World metres to the stage's units, in which every robot is about as large.
struct Stage {
  Vector3d origin;
  double scale;

  explicit Stage(const Camera& camera) : scale(1.0 / camera.radius) {
    // The origin lies on the floor's pattern, so that the pattern is fixed to the world.
    const double period = 2.0 * square(camera.radius);
    origin = {period * std::round(camera.target.x() / period), period * std::round(camera.target.y() / period),
              camera.ground};
  }
  Vector3d operator()(const Vector3d& world) const { return scale * (world - origin); }

  /// Side of a floor square in m.
  static double square(double radius) {
    const double wanted = radius / kSquaresAcross, decade = std::pow(10.0, std::floor(std::log10(wanted)));
    const double digit = wanted / decade;
    return decade * (digit < 1.5 ? 1.0 : digit < 3.5 ? 2.0 : digit < 7.5 ? 5.0 : 10.0);
  }
};

void copy(const Vector3d& from, float to[3]) {
  for (int i = 0; i < 3; ++i) to[i] = static_cast<float>(from[i]);
}

void add_solid(const Solid& solid, const Stage& stage, mjvScene* scene) {
  static constexpr int kTypes[] = {mjGEOM_BOX, mjGEOM_CYLINDER, mjGEOM_CAPSULE, mjGEOM_SPHERE};
  if (scene->ngeom >= scene->maxgeom || solid.kind == Solid::Kind::mesh) return;
  const Vector3d half = stage.scale * solid.half, at = stage(solid.pose.translation());
  const Eigen::Matrix<double, 3, 3, Eigen::RowMajor> turn = solid.pose.linear();
  mjvGeom* geom = scene->geoms + scene->ngeom++;
  const bool round = solid.kind == Solid::Kind::cylinder || solid.kind == Solid::Kind::capsule;
  const mjtNum size[3] = {half.x(), round ? half.z() : half.y(), half.z()};  // MuJoCo's: radius, half length
  mjv_initGeom(geom, kTypes[static_cast<int>(solid.kind)], size, at.data(), turn.data(), solid.rgba.data());
  geom->category = mjCAT_DYNAMIC;  // decoration casts no shadow
  geom->specular = 0.35f;
  geom->shininess = 0.5f;
  geom->reflectance = 0.0f;
}

/// A part of the finished picture, pixels from its top left.
struct Tile {
  int left, top, width, height;
};

/// The picture's view, cut to the tile.
mjvGLCamera tile_camera(const Camera& camera, const Stage& stage, const Image& image, const Tile& tile) {
  const Eigen::Matrix3d axes = camera.axes();
  const double distance = stage.scale * camera.distance;
  const double near = std::max(0.05 * distance, distance - 6.0), far = distance + 60.0;
  const double high = near * half_height_tangent(camera, image.width, image.height);
  const double wide = high * image.width / image.height;
  mjvGLCamera view;
  copy(stage(camera.target) - distance * axes.col(0), view.pos);
  copy(axes.col(0), view.forward);
  copy(axes.col(2), view.up);
  const double bottom = static_cast<double>(tile.top + tile.height) / image.height;
  view.frustum_top = static_cast<float>(high * (1.0 - 2.0 * tile.top / image.height));
  view.frustum_bottom = static_cast<float>(high * (1.0 - 2.0 * bottom));
  view.frustum_center = static_cast<float>(wide * ((2.0 * tile.left + tile.width) / image.width - 1.0));
  view.frustum_near = static_cast<float>(near);
  view.frustum_far = static_cast<float>(far);
  return view;
}

/// The figure's meshes in the stage's units.
std::vector<Facets> staged_meshes(const std::vector<Solid>& figure, const Stage& stage) {
  std::vector<Facets> out;
  for (const Solid& solid : figure) {
    if (!solid.mesh) continue;
    Eigen::Isometry3d pose = solid.pose;
    pose.translation() -= stage.origin;
    out.push_back(facets_of(*solid.mesh, pose, stage.scale, solid.rgba));
  }
  return out;
}

Eigen::Vector3f vector(const float from[3]) { return {from[0], from[1], from[2]}; }

/// MuJoCo's frustum: its width follows from the height.
PaintView paint_view(const mjvGLCamera& eye, const mjrRect& view) {
  const float half =
      0.5f * static_cast<float>(view.width) / static_cast<float>(view.height) * (eye.frustum_top - eye.frustum_bottom);
  return {view.width,
          view.height,
          vector(eye.pos),
          vector(eye.forward),
          vector(eye.up),
          eye.frustum_center - half,
          eye.frustum_center + half,
          eye.frustum_bottom,
          eye.frustum_top,
          eye.frustum_near,
          eye.frustum_far};
}

std::vector<Lamp> lamps_of(const mjvScene& scene, const mjvGLCamera& eye) {
  std::vector<Lamp> out;
  for (int i = 0; i < scene.nlight; ++i) {
    const mjvLight& light = scene.lights[i];
    Lamp lamp{light.headlight ? vector(eye.forward) : vector(light.dir), {}, {}, {}};
    std::copy_n(light.ambient, 3, lamp.ambient.begin());
    std::copy_n(light.diffuse, 3, lamp.diffuse.begin());
    std::copy_n(light.specular, 3, lamp.specular.begin());
    out.push_back(lamp);
  }
  return out;
}

/// OSMesa's context and MuJoCo's in it. One for the process, used by one thread at a time; never destroyed, because
/// Mesa's own teardown at exit may come first.
class Painter {
 public:
  static Painter& instance() {
    static Painter* const painter = new Painter;
    return *painter;
  }

  const std::string& reason() const { return reason_; }
  Image draw(const std::vector<Solid>& figure, const Camera& camera, int width, int height);
  TextMask text(const std::string& line);

 private:
  /// Makes the context current in this thread and keeps other threads out, for as long as it lives.
  class Turn {
   public:
    explicit Turn(Painter& painter) : lock_(painter.mutex_) { painter.make_current(); }
    ~Turn() { osmesa().make_current(nullptr, nullptr, 0, 0, 0); }
    Turn(const Turn&) = delete;
    Turn& operator=(const Turn&) = delete;

   private:
    std::lock_guard<std::mutex> lock_;
  };

  Painter();
  void open();
  void make_current();
  void check_opengl() const;
  void load_stage();
  void add_haze(const mjrRect& view, const mjvGLCamera& eye, float start, float end);
  void draw_tile(Scene& scene, const std::vector<Facets>& meshes, const Camera& camera, const Stage& stage,
                 const Tile& tile, Image& image);

  std::mutex mutex_;
  std::string reason_;
  OSMesaContext mesa_ = nullptr;
  std::vector<std::uint8_t> window_;  // OSMesa wants one; drawing goes to MuJoCo's own buffer
  std::unique_ptr<mjModel, FreeModel> model_;
  std::unique_ptr<mjData, FreeData> data_;
  mjrContext context_{};
  std::vector<std::uint8_t> pixels_;  // of the last read, rows from the bottom
  std::vector<float> depth_;          // likewise, as OpenGL stores it: 0 at the near plane, 1 at the far one
};

Painter::Painter()
    : window_(4 * 16 * 16),
      pixels_(3 * static_cast<std::size_t>(kBuffer) * kBuffer),
      depth_(static_cast<std::size_t>(kBuffer) * kBuffer) {
  try {
    open();
  } catch (const WorkError& error) {
    reason_ = error.what();
  }
  if (mesa_) osmesa().make_current(nullptr, nullptr, 0, 0, 0);
}

void Painter::open() {
  const int attributes[] = {OSMESA_FORMAT,
                            OSMESA_RGBA,
                            OSMESA_DEPTH_BITS,
                            24,
                            OSMESA_STENCIL_BITS,
                            8,
                            OSMESA_PROFILE,
                            OSMESA_COMPAT_PROFILE,
                            0};
  mesa_ = osmesa().create(attributes, nullptr);
  if (!mesa_) throw WorkError("OSMesa gives no OpenGL context");
  make_current();
  check_opengl();
  load_stage();
  mjr_defaultContext(&context_);
  mjr_makeContext(model_.get(), &context_, kTextScale);
  mjr_setBuffer(mjFB_OFFSCREEN, &context_);
  if (context_.currentBuffer != mjFB_OFFSCREEN) throw WorkError("OSMesa gives no off-screen buffer");
}

void Painter::make_current() {
  if (!osmesa().make_current(mesa_, window_.data(), GL_UNSIGNED_BYTE, 16, 16)) {
    throw WorkError("OSMesa's context cannot be made current");
  }
}

// What MuJoCo's context needs. It ends the process where it meets less, so it is asked for before.
void Painter::check_opengl() const {
  const auto get_string = reinterpret_cast<const GLubyte* (*)(GLenum)>(osmesa().proc("glGetString"));
  const auto get_integer = reinterpret_cast<void (*)(GLenum, GLint*)>(osmesa().proc("glGetIntegerv"));
  if (!get_string || !get_integer) throw WorkError("OSMesa lacks OpenGL's queries");
  const auto* extensions = reinterpret_cast<const char*>(get_string(GL_EXTENSIONS));
  for (const char* name : {"GL_ARB_framebuffer_object", "GL_ARB_vertex_buffer_object", "GL_ARB_depth_texture"}) {
    if (!extensions || !std::strstr(extensions, name)) throw WorkError(std::string("OSMesa's OpenGL lacks ") + name);
  }
  GLint side = 0;
  constexpr GLenum kMaxRenderbufferSize = 0x84E8;
  get_integer(kMaxRenderbufferSize, &side);
  if (side < kBuffer) throw WorkError("OSMesa's largest buffer is " + std::to_string(side) + " pixels a side");
}

void Painter::load_stage() {
  const auto files = std::make_unique<mjVFS>();
  mj_defaultVFS(files.get());
  const int length = static_cast<int>(std::strlen(kStage));
  mj_makeEmptyFileVFS(files.get(), "stage.xml", length);
  std::memcpy(files->filedata[0], kStage, static_cast<std::size_t>(length));
  char error[500] = "";
  model_.reset(mj_loadXML("stage.xml", files.get(), error, sizeof error));
  mj_deleteVFS(files.get());
  if (!model_) throw WorkError(std::string("MuJoCo cannot build the stage: ") + error);
  data_.reset(mj_makeData(model_.get()));
  mj_forward(model_.get(), data_.get());
}

// OpenGL's own fog goes wrong with shadows, which are drawn in passes that add up.
void Painter::add_haze(const mjrRect& view, const mjvGLCamera& eye, float start, float end) {
  const float near = eye.frustum_near, far = eye.frustum_far;
  const std::size_t count = static_cast<std::size_t>(view.width) * static_cast<std::size_t>(view.height);
  for (std::size_t i = 0; i < count; ++i) {
    const float depth = near * far / (far - depth_[i] * (far - near));
    const float t = std::clamp((depth - start) / (end - start), 0.0f, 1.0f);
    if (!(t > 0)) continue;
    const float haze = t * (2.0f - t);
    for (std::size_t c = 0; c < 3; ++c) {
      std::uint8_t& value = pixels_[3 * i + c];
      value =
          static_cast<std::uint8_t>(static_cast<float>(value) + haze * (kHaze[c] - static_cast<float>(value)) + 0.5f);
    }
  }
}

void Painter::draw_tile(Scene& scene, const std::vector<Facets>& meshes, const Camera& camera, const Stage& stage,
                        const Tile& tile, Image& image) {
  const mjvGLCamera eye = tile_camera(camera, stage, image, tile);
  scene->camera[0] = scene->camera[1] = eye;
  const mjrRect view{0, 0, kSupersample * tile.width, kSupersample * tile.height};
  mjr_render(view, scene.get(), &context_);
  if (!meshes.empty()) {
    mjr_restoreBuffer(&context_);
    paint(meshes, paint_view(eye, view), lamps_of(*scene.get(), eye));
  }
  mjr_readPixels(pixels_.data(), depth_.data(), view, &context_);
  const float distance = static_cast<float>(stage.scale * camera.distance);
  add_haze(view, eye, distance + kHazeStart, distance + kHazeEnd);
  constexpr int kCount = kSupersample * kSupersample;
  for (int y = 0; y < tile.height; ++y) {
    std::uint8_t* to = image.pixel(tile.left, tile.top + y);
    const int row = view.height - kSupersample * (y + 1);
    for (int i = 0; i < 3 * tile.width; ++i) {
      int sum = kCount / 2;
      for (int dy = 0; dy < kSupersample; ++dy) {
        const std::size_t start = 3 * static_cast<std::size_t>(row + dy) * static_cast<std::size_t>(view.width);
        for (int dx = 0; dx < kSupersample; ++dx) {
          sum += pixels_[start + static_cast<std::size_t>(3 * (kSupersample * (i / 3) + dx) + i % 3)];
        }
      }
      to[i] = static_cast<std::uint8_t>(sum / kCount);
    }
  }
}

Image Painter::draw(const std::vector<Solid>& figure, const Camera& camera, int width, int height) {
  Image image = Image::filled(width, height, 0, 0, 0);
  const Turn turn(*this);
  const Stage stage(camera);
  mjvOption option;
  mjv_defaultOption(&option);
  mjvCamera ignored;
  mjv_defaultCamera(&ignored);
  Scene scene(model_.get(), static_cast<int>(figure.size()) + 16);
  mjv_updateScene(model_.get(), data_.get(), &option, nullptr, &ignored, mjCAT_ALL, scene.get());
  const float repeat = static_cast<float>(0.5 * camera.radius / Stage::square(camera.radius));
  scene->geoms[0].texrepeat[0] = scene->geoms[0].texrepeat[1] = repeat;
  scene->flags[mjRND_REFLECTION] = 0;
  for (const Solid& solid : figure) add_solid(solid, stage, scene.get());
  const std::vector<Facets> meshes = staged_meshes(figure, stage);
  for (int top = 0; top < height; top += kTile) {
    for (int left = 0; left < width; left += kTile) {
      const Tile tile{left, top, std::min(kTile, width - left), std::min(kTile, height - top)};
      draw_tile(scene, meshes, camera, stage, tile, image);
    }
  }
  return image;
}

TextMask Painter::text(const std::string& line) {
  const Turn turn(*this);
  int width = 0;
  std::string shown;
  for (const char c : line) {
    const int advance = context_.charWidthBig[static_cast<unsigned char>(c)];
    if (width + advance + 16 > kBuffer) break;
    width += advance;
    shown += c;
  }
  const mjrRect view{0, 0, width + 16, context_.charHeightBig + 16};
  mjr_label(view, mjFONT_BIG, shown.c_str(), 0, 0, 0, 1, 1, 1, 1, &context_);
  mjr_readPixels(pixels_.data(), nullptr, view, &context_);
  TextMask mask{view.width, view.height, {}};
  mask.coverage.resize(static_cast<std::size_t>(view.width) * static_cast<std::size_t>(view.height));
  for (int y = 0; y < view.height; ++y) {
    for (int x = 0; x < view.width; ++x) {
      const std::size_t from = static_cast<std::size_t>(view.height - 1 - y) * static_cast<std::size_t>(view.width);
      mask.coverage[static_cast<std::size_t>(y * view.width + x)] = pixels_[3 * (from + static_cast<std::size_t>(x))];
    }
  }
  return mask;
}

void check_camera(const Camera& camera) {
  const bool finite = camera.target.allFinite() && std::isfinite(camera.azimuth) && std::isfinite(camera.elevation) &&
                      std::isfinite(camera.ground) && std::isfinite(camera.distance) && std::isfinite(camera.radius);
  if (!finite || !(camera.distance > 0) || !(camera.radius > 0) || !(camera.aspect > 0) ||
      !(camera.field_of_view > 0 && camera.field_of_view < 3)) {
    throw std::invalid_argument("the camera sees nothing: distance, radius, aspect and angle must be positive");
  }
}

}  // namespace

bool render_available(std::string* reason) {
  if (reason) *reason = Painter::instance().reason();
  return Painter::instance().reason().empty();
}

Image render_snapshot(const Robot& robot, std::span<const Eigen::Isometry3d> link_poses, const Camera& camera,
                      const SnapshotOptions& options) {
  std::string reason;
  if (!render_available(&reason)) throw WorkError(reason);
  check_camera(camera);
  std::vector<Solid> figure = robot_figure(robot, link_poses);
  for (const Piston& piston : options.pistons)
    for (Solid& solid : piston_figure(robot, link_poses, piston)) figure.push_back(std::move(solid));
  if (const std::optional<Solid> carrier = pillar(robot, camera.ground)) figure.push_back(*carrier);
  Painter& painter = Painter::instance();
  Image image = painter.draw(figure, camera, options.width, options.height);
  const auto write = [&painter](const std::string& line) { return painter.text(line); };
  draw_overlay(robot, link_poses, camera, options, write, image);
  return image;
}

}  // namespace lacuna
