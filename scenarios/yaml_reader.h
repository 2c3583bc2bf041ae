// YAML as a tree that knows where everything stood, read with errors that name file, line and key.
//
// Anchors, aliases, tags, more than one document, duplicate keys, deep nesting and oversized files are refused while
// reading: what comes out is plain maps, lists and scalars.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace lacuna {

struct YamlNode {
  enum class Kind { null, scalar, list, map };
  Kind kind = Kind::null;
  int line = 0;                   ///< 1 is the first
  bool quoted = false;            ///< scalar written in quotes: text, never a number
  std::string text;               ///< of a scalar
  std::vector<YamlNode> items;    ///< of a list; of a map the values, one per key
  std::vector<std::string> keys;  ///< of a map, in the order written, unique
};

/// A node, the file it came from and the keys that lead to it. Cheap to copy; the tree must outlive it.
class YamlCursor {
 public:
  YamlCursor(const YamlNode& node, std::string file) : node_(&node), file_(std::move(file)) {}

  /// "file:line: key.key[2]", as messages begin.
  std::string where() const;
  int line() const { return node_->line; }
  bool is_map() const { return node_->kind == YamlNode::Kind::map; }
  bool is_list() const { return node_->kind == YamlNode::Kind::list; }
  bool is_scalar() const { return node_->kind == YamlNode::Kind::scalar; }
  bool is_empty() const { return node_->text.empty() && node_->items.empty(); }  ///< null, "", [] or {}

  /// Throws InputError: found what stands here, expected `expected`.
  [[noreturn]] void fail(const std::string& expected) const;

  /// Throws unless this is a map whose keys are all among `keys`.
  void expect_keys(const std::vector<std::string>& keys) const;
  std::optional<YamlCursor> find(const std::string& key) const;     ///< of a map; null values count as present
  YamlCursor at(const std::string& key) const;                      ///< throws where the key is absent
  std::vector<std::pair<std::string, YamlCursor>> entries() const;  ///< throws unless a map
  std::vector<YamlCursor> items() const;                            ///< throws unless a list

  std::string text() const;                 ///< a scalar that is not empty
  double number() const;                    ///< finite
  double positive_number() const;           ///< finite, above 0
  std::pair<double, double> range() const;  ///< [lower, upper], lower below upper

 private:
  YamlCursor child(const YamlNode& node, const std::string& step) const;

  const YamlNode* node_;
  std::string file_;
  std::string path_;
};

/// Limits against hostile files.
inline constexpr std::size_t kYamlMaxBytes = std::size_t{1} << 20;
inline constexpr int kYamlMaxDepth = 32;

/// Parses one document; `file` names it in messages.
YamlNode parse_yaml(const std::string& text, const std::string& file);

}  // namespace lacuna
