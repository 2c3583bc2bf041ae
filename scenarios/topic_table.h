// Messages of a bag, topic by topic, as columns with the topic's own clock.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "scenarios/clocks.h"
#include "scenarios/ros_message.h"

namespace lacuna {

/// Columns are `<topic>/<joint>/<quantity>`, `<topic>/<quantity>` or `<topic>/<quantity>[i]`. The messages of a topic
/// that name other joints than those before (two publishers) have a clock of their own.
class TopicTable {
 public:
  /// `log_times`: the clock is the time of receipt, whatever headers say.
  TopicTable(std::string file, const RecordingLimits& limits, bool log_times);
  ~TopicTable();
  TopicTable(const TopicTable&) = delete;
  TopicTable& operator=(const TopicTable&) = delete;

  /// Handle of a topic, -1 where nothing can be read of it (another type or encoding than those known): a note says so.
  /// The same topic may be declared again; another type then is an InputError.
  int declare(const std::string& topic, const std::string& type, const std::string& encoding);

  /// One message, received at `log_ns`. A message that cannot be read makes its topic unread (UnreadTopic), and the
  /// rest of that topic is passed over. Throws InputError where the numbers of all topics pass the limit of bytes.
  void add(int handle, std::int64_t log_ns, std::string_view message);

  /// Messages in the order of their receipt. A topic's clock is its headers' where each message has a stamp that is not
  /// 0, else the times of receipt; of two messages of one time the later stays. Times that run backwards and infinite
  /// values make a topic unread. Columns without any number go. Throws InputError where no topic is left.
  TrackSet take();

 private:
  struct Group;
  struct Layout;
  struct Topic;

  Layout& layout_of(Topic& topic);
  void add_fields(Topic& topic, std::int64_t log_ns);
  void finish(Topic& topic, TrackSet& out) const;
  Track track_of(const Topic& topic, Group& group, std::size_t groups, std::size_t& twice) const;

  std::string file_;
  RecordingLimits limits_;
  bool log_times_;
  std::vector<std::unique_ptr<Topic>> topics_;
  std::map<std::string, int> handles_;
  std::map<std::string, std::string> others_;  ///< topics of no use, and why
  RosMessage message_;
  std::uintmax_t values_ = 0;
};

}  // namespace lacuna
