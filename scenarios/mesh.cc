#include "scenarios/mesh.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <tuple>

#include "scenarios/error.h"
#include "scenarios/files.h"
#include "scenarios/robot.h"
#include "scenarios/text.h"

namespace lacuna {
namespace fs = std::filesystem;

namespace {

constexpr std::string_view kPackage = "package://", kFile = "file://";
constexpr const char* kInside = "a file below the robot's folder or a --package-path";

/// `rest` in the tree below `folder`; throws where it leads out of it.
std::optional<fs::path> below(const fs::path& folder, const std::string& rest, const std::string& where) {
  const fs::path file = (folder.empty() ? fs::path(".") : folder) / fs::path(rest).relative_path();
  if (!inside(folder, file)) throw InputError(where, quoted(rest) + ", which leads out of its folder", kInside);
  if (is_there(file)) return file;
  return std::nullopt;
}

std::optional<fs::path> find_in_package(const std::string& name, const MeshFolders& folders, const std::string& where,
                                        std::string& why) {
  const std::string path = name.substr(kPackage.size());
  const std::size_t slash = path.find('/');
  const std::string package = path.substr(0, slash);
  if (slash == std::string::npos || package.empty() || package == "." || package == "..")
    throw InputError(where, quoted(name), "package://NAME/path");
  for (const fs::path& folder : folders.packages) {
    std::error_code error;
    const bool own = fs::weakly_canonical(fs::absolute(folder), error).filename() == package && !error;
    for (const fs::path& root : {folder / package, folder}) {
      if (root == folder ? !own : !is_there(root)) continue;
      if (auto found = below(root, path.substr(slash + 1), where)) return found;
    }
  }
  why = folders.packages.empty() ? "no --package-path says where the package " + quoted(package) + " lies"
                                 : "no such file below a --package-path";
  return std::nullopt;
}

std::optional<fs::path> find_whole_path(const std::string& name, const MeshFolders& folders, const std::string& where,
                                        std::string& why) {
  const fs::path file = name.substr(kFile.size());
  if (!file.is_absolute()) throw InputError(where, quoted(name), "file:// and a path that begins with /");
  const auto holds = [&](const fs::path& folder) { return inside(folder, file); };
  if (!holds(folders.robot) && std::none_of(folders.packages.begin(), folders.packages.end(), holds))
    throw InputError(where, quoted(name), kInside);
  if (is_there(file)) return file;
  why = "no such file";
  return std::nullopt;
}

void set_box(Mesh& mesh) {
  Eigen::Vector3f low = mesh.vertices.front(), high = low;
  for (const Eigen::Vector3f& vertex : mesh.vertices) low = low.cwiseMin(vertex), high = high.cwiseMax(vertex);
  mesh.lower = low.cast<double>(), mesh.upper = high.cast<double>();
}

/// Reads every file once, whatever number of links and scales use it.
class Loader {
 public:
  Loader(const MeshFolders& folders, std::vector<std::string>& notes, const MeshLimits& limits)
      : folders_(folders), notes_(notes), limits_(limits) {}

  std::shared_ptr<const Mesh> load(const Visual& visual, const std::string& link) {
    const std::string where = "link " + printable(link, 60) + ": mesh";
    std::string why;
    const auto format = format_of(visual.mesh_file, why);
    const auto file = format ? find_mesh(visual.mesh_file, folders_, where, why) : std::nullopt;
    if (!file) {
      note("link " + printable(link, 60) + ": its mesh " + quoted(visual.mesh_file) + " is not drawn: " + why);
      return nullptr;
    }
    const Eigen::Vector3d& s = visual.mesh_scale;
    auto& scaled_mesh = scaled_[{fs::weakly_canonical(*file).string(), s[0], s[1], s[2]}];
    if (!scaled_mesh)
      scaled_mesh = std::make_shared<const Mesh>(scaled(whole(*file, *format), s, file->string(), limits_));
    return scaled_mesh;
  }

 private:
  static std::optional<std::string> format_of(const std::string& name, std::string& why) {
    std::string format = fs::path(name).extension().string();
    for (char& c : format) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    if (format == ".stl" || format == ".obj" || format == ".dae") return format.substr(1);
    why = "of STL, OBJ and DAE files it is none";
    return std::nullopt;
  }

  void note(const std::string& text) {
    if (noted_.insert(text).second) notes_.push_back(text);
  }

