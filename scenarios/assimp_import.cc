// Meshes through assimp, the only file that sees it. The bytes are untrusted: what could make assimp recurse, hang or
// grow without bound is refused before it looks, it gets no other file to open, and what it returns is checked.
#include <assimp/MemoryIOWrapper.h>
#include <assimp/config.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <fmt/format.h>

#include <algorithm>
#include <assimp/IOSystem.hpp>
#include <assimp/Importer.hpp>
#include <cmath>
#include <map>
#include <set>

#include "scenarios/error.h"
#include "scenarios/mesh.h"
#include "scenarios/text.h"
#include "scenarios/xml_scan.h"

namespace lacuna {
namespace {

constexpr unsigned kMostCorners = 64;             // of one face: cutting it up takes their square
constexpr std::ptrdiff_t kMostLines = 8'000'000;  // of an OBJ or a text STL file
constexpr int kMostPlaces = 10'000;               // nodes of a Collada scene
constexpr std::size_t kBinaryHead = 84, kBinaryFacet = 50;

/// One file in memory; no other exists.
class OneFile : public Assimp::IOSystem {
 public:
  OneFile(const std::string& name, const std::string& bytes) : name_(name), bytes_(bytes) {}
  bool Exists(const char* file) const override { return name_ == file; }
  char getOsSeparator() const override { return '/'; }
  Assimp::IOStream* Open(const char* file, const char*) override {
    if (!Exists(file)) return nullptr;
    return new Assimp::MemoryIOStream(reinterpret_cast<const std::uint8_t*>(bytes_.data()), bytes_.size());
  }
  void Close(Assimp::IOStream* file) override { delete file; }

