// The skeleton of a URDF: names, order, tree and lines, checked before urdfdom reads the rest.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "scenarios/xml_scan.h"

namespace lacuna {

struct UrdfOutline {
  struct LinkEntry {
    std::string name;
    std::string where;  ///< "file:line: link NAME"
    int joint = -1;     ///< joint that carries the link; -1 for the root
  };
  struct JointEntry {
    std::string name;
    std::string type;
    std::string where;
    int parent = -1, child = -1;  ///< indices into `links`
  };
  std::vector<LinkEntry> links;    ///< in the order written
  std::vector<JointEntry> joints;  ///< parents before children, else in the order written
  int root = -1;
};

/// Throws InputError: element structure, numbers that are none or not finite, unknown joint types, names given twice,
/// links that do not exist, two parents, cycles, two roots, no root.
UrdfOutline outline_urdf(const std::vector<XmlElement>& elements, const std::string& source);

}  // namespace lacuna