  const Mesh& whole(const fs::path& file, const std::string& format) {
    const std::string key = fs::weakly_canonical(file).string();
    if (const auto known = whole_.find(key); known != whole_.end()) return known->second;
    if (whole_.size() == limits_.files)
      throw InputError(printable(file.string()), fmt::format("more than {} mesh files", limits_.files), "fewer");
    const std::string bytes = read_text_file(file, file.string(), "a mesh", limits_.file_bytes);
    bytes_ += bytes.size();
    if (bytes_ > limits_.total_bytes)
      throw InputError(printable(file.string()), fmt::format("{} bytes of meshes up to here", bytes_),
                       fmt::format("at most {}", limits_.total_bytes));
    Mesh mesh = read_mesh(bytes, format, file.string(), limits_);
    triangles_ += mesh.triangles.size();
    if (triangles_ > 2 * limits_.triangles)
      throw InputError(printable(file.string()), fmt::format("{} triangles up to here", triangles_),
                       fmt::format("at most {} in a robot", 2 * limits_.triangles));
    return whole_.emplace(key, std::move(mesh)).first->second;
  }

  const MeshFolders& folders_;
  std::vector<std::string>& notes_;
  const MeshLimits& limits_;
  std::set<std::string> noted_;
  std::map<std::string, Mesh> whole_;
  std::map<std::tuple<std::string, double, double, double>, std::shared_ptr<const Mesh>> scaled_;
  std::uintmax_t bytes_ = 0;
  std::size_t triangles_ = 0;
};

bool names_meshes(const Robot& robot) {
  return std::ranges::any_of(robot.links(), [](const Link& link) {
    return std::ranges::any_of(link.visuals, [](const Visual& v) { return v.shape == Visual::Shape::mesh; });
  });
}

}  // namespace

Mesh scaled(Mesh mesh, const Eigen::Vector3d& factors, const std::string& source, const MeshLimits& limits) {
  for (Eigen::Vector3f& vertex : mesh.vertices) {
    vertex = vertex.cast<double>().cwiseProduct(factors).cast<float>();
    if (!(vertex.cwiseAbs().maxCoeff() <= limits.size) || !vertex.allFinite())
      throw InputError(printable(source), "a mesh that reaches farther than that, or no finite numbers",
                       fmt::format("at most {:g} m each way (is `scale` missing?)", limits.size));
  }
  if (factors.prod() < 0.0)
    for (auto& triangle : mesh.triangles) std::swap(triangle[1], triangle[2]);
  set_box(mesh);
  return mesh;
}

std::optional<fs::path> find_mesh(const std::string& name, const MeshFolders& folders, const std::string& where,
                                  std::string& why) {
  if (name.find('\0') != std::string::npos) throw InputError(where, quoted(name), "a file's name");
  if (name.starts_with(kPackage)) return find_in_package(name, folders, where, why);
  if (name.starts_with(kFile)) return find_whole_path(name, folders, where, why);
  if (name.find("://") != std::string::npos) {
    why = "only relative names, file:// and package:// are read";
    return std::nullopt;
  }
  if (fs::path(name).is_absolute()) return find_whole_path(std::string(kFile) + name, folders, where, why);
  if (auto found = below(folders.robot, name, where)) return found;
  for (const fs::path& folder : folders.packages)
    if (auto found = below(folder, name, where)) return found;
  why = "no such file";
  return std::nullopt;
}

std::shared_ptr<const Robot> with_meshes(const Robot& robot, const MeshFolders& folders,
                                         std::vector<std::string>& notes, const MeshLimits& limits) {
  for (const fs::path& folder : folders.packages) {
    std::error_code error;
    if (!fs::is_directory(folder, error))
      throw InputError("--package-path", quoted(folder.string()), "a folder that exists");
  }
  auto links = robot.links();
  if (std::string reason; names_meshes(robot) && !meshes_available(&reason)) {
    notes.push_back(reason);
  } else {
    Loader loader(folders, notes, limits);
    for (Link& link : links)
      for (Visual& visual : link.visuals)
        if (visual.shape == Visual::Shape::mesh) visual.mesh = loader.load(visual, link.name);
  }
  return std::make_shared<const Robot>(robot.name(), robot.joints(), std::move(links), robot.name());
}

}  // namespace lacuna
