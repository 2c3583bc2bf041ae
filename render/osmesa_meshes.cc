#include "render/osmesa_meshes.h"

#include "render/osmesa.h"
#include "scenarios/error.h"
#include "scenarios/mesh.h"

namespace lacuna {
namespace {

constexpr float kSmooth = 0.8660254f;  // cosine of 30 degrees
constexpr GLenum kTexture0 = 0x84C0, kTextureCubeMap = 0x8513;
constexpr int kTextureUnits = 2;                        // that MuJoCo uses
constexpr float kSpecular = 0.35f, kShininess = 64.0f;  // as MuJoCo makes of the other solids'

/// OpenGL's functions as OSMesa has them; others of the same name may be in the process.
template <typename Function>
Function* proc(const char* name) {
  auto* out = reinterpret_cast<Function*>(osmesa().proc(name));
  if (out == nullptr) throw WorkError(std::string("OSMesa lacks ") + name);
  return out;
}
#define LACUNA_GL(name) proc<decltype(::name)>(#name)

void set_view(const PaintView& view) {
  const Eigen::Vector3f z = -view.forward.normalized(), x = view.up.cross(z).normalized(), y = z.cross(x);
  Eigen::Matrix4f look = Eigen::Matrix4f::Identity();
  look.block<1, 3>(0, 0) = x.transpose(), look.block<1, 3>(1, 0) = y.transpose(),
                      look.block<1, 3>(2, 0) = z.transpose();
  look.block<3, 1>(0, 3) = -look.block<3, 3>(0, 0) * view.eye;
  LACUNA_GL(glMatrixMode)(GL_PROJECTION);
  LACUNA_GL(glLoadIdentity)();
  LACUNA_GL(glFrustum)(view.left, view.right, view.bottom, view.top, view.near, view.far);
  LACUNA_GL(glMatrixMode)(GL_MODELVIEW);
  LACUNA_GL(glLoadMatrixf)(look.data());
  LACUNA_GL(glViewport)(0, 0, view.width, view.height);
}

/// After set_view: a light's direction is taken to eye coordinates as it is set.
void set_lamps(const std::vector<Lamp>& lamps) {
  const auto light = LACUNA_GL(glLightfv);
  const std::array<float, 4> black{0, 0, 0, 1};
  LACUNA_GL(glLightModelfv)(GL_LIGHT_MODEL_AMBIENT, black.data());
  LACUNA_GL(glLightModeli)(GL_LIGHT_MODEL_TWO_SIDE, 1);
  for (int i = 0; i < 8; ++i) LACUNA_GL(glDisable)(static_cast<GLenum>(GL_LIGHT0 + i));
  for (std::size_t i = 0; i < lamps.size() && i < 8; ++i) {
    const auto name = static_cast<GLenum>(GL_LIGHT0 + i);
    const Lamp& lamp = lamps[i];
    const std::array<float, 4> from{-lamp.direction[0], -lamp.direction[1], -lamp.direction[2], 0};
    light(name, GL_POSITION, from.data());
    const auto color = [&](GLenum part, const std::array<float, 3>& c) {
      const std::array<float, 4> rgba{c[0], c[1], c[2], 1};
      light(name, part, rgba.data());
    };
    color(GL_AMBIENT, lamp.ambient), color(GL_DIFFUSE, lamp.diffuse), color(GL_SPECULAR, lamp.specular);
    LACUNA_GL(glEnable)(name);
  }
}

void set_state() {
  const auto off = LACUNA_GL(glDisable);
  const auto active = proc<void(GLenum)>("glActiveTexture");
  for (int unit = kTextureUnits; unit-- > 0;) {
    active(static_cast<GLenum>(kTexture0 + static_cast<GLenum>(unit)));
    for (const GLenum what : {GLenum{GL_TEXTURE_2D}, kTextureCubeMap}) off(what);
  }
  for (const GLenum what : {GL_BLEND, GL_ALPHA_TEST, GL_CULL_FACE, GL_FOG, GL_COLOR_MATERIAL, GL_STENCIL_TEST,
                            GL_SCISSOR_TEST, GL_POLYGON_OFFSET_FILL})
    off(what);
  for (const GLenum what : {GL_DEPTH_TEST, GL_LIGHTING, GL_NORMALIZE}) LACUNA_GL(glEnable)(what);
  LACUNA_GL(glDepthFunc)(GL_LEQUAL);
  LACUNA_GL(glDepthMask)(GL_TRUE);
  LACUNA_GL(glColorMask)(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
  LACUNA_GL(glShadeModel)(GL_SMOOTH);
  LACUNA_GL(glPolygonMode)(GL_FRONT_AND_BACK, GL_FILL);
}

void set_material(const std::array<float, 4>& rgba) {
  const auto material = LACUNA_GL(glMaterialfv);
  const std::array<float, 4> black{0, 0, 0, 1}, shine{kSpecular, kSpecular, kSpecular, 1};
  const std::array<float, 4> color{rgba[0], rgba[1], rgba[2], 1};
  material(GL_FRONT_AND_BACK, GL_AMBIENT_AND_DIFFUSE, color.data());
  material(GL_FRONT_AND_BACK, GL_SPECULAR, shine.data());
  material(GL_FRONT_AND_BACK, GL_EMISSION, black.data());
  LACUNA_GL(glMaterialf)(GL_FRONT_AND_BACK, GL_SHININESS, kShininess);
}

void draw(const std::vector<Facets>& meshes) {
  const auto normal = LACUNA_GL(glNormal3fv);
  const auto vertex = LACUNA_GL(glVertex3fv);
  for (const Facets& mesh : meshes) {
    set_material(mesh.rgba);
    LACUNA_GL(glBegin)(GL_TRIANGLES);
    for (std::size_t i = 0; i + 2 < mesh.points.size(); i += 3) {
      normal(&mesh.normals[i]);
      vertex(&mesh.points[i]);
    }
    LACUNA_GL(glEnd)();
  }
}

/// Normals of the triangles, as long as twice their area.
std::vector<Eigen::Vector3f> area_normals(const Mesh& mesh) {
  std::vector<Eigen::Vector3f> out;
  for (const auto& [a, b, c] : mesh.triangles)
    out.push_back((mesh.vertices[b] - mesh.vertices[a]).cross(mesh.vertices[c] - mesh.vertices[a]));
  return out;
}

}  // namespace

Facets facets_of(const Mesh& mesh, const Eigen::Isometry3d& pose, double scale, const std::array<float, 4>& rgba) {
  const std::vector<Eigen::Vector3f> areas = area_normals(mesh);
  std::vector<std::vector<std::uint32_t>> around(mesh.vertices.size());
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t)
    for (const std::uint32_t corner : mesh.triangles[t]) around[corner].push_back(t);
  const Eigen::Vector3d middle = 0.5 * (mesh.lower + mesh.upper);
  const Eigen::Matrix3f turn = pose.linear().cast<float>();
  Facets out{{}, {}, rgba};
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Eigen::Vector3f own = areas[t].stableNormalized();
    for (const std::uint32_t corner : mesh.triangles[t]) {
      Eigen::Vector3f sum = Eigen::Vector3f::Zero();
      for (const std::uint32_t other : around[corner])
        if (areas[other].stableNormalized().dot(own) >= kSmooth) sum += areas[other];
      const Eigen::Vector3f n = turn * (sum.squaredNorm() > 0 ? sum.stableNormalized() : own);
      const Eigen::Vector3d p = scale * (pose * (mesh.vertices[corner].cast<double>() - middle));
      for (int k = 0; k < 3; ++k) out.points.push_back(static_cast<float>(p[k])), out.normals.push_back(n[k]);
    }
  }
  return out;
}

void paint(const std::vector<Facets>& meshes, const PaintView& view, const std::vector<Lamp>& lamps) {
  LACUNA_GL(glPushAttrib)(GL_ALL_ATTRIB_BITS);
  for (const GLenum matrix : {GL_PROJECTION, GL_MODELVIEW}) {
    LACUNA_GL(glMatrixMode)(matrix);
    LACUNA_GL(glPushMatrix)();
  }
  set_view(view);
  set_lamps(lamps);
  set_state();
  draw(meshes);
  for (const GLenum matrix : {GL_MODELVIEW, GL_PROJECTION}) {
    LACUNA_GL(glMatrixMode)(matrix);
    LACUNA_GL(glPopMatrix)();
  }
  LACUNA_GL(glPopAttrib)();
}

#undef LACUNA_GL

}  // namespace lacuna