 private:
  std::string name_;
  const std::string& bytes_;
};

[[noreturn]] void refuse(const std::string& source, const std::string& found, const std::string& expected) {
  throw InputError(printable(source), found, expected);
}

void check_lines(const std::string& bytes, const std::string& source) {
  if (std::ranges::count(bytes, '\n') > kMostLines)
    refuse(source, fmt::format("more than {} lines", kMostLines), "fewer");
  if (bytes.find('\0') != std::string::npos) refuse(source, "a zero byte", "text");
}

/// A binary file says how many facets follow; anything else must begin as the text does.
void check_stl(const std::string& bytes, const std::string& source, const MeshLimits& limits) {
  if (bytes.size() >= kBinaryHead) {
    std::uint32_t facets = 0;
    for (int i = 3; i >= 0; --i) facets = facets << 8 | static_cast<std::uint8_t>(bytes[80 + i]);
    if (bytes.size() == kBinaryHead + kBinaryFacet * static_cast<std::uintmax_t>(facets)) {
      if (facets > limits.triangles)
        refuse(source, fmt::format("{} triangles", facets), fmt::format("at most {}", limits.triangles));
      return;
    }
  }
  if (bytes.compare(0, 5, "solid") != 0)
    refuse(source,
           fmt::format("{} bytes that neither begin with \"solid\" nor hold as many facets as they say", bytes.size()),
           "an STL file");
  check_lines(bytes, source);
}

/// assimp makes room for what these promise before it looks. A number takes two bytes of the file at least.
void check_promises(const XmlElement& element, const std::string& bytes, const std::string& source) {
  static constexpr std::pair<const char*, double> kMost[] = {{"count", 0.0}, {"stride", 64.0}, {"offset", 64.0}};
  for (const auto& [name, fixed] : kMost) {
    const std::string* text = element.find(name);
    if (text == nullptr) continue;
    const double most = fixed > 0.0 ? fixed : static_cast<double>(bytes.size()) / 2.0;
    const auto number = parse_number(*text);
    if (!number || !(*number >= 0.0 && *number <= most) || *number != std::floor(*number))
      throw InputError(fmt::format("{}:{}: {}", printable(source), element.line, name), quoted(*text, 40),
                       fmt::format("a whole number from 0 to {:.0f}", std::floor(most)));
  }
}

bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\n' || c == '\r'; }

/// Lists hold numbers only, or whole ones: at any other word assimp would read the same number for ever.
void check_list(std::string_view words, bool whole, const std::string& where) {
  for (std::size_t at = 0; at < words.size();) {
    if (is_blank(words[at])) {
      ++at;
      continue;
    }
    std::size_t end = at;
    while (end < words.size() && !is_blank(words[end])) ++end;
    const std::string_view word = words.substr(at, end - at);
    const bool digits = word.find_first_not_of("0123456789", word.front() == '-' ? 1 : 0) == std::string_view::npos;
    if (word.size() > 40 || !parse_number(word) || (whole && !digits))
      throw InputError(where, quoted(std::string(word), 40), whole ? "whole numbers" : "numbers");
    at = end;
  }
}

/// Every list's text up to the next tag; assimp reads no further.
void check_lists(const std::string& bytes, const std::string& source) {
  static constexpr std::string_view kWhole[] = {"p", "v", "h", "vcount", "int_array"};
  static constexpr std::string_view kReal[] = {"float_array", "translate", "rotate", "scale",
                                               "matrix",      "lookat",    "skew"};
  if (bytes.find("<![") != std::string::npos) refuse(source, "a section <![...]>", "elements");
  int line = 1;
  std::size_t counted = 0;
  for (std::size_t open = bytes.find('<'); open != std::string::npos; open = bytes.find('<', open + 1)) {
    line += static_cast<int>(std::count(bytes.begin() + static_cast<std::ptrdiff_t>(counted),
                                        bytes.begin() + static_cast<std::ptrdiff_t>(open), '\n'));
    counted = open;
    const std::size_t close = bytes.find('>', open);
    if (close == std::string::npos) return;
    const std::string_view tag(bytes.data() + open + 1, close - open - 1);
    const std::string_view name = tag.substr(0, tag.find_first_of(" \t\r\n/"));
    const bool whole = std::ranges::find(kWhole, name) != std::end(kWhole);
    if (!whole && std::ranges::find(kReal, name) == std::end(kReal)) continue;
    const std::size_t next = std::min(bytes.find('<', close), bytes.size());
    check_list(std::string_view(bytes).substr(close + 1, next - close - 1), whole,
               fmt::format("{}:{}: <{}>", printable(source), line, name));
  }
}

double number_or(const XmlElement& element, const char* name, double otherwise) {
  const std::string* text = element.find(name);
  return text == nullptr ? otherwise : parse_number(*text).value_or(otherwise);
}

/// An accessor stays within the numbers of the one array that its own source holds: assimp does not look.
class SourceCheck {
 public:
  SourceCheck(const std::vector<XmlElement>& elements, const std::string& source)
      : elements_(elements), source_(source) {}

  void run() {
    for (const XmlElement& element : elements_)
      if (const std::string* id = element.find("id"); id != nullptr && !ids_.insert(*id).second)
        refuse_at(element, "the id " + quoted(*id, 40) + " twice", "unique ids");
    int accessors = 0;
    for (std::size_t i = 0; i < elements_.size(); ++i) {
      if (elements_[i].tag != "accessor") continue;
      if (++accessors > kMostAccessors)
        refuse_at(elements_[i], fmt::format("more than {} accessors", kMostAccessors), "fewer");
      check(i);
    }
  }

 private:
  [[noreturn]] void refuse_at(const XmlElement& element, const std::string& found, const std::string& expected) const {
    throw InputError(fmt::format("{}:{}", printable(source_), element.line), found, expected);
  }

  int parent(int index) const { return index < 0 ? -1 : elements_[index].parent; }

  const XmlElement* array_of(int holder, const std::string& id) const {
    for (const XmlElement& element : elements_) {
      const std::string* own = element.find("id");
      if (element.parent == holder && element.tag == "float_array" && own != nullptr && *own == id) return &element;
    }
    return nullptr;
  }

