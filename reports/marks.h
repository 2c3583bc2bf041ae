// When and where something acts, told to the page's scripts: what is said of it in the page lights up its times in the
// plots and its joint in the replay (reports/page/marks.js).
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "reports/html.h"

namespace lacuna {

class Marks {
 public:
  struct Time {
    std::string recording;          ///< empty: every one
    double begin = 0.0, end = 0.0;  ///< s
  };
  /// The style of the element that says it; the row or the card that it stands in is what lights up.
  std::string add(const std::string& joint, std::vector<Time> times);
  /// To be put anywhere into the page; nothing where nothing was added.
  Html data() const;

 private:
  struct Mark {
    std::string joint;
    std::vector<Time> times;
  };
  std::vector<Mark> marks_;
};

}  // namespace lacuna