  void check(std::size_t index) const {
    const XmlElement& accessor = elements_[index];
    const std::string* of = accessor.find("source");
    const XmlElement* array = of == nullptr || of->empty() ? nullptr : array_of(parent(accessor.parent), of->substr(1));
    if (array == nullptr) refuse_at(accessor, "an <accessor> of something else", "of the <float_array> beside it");
    double parameters = 0.0;
    for (const XmlElement& element : elements_) parameters += element.parent == static_cast<int>(index);
    const double stride = number_or(accessor, "stride", 1.0), count = number_or(accessor, "count", 0.0);
    const double end = number_or(accessor, "offset", 0.0) + count * stride, held = number_or(*array, "count", 0.0);
    if (stride < std::max(1.0, parameters) || stride > kMostStride || end > held)
      refuse_at(accessor,
                fmt::format("{:.0f} numbers by steps of {:.0f} for {:.0f} parameters", end, stride, parameters),
                fmt::format("the {:.0f} numbers that there are", held));
  }

  static constexpr double kMostStride = 64.0;
  static constexpr int kMostAccessors = 1000;  // each looks through all elements
  const std::vector<XmlElement>& elements_;
  const std::string& source_;
  std::set<std::string> ids_;
};

/// Well-formed and shallow, and no nodes made of other nodes: those could hold themselves.
void check_collada(const std::string& bytes, const std::string& source) {
  const std::vector<XmlElement> elements = scan_xml(bytes, source);
  if (elements.front().tag != "COLLADA") refuse(source, "<" + printable(elements.front().tag, 40) + ">", "<COLLADA>");
  check_lists(bytes, source);
  SourceCheck(elements, source).run();
  for (const XmlElement& element : elements) {
    check_promises(element, bytes, source);
    if (element.tag == "instance_node")
      throw InputError(fmt::format("{}:{}", printable(source), element.line), "<instance_node>",
                       "nodes that hold their meshes themselves");
  }
}

void check_faces(const aiScene& scene, const std::string& source, const MeshLimits& limits) {
  std::size_t triangles = 0;
  for (unsigned m = 0; m < scene.mNumMeshes; ++m) {
    for (unsigned f = 0; f < scene.mMeshes[m]->mNumFaces; ++f) {
      const unsigned corners = scene.mMeshes[m]->mFaces[f].mNumIndices;
      if (corners > kMostCorners)
        refuse(source, fmt::format("a face of {} corners", corners), fmt::format("at most {}", kMostCorners));
      triangles += corners;
    }
  }
  if (triangles > 4 * limits.triangles)
    refuse(source, fmt::format("{} corners of faces", triangles), fmt::format("at most {}", 4 * limits.triangles));
}

/// Gathers the scene's pieces where their nodes place them; corners at one point become one vertex.
class Gatherer {
 public:
  Gatherer(const aiScene& scene, const std::string& source, const MeshLimits& limits)
      : scene_(scene), source_(source), limits_(limits) {}

  Mesh run() {
    struct Entry {
      const aiNode* node;
      aiMatrix4x4 place;
    };
    std::vector<Entry> open{{scene_.mRootNode, scene_.mRootNode->mTransformation}};
    for (int count = 0; !open.empty(); ++count) {
      if (count == kMostPlaces) refuse(source_, fmt::format("more than {} nodes", kMostPlaces), "fewer");
      const Entry at = open.back();
      open.pop_back();
      for (unsigned i = 0; i < at.node->mNumMeshes; ++i) add(*scene_.mMeshes[at.node->mMeshes[i]], at.place);
      for (unsigned i = at.node->mNumChildren; i-- > 0;)
        open.push_back({at.node->mChildren[i], at.place * at.node->mChildren[i]->mTransformation});
    }
    if (out_.triangles.empty()) refuse(source_, "no triangles", "a mesh");
    return std::move(out_);
  }

 private:
  void add(const aiMesh& piece, const aiMatrix4x4& place) {
    std::vector<std::uint32_t> index(piece.mNumVertices);
    for (unsigned v = 0; v < piece.mNumVertices; ++v) index[v] = vertex(place * piece.mVertices[v]);
    const bool mirrored = place.Determinant() < 0;
    for (unsigned f = 0; f < piece.mNumFaces; ++f) {
      const aiFace& face = piece.mFaces[f];
      if (face.mNumIndices != 3) continue;  // points and lines
      std::array<std::uint32_t, 3> corners{};
      for (unsigned k = 0; k < 3; ++k) {
        if (face.mIndices[k] >= piece.mNumVertices)
          refuse(source_, fmt::format("vertex {} of {}", face.mIndices[k], piece.mNumVertices), "one that is there");
        corners[k] = index[face.mIndices[k]];
      }
      if (corners[0] == corners[1] || corners[1] == corners[2] || corners[2] == corners[0]) continue;
      if (mirrored) std::swap(corners[1], corners[2]);
      if (out_.triangles.size() == limits_.triangles)
        refuse(source_, fmt::format("more than {} triangles", limits_.triangles), "fewer");
      out_.triangles.push_back(corners);
    }
  }

  std::uint32_t vertex(const aiVector3D& at) {
    if (!std::isfinite(at.x) || !std::isfinite(at.y) || !std::isfinite(at.z))
      refuse(source_, "a vertex that is not finite", "finite numbers");
    const auto next = static_cast<std::uint32_t>(out_.vertices.size());
    const auto [found, fresh] = known_.try_emplace({at.x, at.y, at.z}, next);
    if (fresh) out_.vertices.emplace_back(at.x, at.y, at.z);
    return found->second;
  }

  const aiScene& scene_;
  const std::string& source_;
  const MeshLimits& limits_;
  Mesh out_;
  std::map<std::array<float, 3>, std::uint32_t> known_;
};

const aiScene& imported(Assimp::Importer& importer, const std::string& name, const std::string& source,
                        const MeshLimits& limits) {
  importer.SetPropertyBool(AI_CONFIG_IMPORT_COLLADA_IGNORE_UP_DIRECTION, true);  // as ROS does: z stays z
  const aiScene* scene = nullptr;
  std::string reason;
  try {
    scene = importer.ReadFile(name, aiProcess_ValidateDataStructure);
    if (scene != nullptr && scene->mRootNode != nullptr) check_faces(*scene, source, limits);
    if (scene != nullptr) scene = importer.ApplyPostProcessing(aiProcess_Triangulate);
  } catch (const InputError&) {
    throw;
  } catch (const std::exception& error) {
    reason = error.what(), scene = nullptr;
  }
  if (scene == nullptr || scene->mRootNode == nullptr) {
    if (reason.empty()) reason = importer.GetErrorString();
    refuse(source, "no usable mesh (" + printable(reason.empty() ? "no reason given" : reason, 200) + ")",
           "an STL, OBJ or Collada file");
  }
  return *scene;
}

}  // namespace

bool meshes_available(std::string* reason) {
  if (reason != nullptr) reason->clear();
  return true;
}

Mesh read_mesh(const std::string& bytes, const std::string& format, const std::string& source,
               const MeshLimits& limits) {
  if (bytes.size() > limits.file_bytes)
    refuse(source, fmt::format("{} bytes", bytes.size()), fmt::format("at most {}", limits.file_bytes));
  if (format == "stl") {
    check_stl(bytes, source, limits);
  } else if (format == "obj") {
    check_lines(bytes, source);
  } else if (format == "dae") {
    check_collada(bytes, source);
  } else {
    refuse(source, quoted(format), "stl, obj or dae");
  }
  const std::string name = "mesh." + format;
  Assimp::Importer importer;
  importer.SetIOHandler(new OneFile(name, bytes));  // the importer deletes it
  const aiScene& scene = imported(importer, name, source, limits);
  return scaled(Gatherer(scene, source, limits).run(), Eigen::Vector3d::Ones(), source,
                {.size = std::numeric_limits<float>::max()});
}

}  // namespace lacuna
